"""The held-out stacks that networks are measured on, their reference values, and the errors.

The rows of the table of errors are sets of groups of stacks.
"""

import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from benchmarks import measures
from benchmarks.evaluation.distributions import Clear, Table2
from benchmarks.measures import half_angle_pairs

from urushi.checks import CoatParameters
from urushi.core.direction_sets import Pairs, cosine_pairs
from urushi.core.microfacet import of_widths
from urushi.train.distribution import Extended
from urushi.walk import StackTable, analytic, walk_pairs


@dataclass(frozen=True)
class Group:
    """Held-out stacks of one distribution."""

    name: str  # unique; seeds the group's stacks and directions
    distribution: Table2 | Extended
    stacks: int  # their number
    # Numbers of coats, each at least one. For each number the lowest coats over the bottom are
    # simulated at the probe pairs too, for codes of them.
    probed: tuple[int, ...] = ()


@dataclass(frozen=True)
class Row:
    """One line of the table: errors over the stacks of several groups."""

    name: str
    groups: tuple[str, ...]  # their names
    # Number of each stack's lowest coats that are encoded with the bottom, from values at the probe
    # pairs; the others are layered. -1: all.
    encoded: int = 0
    how: str = "code"  # or "table", both by light transport, or "network", by the layering network


#: The kinds of bottom that are measured, with their names in the table.
BOTTOMS = {
    "conductor": "conductor (Schlick)",
    "conductor_complex": "conductor (complex)",
    "dielectric": "dielectric reflector",
    "diffuse": "Lambertian",
    "mixture": "mixture",
}
_KINDS = tuple(BOTTOMS)

_BARE = tuple(Group(f"bare {kind}", Extended(0, kind), 64) for kind in _KINDS)
_TWO = (
    Group("two, table2", Table2(1), 64, probed=(1,)),
    *(Group(f"two, {kind}", Extended(1, kind), 12, probed=(1,)) for kind in _KINDS),
)
_THREE = (
    Group("three, table2", Table2(2), 8, probed=(1, 2)),
    *(Group(f"three, {kind}", Extended(2, kind), 4, probed=(1, 2)) for kind in _KINDS),
)
_SIX = (
    Group("six, table2", Table2(5), 4),
    *(Group(f"six, {kind}", Extended(5, kind), 4) for kind in _KINDS),
)
_CLEAR = tuple(Group(f"clear, {kind}", Clear(1, kind), 12) for kind in _KINDS)
_LOW_TWO = tuple(Group(f"low two, {kind}", Extended(1, kind, "low"), 8) for kind in _KINDS)
_LOW_THREE = tuple(Group(f"low three, {kind}", Extended(2, kind, "low"), 4) for kind in _KINDS)


def _names(groups: tuple[Group, ...]) -> tuple[str, ...]:
    return tuple(group.name for group in groups)


#: All groups; those without a coat are analytic, the others are simulated.
GROUPS = (*_BARE, *_TWO, *_THREE, *_SIX, *_CLEAR, *_LOW_TWO, *_LOW_THREE)

#: The table, top to bottom.
ROWS = (
    *(Row(f"encode {BOTTOMS[kind]}", (f"bare {kind}",)) for kind in _KINDS),
    Row("encode simulated stacks", _names((*_TWO, *_THREE)), encoded=-1),
    Row("layer two interfaces, Table 2", _names(_TWO[:1])),
    Row("  by tables", _names(_TWO[:1]), how="table"),
    Row("  by the network", _names(_TWO[:1]), how="network"),
    Row("layer two interfaces, extended", _names(_TWO[1:])),
    Row("  by tables, extended", _names(_TWO[1:]), how="table"),
    Row("  by the network, extended", _names(_TWO[1:]), how="network"),
    *(Row(f"  over {BOTTOMS[kind]}", (f"two, {kind}",)) for kind in _KINDS),
    Row("layer three interfaces", _names(_THREE)),
    Row("  upper over encoded lower", _names(_THREE), encoded=1),
    Row("  three, by the network", _names(_THREE), how="network"),
    Row("layer six interfaces", _names(_SIX)),
    Row("  six, by the network", _names(_SIX), how="network"),
    Row("layer clear coats", _names(_CLEAR)),
    *(Row(f"  over {BOTTOMS[kind]}, clear", (f"clear, {kind}",)) for kind in _KINDS),
    Row("indices below one, two interfaces", _names(_LOW_TWO)),
    Row("indices below one, three interfaces", _names(_LOW_THREE)),
)


#: Number of drawn pairs of a stack: for E (cosine density) and for P (log half angle).
E_PAIRS, P_PAIRS = 100, 200

#: First entropy word of every held-out draw; no training data are seeded with four words.
HELD_OUT_SEED = 4711

#: Cosines of the incident directions of directional albedos, and number of a group's stacks.
ALBEDO_COSINES, ALBEDO_STACKS = (0.95, 0.6, 0.25), 8


@dataclass(frozen=True)
class Samples:
    """Reference values of a group's S stacks at M = `E_PAIRS` + `P_PAIRS` pairs each.

    Attributes:
        table: the S stacks.
        wi, wo: (S, M, 3) float32, the pairs for E first, then the pairs for P.
        f, se: (S, M) float32 [1/sr], mean and standard error; exact without coats (se = 0).
        probed: by number of coats, values (S, `PROBES`) [1/sr] of the lower parts of the stacks;
            for networks with other probe pairs the values are simulated when they are needed.
        albedo, albedo_se: (up to `ALBEDO_STACKS`, `ALBEDO_COSINES`) float32, directional albedo of
            the first stacks; None without coats.
        e_pairs: number of the pairs for E.
    """

    table: StackTable
    wi: np.ndarray
    wo: np.ndarray
    f: np.ndarray
    se: np.ndarray
    probed: Mapping[int, np.ndarray] = field(default_factory=dict)
    albedo: np.ndarray | None = None
    albedo_se: np.ndarray | None = None
    e_pairs: int = E_PAIRS


def draw_stacks(group: Group, seed: int = 0) -> StackTable:
    return group.distribution.sample(generator(group, seed, 0), group.stacks)


def draw_pairs(group: Group, seed: int = 0) -> Pairs:
    """The pairs of a group's stacks, see `pairs_of_stacks`."""
    return pairs_of_stacks(generator(group, seed, 1), group.stacks, E_PAIRS, P_PAIRS)


def pairs_of_stacks(
    rng: np.random.Generator, stacks: int, for_e: int, for_p: int, *, slopes: bool = False
) -> Pairs:
    """Draw every stack's pairs, first for E and then for P; two arrays (S, M, 3) float32.

    for_e, for_p: numbers of pairs of a stack. slopes: as of `half_angle_pairs`.
    """
    pairs = cosine_pairs(rng, stacks * for_e), half_angle_pairs(rng, stacks * for_p, slopes=slopes)
    wi, wo = (
        np.concatenate([w.reshape(stacks, -1, 3) for w in sides], axis=1)
        for sides in zip(*pairs, strict=True)
    )
    return wi, wo


def unsimulated(group: Group, seed: int = 0) -> Samples:
    """A group's stacks and pairs without values."""
    table, (wi, wo) = draw_stacks(group, seed), draw_pairs(group, seed)
    nothing = np.zeros(wi.shape[:2], np.float32)
    return Samples(table, wi, wo, nothing, nothing)


def generator(group: Group, seed: int, purpose: int) -> np.random.Generator:
    """An independent generator for each group, seed and purpose (stacks, pairs or walks)."""
    name = zlib.crc32(group.name.encode())
    return np.random.default_rng((HELD_OUT_SEED, seed, name, purpose))


def by_row(wi: np.ndarray, wo: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows (S M,) of a table, and pairs (S M, 3), of every stack's pairs (S, M, 3)."""
    row = np.repeat(np.arange(len(wi), dtype=np.uint32), wi.shape[1])
    return row, wi.reshape(-1, 3), wo.reshape(-1, 3)


def part(table: StackTable, stacks: slice = slice(None), lowest: int | None = None) -> StackTable:
    """Some of a table's stacks, and their `lowest` coats over the bottom; None: all."""
    coats = slice(0 if lowest is None else table.coats - lowest, None)
    columns: dict[str, Any] = {
        name: of_widths(lambda x: x[stacks, coats], getattr(table, name))
        for name in CoatParameters._fields
    }
    bottom = {name: values[stacks] for name, values in table.bottom.items()}
    return replace(table, **columns, bottom=bottom)


def walk_all(
    table: StackTable,
    wi: np.ndarray,
    wo: np.ndarray,
    walks: int,
    seed: int,
    walk: Callable[..., tuple[np.ndarray, np.ndarray]] = walk_pairs,
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard error (S, M) [1/sr] of every stack at its pairs (S, M, 3).

    Bottoms without coats are evaluated: their values are exact.
    """
    rows = by_row(wi, wo)
    if table.coats:
        f, se = walk(table, *rows, walks=walks, seed=seed)
    else:
        f = analytic.rows(table.kind, table.bottom, *rows)
        se = np.zeros_like(f)
    return f.reshape(wi.shape[:2]), se.reshape(wi.shape[:2])


def stack_errors(f_hat: np.ndarray, samples: Samples) -> np.ndarray:
    """E of every stack, (S,), from values (S, M) at all pairs, or at those for E alone."""
    part = slice(None, samples.e_pairs)
    cos_i, cos_o = samples.wi[:, part, 2], samples.wo[:, part, 2]
    return measures.stack_error(f_hat[:, part], samples.f[:, part], cos_i, cos_o)


def pair_errors(f_hat: np.ndarray, samples: Samples) -> np.ndarray:
    """P of every pair for it, (S, M - `e_pairs`), from values (S, M) at all pairs."""
    part = slice(samples.e_pairs, None)
    return measures.pair_error(f_hat[:, part], samples.f[:, part])
