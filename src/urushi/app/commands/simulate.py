"""`urushi simulate`: the reference's BRDF of a described material."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro

from urushi.errors import FileError, ParameterError
from urushi.files import atomic_write

#: Polar angles of the printed table, in degrees; negative ones lie on the light's side.
POLAR_DEGREES = tuple(range(-80, 81, 10))


@dataclass(frozen=True)
class Simulate:
    """Simulate a layered material without bias: f [1/sr] and its standard error.

    The material is described as in Python. Prints a table over the plane of incidence, or takes the
    directions of a file; --output keeps wi, wo, f and se.

    Example: urushi simulate "coat(conductor(alpha=0.2, r0=0.9), alpha=0.05, eta=1.5, sigma_t=1)"
    """

    description: tyro.conf.Positional[str]
    """coat(...), conductor(...), dielectric(...) or diffuse(...), coats nested."""
    incidence: float = 30.0
    """Angle of wi to the normal, in degrees, in [0, 90)."""
    pairs: Path | None = None
    """NPZ file with wi and wo, both (N, 3), to be used in place of the table."""
    walks: int = 4096
    """Random walks per pair of directions and channel."""
    seed: int = 0
    """Seed of the random numbers."""
    output: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """NPZ file to write."""

    def run(self) -> int:
        from urushi.app.describe import describe

        description = describe(self.description)
        wi, wo = self._plane() if self.pairs is None else read_pairs(self.pairs)
        f, se = evaluate(description, wi, wo, walks=self.walks, seed=self.seed)
        if self.output is not None:
            with atomic_write(self.output) as temporary, temporary.open("wb") as file:
                np.savez(file, wi=wi, wo=wo, f=f, se=se)
            print(self.output)
        elif self.pairs is None:
            print(table(self.incidence, f, se))
        else:
            print(rows(wi, wo, f, se))
        return 0

    def _plane(self) -> tuple[np.ndarray, np.ndarray]:
        """Directions in the plane of incidence; the mirror direction has a positive angle."""
        if not 0 <= self.incidence < 90:
            raise ParameterError(
                f"--incidence is {self.incidence:g}; it must be in [0, 90) degrees"
            )
        wo = _polar(-np.array(POLAR_DEGREES, float))
        return np.repeat(_polar(np.array([self.incidence])), len(wo), axis=0), wo


def evaluate(
    description: Any, wi: np.ndarray, wo: np.ndarray, *, walks: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """f and its standard error, (N, 3) each; a surface without a coat is evaluated exactly."""
    import urushi
    from urushi.reference import evaluate as exact

    if isinstance(description, urushi.Stack):
        return urushi.simulate(description, wi, wo, walks=walks, seed=seed)
    f = exact.f(description, wi, wo)
    return f, np.zeros_like(f)


def read_pairs(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """The arrays wi and wo of an NPZ file."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            return archive["wi"], archive["wo"]
    except KeyError as error:
        raise FileError(f"'{path}' must hold the arrays wi and wo; {error.args[0]}") from error
    except (OSError, ValueError, EOFError, AttributeError, TypeError) as error:
        reason = "it does not exist" if not path.exists() else "it is no NPZ file"
        raise FileError(f"cannot read '{path}': {reason}; write it by numpy.savez") from error


def table(incidence: float, f: np.ndarray, se: np.ndarray) -> str:
    """The plane of incidence as text, one polar angle a line."""
    lines = [
        f"f [1/sr] ± standard error for light from {incidence:g}°; "
        "the mirror direction is on the positive side",
        f"{'angle':>6}  {'red':>21}  {'green':>21}  {'blue':>21}",
    ]
    for angle, values, errors in zip(POLAR_DEGREES, f, se, strict=True):
        lines.append(f"{angle:>5}°  {_cells(values, errors)}")
    return "\n".join(lines)


def rows(wi: np.ndarray, wo: np.ndarray, f: np.ndarray, se: np.ndarray) -> str:
    """Pairs as text, one a line: wi, wo, then f and standard error per channel."""
    lines = [f"{'wi':>24}  {'wo':>24}  f [1/sr] ± standard error"]
    for i, o, values, errors in zip(wi, wo, f, se, strict=True):
        directions = "  ".join(" ".join(f"{x:>7.4f}" for x in w).rjust(24) for w in (i, o))
        lines.append(f"{directions}  {_cells(values, errors)}")
    return "\n".join(lines)


def _cells(values: np.ndarray, errors: np.ndarray) -> str:
    return "  ".join(f"{v:>10.5g} ± {e:>8.2g}" for v, e in zip(values, errors, strict=True))


def _polar(degrees: np.ndarray) -> np.ndarray:
    theta = np.radians(degrees)
    return np.stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)], -1).astype(np.float32)
