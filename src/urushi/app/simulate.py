"""`urushi simulate`: BRDF values and albedos of a described material by the reference walk."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro

from urushi.core.directions import rotated
from urushi.errors import ParameterError
from urushi.files import atomic_write, read_npz
from urushi.ranges import Angle, Incidence, Seed, Walks

#: Polar angles of the printed table [degrees]; negative ones are on the light's side.
POLAR_DEGREES = tuple(range(-80, 81, 10))
#: Angles of incidence of the printed albedos [degrees].
INCIDENCE_DEGREES = tuple(range(0, 90, 15))
_HEADS = f"{'red':>21}  {'green':>21}  {'blue':>21}"


@dataclass(frozen=True)
class Simulate:
    """Simulate the BRDF of a layered material without bias: f [1/sr] and its standard error.

    The material is described as in Python. Prints f in the plane of incidence, or f at the pairs of
    directions of a file (--pairs), or the directional albedo (--albedo). With --output the numbers
    go to a file instead.

    Example: urushi simulate "coat(conductor(alpha=0.2, r0=0.9), alpha=0.05, ior=1.5, sigma_t=1)"
    """

    description: tyro.conf.Positional[str]
    """Material: coat(...), slab(...), conductor(...), dielectric(...) or diffuse(...); nested."""
    incidence: Incidence = 30.0
    """Angle between the incident direction and the normal [degrees], in [0, 90)."""
    azimuth: Angle = 0.0
    """Angle of the plane of incidence about the normal, from the tangent [degrees]."""
    pairs: Path | None = None
    """NPZ file with arrays wi and wo, (N, 3) unit vectors, that replace the plane of incidence.
    Those of a slab may be on either side."""
    albedo: bool = False
    """Print the directional albedo, the reflected fraction of light, instead of f."""
    walks: Walks = 4096
    """Random walks per pair of directions (or per angle of incidence) and channel."""
    seed: Seed = 0
    """Seed of the random numbers."""
    output: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """NPZ file to write the numbers to. Default: print them."""

    def run(self) -> int:
        if self.output is not None and self.output.suffix != ".npz":
            raise ParameterError(f"--output is '{self.output}'; give a name that ends in .npz")
        import urushi
        from urushi.app.describe import describe
        from urushi.walk import analytic
        from urushi.walk.simulate import albedo

        described = describe(self.description)
        options: dict[str, Any] = {"walks": self.walks, "seed": self.seed}
        layered = isinstance(described, urushi.Stack)
        if self.albedo:
            if not layered:
                raise ParameterError("--albedo needs a stack; describe one by coat(...)")
            wi = self._turned(_polar(np.array(INCIDENCE_DEGREES, float)))
            found, se = albedo(described, wi, **options)
            text = table("directional albedo ± standard error", INCIDENCE_DEGREES, found, se)
            return self._print_or_save(text, wi=wi, albedo=found, se=se)
        if self.pairs is None:  # the plane of incidence; the mirror direction has a positive angle
            wo = self._turned(_polar(-np.array(POLAR_DEGREES, float)))
            wi = np.repeat(self._turned(_polar(np.array([self.incidence]))), len(wo), axis=0)
        else:
            wi, wo = read_npz(self.pairs, "wi", "wo")
        if layered:
            f, se = urushi.simulate(described, wi, wo, **options)
        else:  # exact
            f = analytic.f(described, wi, wo)
            se = np.zeros_like(f)
        title = (
            f"f [1/sr] ± standard error for light from {self.incidence:g}°; "
            "the mirror direction is on the positive side"
        )
        plane = self.pairs is None
        text = table(title, POLAR_DEGREES, f, se) if plane else rows(wi, wo, f, se)
        return self._print_or_save(text, wi=wi, wo=wo, f=f, se=se)

    def _print_or_save(self, text: str, **arrays: np.ndarray) -> int:
        """Write the arrays to the output file, or print the text if there is none."""
        if self.output is None:
            print(text)
            return 0
        with atomic_write(self.output) as temporary, temporary.open("wb") as file:
            np.savez(file, **arrays)  # type: ignore[arg-type]  # numpy's stub takes no keywords
        print(self.output)
        return 0

    def _turned(self, w: np.ndarray) -> np.ndarray:
        """Directions (N, 3) of the xz plane, in the plane of incidence."""
        return w if self.azimuth == 0 else rotated(w, self.azimuth / 360.0)


def table(title: str, degrees: Iterable[float], values: np.ndarray, se: np.ndarray) -> str:
    """Values (N, 3) and standard errors as text, one angle per line."""
    lines = [title, f"{'angle':>6}  {_HEADS}"]
    for angle, numbers, errors in zip(degrees, values, se, strict=True):
        lines.append(f"{angle:>5}°  {_cells(numbers, errors)}")
    return "\n".join(lines)


def rows(wi: np.ndarray, wo: np.ndarray, f: np.ndarray, se: np.ndarray) -> str:
    """Pairs as text, one per line: wi, wo, then f and standard error of each channel."""
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
