"""Distributions of layered materials' parameters: Table 2 of Fan et al. (2022) and its extension.

A distribution is a frozen dataclass; `sample` draws a table of single-channel stacks that all have
the same number of coats and the same kind of bottom. Mixtures are lists of distributions.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from urushi.checks import TRAINED_DEPTH, TRAINED_G, Widths
from urushi.data.draws import DRAW_BOTTOM, DRAW_ETA, draw_alpha, draw_widths
from urushi.errors import ParameterError
from urushi.walk.table import BOTTOM_KINDS, StackTable

#: Maximum number of coats of a trained stack: five coats over a bottom have six interfaces.
MAX_COATS = 5

#: The kinds of bottoms of isotropic stacks.
BOTTOMS = ("conductor", "conductor_complex", "dielectric", "diffuse", "mixture", "measured_like")

#: The kinds of bottoms of anisotropic stacks. Where a kind has two widths, they may be equal.
ANISOTROPIC_BOTTOMS = (
    "conductor_anisotropic",
    "conductor_complex_anisotropic",
    "dielectric_anisotropic",
    "mixture_anisotropic",
    "diffuse",
    "measured_like",
)

#: Their parameters, in the order of the data stores.
BOTTOM_PARAMETERS = {
    kind: BOTTOM_KINDS[kind][1] for kind in dict.fromkeys(BOTTOMS + ANISOTROPIC_BOTTOMS)
}

#: Share of anisotropic stacks whose coats all have equal widths, where the bottom has not.
ISOTROPIC_COATS = 0.3


class _Independent:
    """Stacks that are drawn independently of each other."""

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        """Draw n stacks."""
        raise NotImplementedError

    def draw(self, rng: np.random.Generator, rows: slice) -> StackTable:
        """The stacks of some rows of a data store's part; only the number of rows matters."""
        return self.sample(rng, rows.stop - rows.start)


@dataclass(frozen=True)
class Table2(_Independent):
    """Fan et al. 2022, Table 2: rough dielectric coats over a conductor with Schlick's Fresnel.

    alpha = U(0.216, 1)^3, eta = U(1.05, 2), R0 = U(0, 1), albedo = 1 - U(0, 1)^2,
    sigma_t from {0, 1, 2, 5} with equal chances, g = 0.

    Attributes:
        coats: number of dielectric interfaces, each with a medium below. The bottom is not
            counted: the "two layers" of Fan et al. are one coat.
    """

    coats: int = 1
    bottom: ClassVar[str] = "conductor"
    widths: ClassVar[int] = 1

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

    alpha = U(0.01^(1/3), 1)^3, in [0.01, 1]; albedo as in Table 2; sigma_t = 8 U(0, 1)^2 in [0, 8],
    with more thin media than thick ones; g = U(-0.8, 0.9).

    Attributes:
        coats: as in `Table2`.
        bottom: "conductor" (Schlick's R0 = U(0, 1)), "conductor_complex" (eta = U(0.05, 3.5),
            k = U(0.5, 8), about the range of metals), "diffuse" (reflectance = U(0, 1)),
            "dielectric" (the reflection of a rough interface, eta by `indices`), "mixture" (see
            `draws.mixture`) or "measured_like" (see `draws.measured_like`).
        indices: eta of coats and of "dielectric" bottoms: "common" (U(1.05, 2), as in Table 2),
            "whole" (all of [0.5, 3], see `draws.whole_eta`) or "low" (U(0.5, 0.96), for
            evaluation).
    """

    coats: int = 1
    bottom: str = "conductor"
    indices: str = "common"
    widths: ClassVar[int] = 1
    bottoms: ClassVar[tuple[str, ...]] = BOTTOMS

    def __post_init__(self) -> None:
        _check_coats(self.coats)
        if self.bottom not in self.bottoms:
            raise ParameterError(
                f"bottom is {self.bottom!r}; choose one of {', '.join(self.bottoms)}"
            )
        if self.indices not in DRAW_ETA:
            raise ParameterError(
                f"indices is {self.indices!r}; choose one of {', '.join(DRAW_ETA)}"
            )

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        """Draw n stacks."""
        shape = (n, self.coats)
        return _table(
            self.bottom,
            alpha=draw_alpha(rng, shape),
            eta=DRAW_ETA[self.indices](rng, shape),
            albedo=1 - rng.uniform(0.0, 1.0, shape) ** 2,
            sigma_t=TRAINED_DEPTH * rng.uniform(0.0, 1.0, shape) ** 2,
            g=rng.uniform(*TRAINED_G, shape),
            bottom=self._draw_bottom(rng, n),
        )

    def _draw_bottom(self, rng: np.random.Generator, n: int) -> dict[str, np.ndarray]:
        if self.bottom == "dielectric":
            return {"alpha": draw_alpha(rng, n), "eta": DRAW_ETA[self.indices](rng, n)}
        return DRAW_BOTTOM[self.bottom](rng, n)


@dataclass(frozen=True)
class Clear(Extended):
    """`Extended` with clear or optically thin media, such as varnish.

    sigma_t = max(0, U(-0.3, 0.3)). No medium blurs the lobes of the interfaces, which makes these
    stacks the hardest to predict.
    """

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        """Draw n stacks."""
        table = super().sample(rng, n)
        table.sigma_t[:] = np.maximum(rng.uniform(-0.3, 0.3, table.sigma_t.shape), 0.0)
        return table


@dataclass(frozen=True)
class Anisotropic(Extended):
    """`Extended` with two widths of every coat, and of bottoms of an "..._anisotropic" kind.

    The widths have the geometric mean of `Extended` and a quotient that is log-uniform in
    [1/8, 8]; for a fifth of the surfaces it is one. Of the stacks whose bottom has two widths,
    `ISOTROPIC_COATS` have coats of one width only.

    Attributes:
        coats, indices: as in `Extended`.
        bottom: one of `ANISOTROPIC_BOTTOMS`; "mixture_anisotropic" is "mixture" with two widths of
            either lobe.
        clear: whether media are clear or thin, as in `Clear`.
    """

    bottom: str = "conductor_anisotropic"
    clear: bool = False
    widths: ClassVar[int] = 2
    bottoms: ClassVar[tuple[str, ...]] = ANISOTROPIC_BOTTOMS

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        """Draw n stacks."""
        shape = (n, self.coats)
        alpha = draw_widths(rng, draw_alpha(rng, shape))
        if self.bottom in _DRAW_ISOTROPIC:
            plain = rng.random((n, 1)) < ISOTROPIC_COATS
            alpha = Widths(alpha.u, np.where(plain, alpha.u, alpha.v))
        thin = np.maximum(rng.uniform(-0.3, 0.3, shape), 0.0)
        return _table(
            self.bottom,
            alpha=alpha,
            eta=DRAW_ETA[self.indices](rng, shape),
            albedo=1 - rng.uniform(0.0, 1.0, shape) ** 2,
            sigma_t=thin if self.clear else TRAINED_DEPTH * rng.uniform(0.0, 1.0, shape) ** 2,
            g=rng.uniform(*TRAINED_G, shape),
            bottom=self._draw_bottom(rng, n),
        )

    def _draw_bottom(self, rng: np.random.Generator, n: int) -> dict[str, np.ndarray]:
        isotropic = _DRAW_ISOTROPIC.get(self.bottom, self.bottom)
        if isotropic == "dielectric":
            columns = {"alpha": draw_alpha(rng, n), "eta": DRAW_ETA[self.indices](rng, n)}
        else:
            columns = DRAW_BOTTOM[isotropic](rng, n)
        if self.bottom in _DRAW_ISOTROPIC:
            for name in [name for name in columns if name.endswith("alpha")]:
                widths = draw_widths(rng, columns.pop(name))
                columns |= {f"{name}_u": widths.u, f"{name}_v": widths.v}
        return {name: columns[name] for name in BOTTOM_PARAMETERS[self.bottom]}


#: Distributions from which any number of stacks can be drawn.
Distribution = Table2 | Extended


class Source(Protocol):
    """The source of a data store's part: a frozen dataclass, a `Distribution` or a registered one.

    Attributes:
        coats: coats of every stack.
        widths: numbers of a coat's GGX width: 2 if it may be anisotropic, otherwise 1.
        bottom: the kind of its bottom, a key of `BOTTOM_PARAMETERS`.
    """

    @property
    def coats(self) -> int: ...

    @property
    def widths(self) -> int: ...

    @property
    def bottom(self) -> str: ...

    def draw(self, rng: np.random.Generator, rows: slice) -> StackTable: ...


_sources: dict[str, Any] = {
    "table2": Table2,
    "extended": Extended,
    "clear": Clear,
    "anisotropic": Anisotropic,
}


def register_source(kind: str, source: type) -> None:
    """Register another source of parts for data stores, under the name `kind` in their manifest."""
    _sources[kind] = source


def to_dict(distribution: Source) -> dict[str, Any]:
    """Describe a distribution for JSON; `from_dict` reads it back.

    Common indices are left out: descriptions from before `Extended.indices` stay equal to new ones.
    """
    kind = next(name for name, cls in _sources.items() if type(distribution) is cls)
    fields = asdict(distribution)  # type: ignore[call-overload]
    if fields.get("indices") == "common":
        del fields["indices"]
    return {"kind": kind, **fields}


def from_dict(description: Mapping[str, Any]) -> Source:
    """Return the distribution that `to_dict` has described.

    Raises:
        ParameterError: the kind or a field is unknown, or a value is out of range.
    """
    fields = dict(description)
    kind = fields.pop("kind", None)
    if kind not in _sources:
        raise ParameterError(
            f"distribution is of kind {kind!r}; choose one of {', '.join(sorted(_sources))}"
        )
    try:
        return _sources[kind](**fields)
    except TypeError as error:
        raise ParameterError(f"distribution '{kind}' has no such field: {error}") from error


#: Kinds of bottoms of two widths, and the kinds of one width of whose parameters they are drawn.
_DRAW_ISOTROPIC = {
    kind: kind.removesuffix("_anisotropic")
    for kind in ANISOTROPIC_BOTTOMS
    if kind.endswith("_anisotropic")
}


def _check_coats(coats: int) -> None:
    if coats not in range(MAX_COATS + 1):
        raise ParameterError(f"coats is {coats!r}; it must be an integer from 0 to {MAX_COATS}")


def _table(
    kind: str, *, bottom: Mapping[str, np.ndarray], alpha: np.ndarray | Widths, **coats: np.ndarray
) -> StackTable:
    """A table in float32, the precision of the walk."""
    single = np.float32
    return StackTable(
        alpha=alpha.map(single) if isinstance(alpha, Widths) else alpha.astype(single),
        **{name: value.astype(single) for name, value in coats.items()},
        kind=kind,
        bottom={name: value.astype(np.float32) for name, value in bottom.items()},
    )
