"""Distributions of layered materials' parameters: Table 2 of Fan et al. (2022) and its extension.

A distribution is a frozen dataclass; `sample` draws a table of single-channel stacks that all have
the same number of coats and the same kind of bottom. Mixtures are lists of distributions.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from urushi.checks import MIN_ALPHA, TRAINED_DEPTH, TRAINED_G, TRAINED_WIDTH_RATIO, Widths
from urushi.errors import ParameterError
from urushi.walk.bottoms import KINDS
from urushi.walk.bottoms.bottom import Family, Kind, draw_alpha
from urushi.walk.table import StackTable

#: Maximum number of coats of a trained stack: five coats over a bottom have six interfaces.
MAX_COATS = 5


def _is_drawn(kind: Kind) -> bool:
    return kind.family.draw is not Family.draw


#: The kinds of bottoms of isotropic stacks.
BOTTOMS = tuple(name for name, kind in KINDS.items() if _is_drawn(kind) and kind.widths == 1)

#: The kinds of bottoms of anisotropic stacks. Where a kind has two widths, they may be equal.
ANISOTROPIC_BOTTOMS = tuple(
    name for name, kind in KINDS.items() if _is_drawn(kind) and f"{name}_anisotropic" not in KINDS
)

#: Share of anisotropic stacks whose coats all have equal widths, where the bottom has not.
ISOTROPIC_COATS = 0.3


def draw_widths(rng: np.random.Generator, mean: np.ndarray) -> Widths:
    """Two widths in [0.01, 1] of this geometric mean, see `Anisotropic`."""
    limit = np.log(TRAINED_WIDTH_RATIO)
    quotient = np.exp(rng.uniform(-limit, limit, np.shape(mean)))
    quotient = np.where(rng.random(np.shape(mean)) < 0.2, 1.0, quotient)
    root = np.sqrt(quotient)
    return Widths(np.clip(mean * root, MIN_ALPHA, 1.0), np.clip(mean / root, MIN_ALPHA, 1.0))


def whole_eta(rng: np.random.Generator, shape: int | tuple[int, ...]) -> np.ndarray:
    """Indices in [0.5, 3], of coats under air, or under a denser or thinner medium.

    55 % are U(1.05, 2), 10 % U(2, 3), 25 % U(0.5, 0.96). In the last 10 %, |eta - 1| is log-uniform
    in [0.004, 0.05], on either side of 1.
    """
    near = np.exp(rng.uniform(np.log(0.004), np.log(0.05), shape))
    near = 1 + np.where(rng.integers(2, size=shape) == 0, -near, near)
    ranges = (1.05, 2.0), (2.0, 3.0), (0.5, 0.96)
    parts = (*(rng.uniform(*ends, shape) for ends in ranges), near)
    return np.choose(rng.choice(len(parts), shape, p=(0.55, 0.1, 0.25, 0.1)), parts)


#: Indices of refraction by name: functions of a generator and a shape. "common" is the range of
#: Table 2, "whole" all of [0.5, 3]. "low" are interfaces to a thinner medium, with total reflection
#: from above, for evaluation.
DRAW_ETA: dict[str, Callable[[np.random.Generator, int | tuple[int, ...]], np.ndarray]] = {
    "common": lambda rng, shape: rng.uniform(1.05, 2.0, shape),
    "whole": whole_eta,
    "low": lambda rng, shape: rng.uniform(0.5, 0.96, shape),
}


class _Independent:
    """Stacks that are drawn independently of each other."""

    coats: int

    def __post_init__(self) -> None:
        if self.coats not in range(MAX_COATS + 1):
            raise ParameterError(
                f"coats is {self.coats!r}; it must be an integer from 0 to {MAX_COATS}"
            )

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
    """

    # Dielectric interfaces, each with a medium below. The "two layers" of Fan et al. are one coat.
    coats: int = 1
    bottom: ClassVar[str] = "conductor"
    widths: ClassVar[int] = 1

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        shape = (n, self.coats)
        return StackTable(
            kind=self.bottom,
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
    """

    coats: int = 1  # as in `Table2`
    bottom: str = "conductor"  # one of `BOTTOMS`; its parameters are drawn by its family
    indices: str = "common"  # eta of coats and of "dielectric" bottoms, a key of `DRAW_ETA`
    widths: ClassVar[int] = 1
    bottoms: ClassVar[tuple[str, ...]] = BOTTOMS

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.bottom not in self.bottoms:
            raise ParameterError(
                f"bottom is {self.bottom!r}; choose one of {', '.join(self.bottoms)}"
            )
        if self.indices not in DRAW_ETA:
            raise ParameterError(
                f"indices is {self.indices!r}; choose one of {', '.join(DRAW_ETA)}"
            )

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        return self._of_widths(rng, draw_alpha(rng, (n, self.coats)))

    def _of_widths(
        self, rng: np.random.Generator, alpha: Any, sigma_t: np.ndarray | None = None
    ) -> StackTable:
        """Stacks with these widths (n, coats) of the coats; sigma_t: theirs, None: drawn."""
        n, _ = shape = np.shape(alpha.u if isinstance(alpha, Widths) else alpha)
        return StackTable(
            kind=self.bottom,
            alpha=alpha,
            eta=DRAW_ETA[self.indices](rng, shape),
            albedo=1 - rng.uniform(0.0, 1.0, shape) ** 2,
            sigma_t=TRAINED_DEPTH * rng.uniform(0.0, 1.0, shape) ** 2
            if sigma_t is None
            else sigma_t,
            g=rng.uniform(*TRAINED_G, shape),
            bottom=self._draw_bottom(rng, n),
        )

    def _draw_bottom(self, rng: np.random.Generator, n: int) -> dict[str, np.ndarray]:
        kind = KINDS[self.bottom]
        columns = kind.family.draw(rng, n, DRAW_ETA[self.indices])
        if kind.widths == 2:
            for name in [name for name in columns if name not in kind.parameters]:
                widths = draw_widths(rng, columns.pop(name))
                columns |= {f"{name}_u": widths.u, f"{name}_v": widths.v}
        return {name: columns[name] for name in kind.parameters}


@dataclass(frozen=True)
class Clear(Extended):
    """`Extended` with clear or optically thin media, such as varnish.

    sigma_t = max(0, U(-0.3, 0.3)). No medium blurs the lobes of the interfaces, so that these
    stacks are the hardest to predict.
    """

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        table = super().sample(rng, n)
        table.sigma_t[:] = np.maximum(rng.uniform(-0.3, 0.3, table.sigma_t.shape), 0.0)
        return table


@dataclass(frozen=True)
class Practical(Extended):
    """Coats as people build them: varnish, lacquer, enamel, glaze, car paint, coated metal.

    Each medium has an absolute index, and the interfaces have their ratios. The topmost index is
    U(1.3, 1.8), for a tenth of the stacks U(1.8, 3). A medium below another one has about the same
    index (30 %, within 5 %), a higher one (25 %, up to 1.3 times), a lower one (25 %, down to 0.8
    times), or is a gap of air (20 %). Below a gap it is U(1.3, 1.8), and below indices from 2 on
    there is a lower one in place of the gap. Media are clear (40 %, and all gaps), tinted without
    scattering (20 %), lossless (10 %) or as in `Extended`. Widths of coats and bottoms are
    log-uniform in [0.01, 0.5]. The index of a complex conductor is divided by the index of the
    medium above it.
    """

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        shape = (n, self.coats)
        index, gap = self._draw_indices(rng, n)
        above = np.concatenate([np.ones((n, 1)), index[:, :-1]], axis=1)
        medium = rng.choice(4, shape, p=(0.4, 0.2, 0.1, 0.3))
        depths = (most * rng.uniform(0.0, 1.0, shape) ** 2 for most in (2.0, *2 * [TRAINED_DEPTH]))
        depth = np.choose(medium, (np.zeros(shape), *depths))
        scattered = 1 - rng.uniform(0.0, 1.0, shape) ** 2
        bottom = self._draw_bottom(rng, n)
        if "k" in bottom:
            bottom["eta"], bottom["k"] = bottom["eta"] / index[:, -1], bottom["k"] / index[:, -1]
        if "reflectance" in bottom:
            bottom["reflectance"] = 1 - rng.uniform(0.0, 1.0, n) ** 2
        if "alpha" in bottom:
            bottom["alpha"] = smooth_alpha(rng, n)
        return StackTable(
            kind=self.bottom,
            alpha=smooth_alpha(rng, shape),
            eta=np.clip(index / above, 0.5, 3.0),
            albedo=np.choose(medium, (scattered, np.zeros(shape), np.ones(shape), scattered)),
            sigma_t=np.where(gap, 0.0, depth),
            g=rng.uniform(*TRAINED_G, shape),
            bottom=bottom,
        )

    def _draw_indices(self, rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
        """The absolute index of every medium (n, coats), and whether it is a gap of air."""
        dense = rng.random(n) < 0.1
        top = np.where(dense, rng.uniform(1.8, 3.0, n), rng.uniform(1.3, 1.8, n))
        indices, gaps = [top], [np.zeros(n, bool)]
        for _ in range(self.coats - 1):
            before, in_air = indices[-1], gaps[-1]
            which = rng.choice(4, n, p=(0.3, 0.25, 0.25, 0.2))
            near, ranges = np.exp(rng.uniform(-0.05, 0.05, n)), ((1.05, 1.3), *2 * [(0.8, 0.95)])
            factor = np.choose(which, (near, *(rng.uniform(*ends, n) for ends in ranges)))
            gap = (which == 3) & ~in_air & (before < 2.0)
            solid = np.where(in_air, rng.uniform(1.3, 1.8, n), before * factor)
            indices.append(np.where(gap, 1.0, solid))
            gaps.append(gap)
        return np.stack(indices, axis=1), np.stack(gaps, axis=1)


def smooth_alpha(rng: np.random.Generator, shape: int | tuple[int, ...]) -> np.ndarray:
    """Log-uniform in [0.01, 0.5]: half of the surfaces are smoother than 0.07."""
    return np.exp(rng.uniform(np.log(MIN_ALPHA), np.log(0.5), shape)).clip(MIN_ALPHA, 0.5)


@dataclass(frozen=True)
class Anisotropic(Extended):
    """`Extended` with two widths of every coat, and of bottoms of an "..._anisotropic" kind.

    The widths have the geometric mean of `Extended` and a quotient that is log-uniform in
    [1/8, 8]; for a fifth of the surfaces it is one. Of the stacks whose bottom has two widths, the
    share `ISOTROPIC_COATS` has coats of one width only.
    """

    bottom: str = "conductor_anisotropic"  # one of `ANISOTROPIC_BOTTOMS`
    clear: bool = False  # whether media are clear or thin, as in `Clear`
    widths: ClassVar[int] = 2
    bottoms: ClassVar[tuple[str, ...]] = ANISOTROPIC_BOTTOMS

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        shape = (n, self.coats)
        alpha = draw_widths(rng, draw_alpha(rng, shape))
        if KINDS[self.bottom].widths == 2:
            plain = rng.random((n, 1)) < ISOTROPIC_COATS
            alpha = Widths(alpha.u, np.where(plain, alpha.u, alpha.v))
        thin = np.maximum(rng.uniform(-0.3, 0.3, shape), 0.0)
        return self._of_widths(rng, alpha, thin if self.clear else None)


#: Distributions from which any number of stacks can be drawn.
Distribution = Table2 | Extended


class Source(Protocol):
    """The source of a data store's part: a frozen dataclass, a `Distribution` or an extension's."""

    @property
    def coats(self) -> int: ...  # of every stack

    @property
    def widths(self) -> int: ...  # GGX widths of a coat: 2 if it may be anisotropic, otherwise 1

    @property
    def bottom(self) -> str: ...  # the kind of every stack's bottom, a key of `KINDS`

    def draw(self, rng: np.random.Generator, rows: slice) -> StackTable: ...


def to_dict(distribution: Source) -> dict[str, Any]:
    """Describe a distribution for JSON.

    Common indices are left out: descriptions from before `Extended.indices` stay equal to new ones.
    """
    fields = asdict(distribution)  # type: ignore[call-overload]
    if fields.get("indices") == "common":
        del fields["indices"]
    return {"kind": type(distribution).__name__.lower(), **fields}
