"""Distributions of layered materials' parameters: the paper's Table 2, its extension, its edges.

A distribution is a frozen dataclass; `sample` draws a table of single-channel stacks that all have
the same number of coats and the same kind of bottom. Mixtures are lists of distributions.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np

from urushi.data import bottom_draws
from urushi.data.bottom_draws import alpha, log_uniform
from urushi.data.palette import Palette
from urushi.errors import ParameterError
from urushi.nets.features import MIN_ALPHA
from urushi.reference.table import BOTTOM_KINDS, StackTable

#: The deepest recursion that is trained: five coats over a bottom have six interfaces.
MAX_COATS = 5

#: A coat's parameters, in the order of the data stores.
COAT_PARAMETERS = ("alpha", "eta", "albedo", "sigma_t", "g")

#: The parameters of every kind of bottom, in the order of the data stores.
BOTTOM_PARAMETERS = {kind: names for kind, (_, names) in BOTTOM_KINDS.items()}


class _Independent:
    """Stacks that are drawn independently of each other."""

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        """Draw n stacks."""
        raise NotImplementedError

    def draw(self, rng: np.random.Generator, rows: slice) -> StackTable:
        """The stacks of some rows of a data store's part: as many are drawn."""
        return self.sample(rng, rows.stop - rows.start)


@dataclass(frozen=True)
class Table2(_Independent):
    """Fan et al. 2022, Table 2: rough dielectric coats over a conductor with Schlick's Fresnel.

    alpha = U(0.216, 1)^3, eta = U(1.05, 2), R0 = U(0, 1), albedo = 1 - U(0, 1)^2,
    sigma_t from {0, 1, 2, 5} with equal chances, g = 0.

    Attributes:
        coats: number of dielectric interfaces with a medium below; the bottom comes on top of
            that, so that one coat makes the paper's "two layers".
    """

    coats: int = 1
    bottom: ClassVar[str] = "conductor"

    def __post_init__(self) -> None:
        _check_coats(self.coats)

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        """Draw n stacks."""
        shape = (n, self.coats)
        return _table(
            self.bottom,
            alpha=rng.uniform(0.216, 1.0, shape) ** 3,
            eta=rng.uniform(1.05, 2.0, shape),
            albedo=1 - rng.uniform(0.0, 1.0, shape) ** 2,
            sigma_t=rng.choice([0.0, 1.0, 2.0, 5.0], shape),
            g=np.zeros(shape),
            bottom={
                "alpha": rng.uniform(0.216, 1.0, n) ** 3,
                "r0": rng.uniform(0.0, 1.0, n),
            },
        )


@dataclass(frozen=True)
class Extended(_Independent):
    """Table 2 with a continuous sigma_t, anisotropic media and more kinds of bottom.

    alpha = U(0.01^(1/3), 1)^3, hence down to 0.01; eta and albedo as in Table 2;
    sigma_t = 8 U(0, 1)^2 in [0, 8], denser where it is thin; g = U(-0.8, 0.9).

    Attributes:
        coats: as in `Table2`.
        bottom: "conductor" (Schlick's R0 = U(0, 1)), "conductor_complex" (eta = U(0.05, 3.5),
            k = U(0.5, 8), about the range of the metals), "diffuse" (reflectance = U(0, 1)),
            "dielectric" (the reflection of a rough interface, eta = U(1.05, 2)), "mixture" (see
            `bottom_draws`) or "measured_like" (see there as well).
    """

    coats: int = 1
    bottom: str = "conductor"

    def __post_init__(self) -> None:
        _check_coats(self.coats)
        if self.bottom not in BOTTOM_PARAMETERS:
            raise ParameterError(
                f"bottom is {self.bottom!r}; choose one of {', '.join(BOTTOM_PARAMETERS)}"
            )

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        """Draw n stacks."""
        shape = (n, self.coats)
        return _table(
            self.bottom,
            alpha=alpha(rng, shape),
            eta=rng.uniform(1.05, 2.0, shape),
            albedo=1 - rng.uniform(0.0, 1.0, shape) ** 2,
            sigma_t=8 * rng.uniform(0.0, 1.0, shape) ** 2,
            g=rng.uniform(-0.8, 0.9, shape),
            bottom=bottom_draws.UNIFORM[self.bottom](rng, n),
        )


@dataclass(frozen=True)
class Edges(_Independent):
    """The domain of `Extended`, mostly at its edges, which uniform numbers seldom come close to.

    alpha, eta - 1 and sigma_t (from 0.01 on) are log-uniform; of albedos a half are U(0, 1), the
    others 1 less a log-uniform number above 0.001; bottoms as of `bottom_draws.EDGES`.

    Attributes:
        coats, bottom: as in `Extended`; nothing that is measured has such edges.
    """

    coats: int = 1
    bottom: str = "conductor"

    def __post_init__(self) -> None:
        _check_coats(self.coats)
        if self.bottom not in bottom_draws.EDGES:
            raise ParameterError(
                f"bottom is {self.bottom!r}; choose one of {', '.join(bottom_draws.EDGES)}"
            )

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        """Draw n stacks."""
        shape = (n, self.coats)
        bright = 1 - log_uniform(rng, 1e-3, 1.0, shape)
        return _table(
            self.bottom,
            alpha=np.maximum(log_uniform(rng, MIN_ALPHA, 1.0, shape), MIN_ALPHA),
            eta=1 + log_uniform(rng, 0.05, 1.0, shape),
            albedo=np.where(rng.integers(2, size=shape) == 0, rng.uniform(0, 1, shape), bright),
            sigma_t=log_uniform(rng, 0.01, 8.0, shape),
            g=rng.uniform(-0.8, 0.9, shape),
            bottom=bottom_draws.EDGES[self.bottom](rng, n),
        )


#: Endless sources of stacks.
Distribution = Table2 | Extended | Edges

#: What a part of a data store may be drawn from.
Source = Distribution | Palette

_KINDS: dict[str, type[Source]] = {
    "table2": Table2,
    "extended": Extended,
    "edges": Edges,
    "palette": Palette,
}


def to_dict(distribution: Source) -> dict[str, Any]:
    """Describe a distribution for JSON; `from_dict` reads it back."""
    kind = next(name for name, cls in _KINDS.items() if type(distribution) is cls)
    return {"kind": kind, **asdict(distribution)}


def from_dict(description: Mapping[str, Any]) -> Source:
    """Read `to_dict`'s description.

    Raises:
        ParameterError: the kind or a field is unknown, or a value is out of range.
    """
    fields = dict(description)
    kind = fields.pop("kind", None)
    if kind not in _KINDS:
        raise ParameterError(
            f"distribution is of kind {kind!r}; choose one of {', '.join(sorted(_KINDS))}"
        )
    try:
        return _KINDS[kind](**fields)
    except TypeError as error:
        raise ParameterError(f"distribution '{kind}' has no such field: {error}") from error


def _check_coats(coats: int) -> None:
    if coats not in range(MAX_COATS + 1):
        raise ParameterError(f"coats is {coats!r}; it must be an integer from 0 to {MAX_COATS}")


def _table(kind: str, *, bottom: Mapping[str, np.ndarray], **coats: np.ndarray) -> StackTable:
    """A table in float32, as the walk wants it."""
    return StackTable(
        **{name: value.astype(np.float32) for name, value in coats.items()},
        kind=kind,
        bottom={name: value.astype(np.float32) for name, value in bottom.items()},
    )
