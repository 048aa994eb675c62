"""Distributions of layered materials' parameters.

A distribution is a frozen dataclass; `sample` draws a table of single-channel stacks that all have
the same number of coats and the same kind of bottom.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from urushi.checks import MIN_ALPHA, TRAINED_DEPTH, TRAINED_G, CoatParameters
from urushi.core.probe_pairs import probe_pairs
from urushi.errors import ParameterError
from urushi.nets import lobe as lobes
from urushi.nets.lobe_fit import fit_lobes
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS
from urushi.walk.bottoms.bottom import Family, draw_alpha
from urushi.walk.table import StackTable

#: Maximum number of coats of a trained stack: five coats over a bottom have six interfaces.
MAX_COATS = 5

#: Bottoms of stacks, with their shares.
SHARES = {
    "conductor": 0.2,
    "conductor_complex": 0.15,
    "dielectric": 0.12,
    "diffuse": 0.08,
    "mixture": 0.3,
    "measured_like": 0.15,
}

#: Shares of stacks without coats, with one, two and three.
COATS = 0.1, 0.5, 0.3, 0.1

#: Share of the stacks and coats that are `Practical`; the others are spread over the whole domain.
PRACTICAL = 0.75

#: Coats of the same interface among further coats, and share of two widths whose index is 1.
SHARED, WITHOUT_INTERFACE = 2, 0.05

#: Least width of bottoms of two widths, and largest quotient of two.
LEAST_WIDTH, MOST_QUOTIENT = 0.02, 8.0

#: The kinds of bottoms of stacks.
BOTTOMS = tuple(
    name for name, kind in KINDS.items() if kind.widths == 1 and kind.family.draw is not Family.draw
)


def bottom_lobes(kind: str, columns: dict[str, np.ndarray], widths: int = 1) -> np.ndarray:
    """Lobes float32 (S, L) of bottoms with the parameters (S,) by name.

    Lobes that the family does not know are fitted to its values, as `encode` does.
    """
    fresnel = KINDS[kind].family.fresnel_numbers(columns)
    if fresnel is None:
        return fit_lobes(analytic.at_all(kind, columns, *probe_pairs(widths=widths)), widths)
    result = np.tile(lobes.no_lobe(widths), (len(next(iter(columns.values()))), 1))
    if own := [column for name, column in columns.items() if name.startswith("alpha")]:
        result[:, lobes.WIDTH_PLACES[widths]] = np.stack(own, axis=-1)
    for place, numbers in enumerate(fresnel, start=1):
        result[:, place] = numbers
    return result


def _whole_eta(rng: np.random.Generator, shape: int | tuple[int, ...]) -> np.ndarray:
    near = np.exp(rng.uniform(np.log(0.004), np.log(0.05), shape))
    near = 1 + np.where(rng.integers(2, size=shape) == 0, -near, near)
    ranges = (1.05, 2.0), (2.0, 3.0), (0.5, 0.96)
    parts = (*(rng.uniform(*ends, shape) for ends in ranges), near)
    return np.choose(rng.choice(len(parts), shape, p=(0.55, 0.1, 0.25, 0.1)), parts)


#: Indices of refraction by name: functions of a generator and a shape. "common" is the range of
#: Table 2. "whole" is [0.5, 3], under air or another medium: 55 % are U(1.05, 2), 10 % U(2, 3),
#: 25 % U(0.5, 0.96), and in the last 10 % |eta - 1| is log-uniform in [0.004, 0.05], on either side
#: of 1. "low" are interfaces to a thinner medium, with total reflection from above, for evaluation.
DRAW_ETA: dict[str, Callable[[np.random.Generator, int | tuple[int, ...]], np.ndarray]] = {
    "common": lambda rng, shape: rng.uniform(1.05, 2.0, shape),
    "whole": _whole_eta,
    "low": lambda rng, shape: rng.uniform(0.5, 0.96, shape),
}


def draw_medium(
    rng: np.random.Generator, shape: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Albedo, sigma_t and g of `Extended`, each an array of this shape."""
    return (
        1 - rng.uniform(0.0, 1.0, shape) ** 2,
        TRAINED_DEPTH * rng.uniform(0.0, 1.0, shape) ** 2,
        rng.uniform(*TRAINED_G, shape),
    )


@dataclass(frozen=True)
class Extended:
    """Stacks over the whole domain: Table 2 of Fan et al. (2022) with more kinds of all its parts.

    alpha = U(0.01^(1/3), 1)^3, in [0.01, 1]; albedo = 1 - U(0, 1)^2; sigma_t = 8 U(0, 1)^2 in
    [0, 8], with more thin media than thick ones; g = U(-0.8, 0.9).
    """

    coats: int = 1  # dielectric interfaces, each with a medium below
    bottom: str = "conductor"  # one of `BOTTOMS`; its parameters are drawn by its family
    indices: str = "common"  # eta of coats and of "dielectric" bottoms, a key of `DRAW_ETA`

    def __post_init__(self) -> None:
        choices = {"coats": range(MAX_COATS + 1), "bottom": BOTTOMS, "indices": DRAW_ETA}
        for name, known in choices.items():
            if (value := getattr(self, name)) not in known:
                names = ", ".join(map(str, known))
                raise ParameterError(f"{name} is {value!r}; choose one of {names}")

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        """Draw n stacks."""
        shape = (n, self.coats)
        alpha, eta = draw_alpha(rng, shape), DRAW_ETA[self.indices](rng, shape)
        medium = draw_medium(rng, shape)
        return StackTable(alpha, eta, *medium, self.bottom, self._draw_bottom(rng, n))

    def _draw_bottom(self, rng: np.random.Generator, n: int) -> dict[str, np.ndarray]:
        kind = KINDS[self.bottom]
        columns = kind.family.draw(rng, n, DRAW_ETA[self.indices])
        return {name: columns[name] for name in kind.parameters}


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
    """GGX widths, log-uniform in [0.01, 0.5]: half of the surfaces are smoother than 0.07."""
    return np.exp(rng.uniform(np.log(MIN_ALPHA), np.log(0.5), shape)).clip(MIN_ALPHA, 0.5)


def draw_stack(
    rng: np.random.Generator, shares: Mapping[str, float] = SHARES, most: int = MAX_COATS
) -> StackTable:
    """One random stack of at most `most` coats; shares: of the kinds of bottoms."""
    kind = str(rng.choice(list(shares), p=list(shares.values())))
    coats = min(int(rng.choice(len(COATS), p=COATS)), most)
    practical = coats and rng.random() < PRACTICAL
    return (Practical(coats, kind) if practical else Extended(coats, kind, "whole")).sample(rng, 1)


def draw_coats(rng: np.random.Generator, count: int) -> np.ndarray:
    """Random coats (count, 5) with any index, `SHARED` after another with the same interface.

    Practical ones are the upper or the lower one of two.
    """
    often = rng.binomial(count, PRACTICAL)
    practical = rng.permutation(coats_of(Practical(2).sample(rng, often)))[:often]
    whole = coats_of(Extended(1, "conductor", "whole").sample(rng, count - often))
    coats = rng.permutation(np.concatenate([practical, whole]))
    coats[:, :2] = coats[np.arange(count) // SHARED * SHARED, :2]
    return coats


def coats_of(stack: StackTable) -> np.ndarray:
    """The coats (S N, 5) of stacks, from top to bottom."""
    columns = [np.asarray(getattr(stack, name)).ravel() for name in CoatParameters._fields]
    return np.stack(columns, axis=-1).astype(np.float64)


def draw_coats_of_two(rng: np.random.Generator, count: int) -> np.ndarray:
    """`draw_coats` (count, 6) of two widths, some of them of index 1, which have no interface."""
    coats = with_two_widths(rng, draw_coats(rng, count))
    coats[rng.random(count) < WITHOUT_INTERFACE, 1] = 1
    interface = [0, 1, -1]
    coats[:, interface] = coats[np.arange(count) // SHARED * SHARED][:, interface]
    bare = coats[:, 1] == 1
    coats[np.ix_(bare, [0, -1])] = MIN_ALPHA  # as the network sees them
    return coats


def with_two_widths(
    rng: np.random.Generator, rows: np.ndarray, least: float = MIN_ALPHA
) -> np.ndarray:
    """Rows (N, D + 1) whose first and last number are widths about the first of rows (N, D).

    Their geometric mean is that width, and a quarter are equal.
    """
    logs = rng.uniform(-1, 1, len(rows)) * (rng.random(len(rows)) < 0.75)
    root = np.exp(0.5 * np.log(MOST_QUOTIENT) * logs)
    along, across = (np.clip(rows[:, 0] * x, least, 1.0) for x in (root, 1 / root))
    return np.column_stack([along, rows[:, 1:], across]).astype(np.float32)
