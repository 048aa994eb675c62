"""Reference values of held-out stacks, simulated to a stated error."""

import zlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from tqdm import tqdm

from urushi.core import direction_sets, error_metrics
from urushi.core.probe_pairs import PROBES, probe_pairs
from urushi.core.quadrature import half_vector_rule
from urushi.eval.groups import Group
from urushi.material.source import STACK_WALKS
from urushi.walk import StackTable, analytic, walk_pairs

#: Number of drawn pairs of a stack: for E (cosine density) and for P (log half angle).
E_PAIRS, P_PAIRS = 100, 200

#: First entropy word of every held-out draw; no training data are seeded with four words.
HELD_OUT_SEED = 4711

#: Errors that determine the number of walks: the reference's own E, P of every pair, and the
#: standard error of the directional albedo. Most errors are far smaller, as walks are rounded up.
E_ERROR, P_ERROR, ALBEDO_ERROR = 0.003, 0.003, 0.0015

#: Walks per pair: number in the pilot run, maximum, and maximum for P. Without the last limit a few
#: pairs in dark tails would take most of the time without changing the median of P.
PILOT_WALKS, MAX_WALKS, MAX_P_WALKS = 2048, 1 << 22, 1 << 16

#: Noise, as P, of the simulated values that the encoder reads; about equal to `urushi.encode`'s.
PROBE_ERROR = 0.005

#: Directional albedo: cosines of the incident directions, number of stacks of a group, and number
#: of walks of the pilot run for each of the 1536 nodes of the quadrature.
ALBEDO_COSINES, ALBEDO_STACKS, ALBEDO_PILOT = (0.95, 0.6, 0.25), 8, 64


#: Function from f and the standard deviation of one walk to the number of walks; all (S, M).
Allotment = Callable[[np.ndarray, np.ndarray], np.ndarray]


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
    """

    table: StackTable
    wi: np.ndarray
    wo: np.ndarray
    f: np.ndarray
    se: np.ndarray
    probed: Mapping[int, np.ndarray] = field(default_factory=dict)
    albedo: np.ndarray | None = None
    albedo_se: np.ndarray | None = None


def draw_stacks(group: Group, seed: int = 0) -> StackTable:
    """Draw a group's stacks."""
    return group.distribution.sample(_generator(group, seed, 0), group.stacks)


def draw_pairs(group: Group, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Draw every stack's pairs, first for E and then for P; two arrays (S, M, 3) float32."""
    rng = _generator(group, seed, 1)
    for_e = direction_sets.cosine_pairs(rng, group.stacks * E_PAIRS)
    for_p = direction_sets.half_angle_pairs(rng, group.stacks * P_PAIRS)
    wi, wo = (
        np.concatenate([e.reshape(-1, E_PAIRS, 3), p.reshape(-1, P_PAIRS, 3)], axis=1)
        for e, p in zip(for_e, for_p, strict=True)
    )
    return wi, wo


def _generator(group: Group, seed: int, purpose: int) -> np.random.Generator:
    """An independent generator for each group, seed and purpose (stacks, pairs or walks)."""
    name = zlib.crc32(group.name.encode())
    return np.random.default_rng((HELD_OUT_SEED, seed, name, purpose))


def simulate_all(groups: Iterable[Group], seed: int = 0) -> dict[str, Samples]:
    """Simulate groups; returns their sets by name."""
    return {group.name: simulate(group, seed) for group in groups}


def simulate(group: Group, seed: int = 0, *, only_e: bool = False) -> Samples:
    """Draw a group's stacks and simulate each pair with a number of walks that follows its noise.

    A pilot run measures the noise. Its values are discarded, so that the number of walks does not
    depend on the values that are kept and the reference stays unbiased.

    only_e: leave out the pairs for P and the albedo, which take most of the time.
    """
    table, (wi, wo) = draw_stacks(group, seed), draw_pairs(group, seed)
    if only_e:
        wi, wo = wi[:, :E_PAIRS], wo[:, :E_PAIRS]
    if not table.coats:
        f = evaluate_bottoms(table, wi, wo)
        return Samples(table, wi, wo, f, np.zeros_like(f))
    rng = _generator(group, seed, 2)
    cosines = wi[..., 2], wo[..., 2]
    f, se = _adaptive(
        table, wi, wo, rng, lambda f, sd: _walks_for_errors(f, sd, *cosines), name=group.name
    )
    probe_wi, probe_wo = (np.tile(w, (len(table), 1, 1)) for w in probe_pairs(PROBES))
    probed = {
        coats: _adaptive(
            lowest(table, coats), probe_wi, probe_wo, rng, _walks_for_probes, name=group.name
        )[0]
        for coats in group.probed
    }
    if only_e:
        return Samples(table, wi, wo, f, se, probed)
    albedo, albedo_se = _albedo(first(table, ALBEDO_STACKS), rng, group.name)
    return Samples(table, wi, wo, f, se, probed, albedo, albedo_se)


def evaluate_bottoms(table: StackTable, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Exact values (S, M) [1/sr] of the bottoms in air, at every stack's pairs (S, M, 3)."""
    row = np.repeat(np.arange(len(table), dtype=np.uint32), wi.shape[1])
    f = analytic.rows(table.kind, table.bottom, row, wi.reshape(-1, 3), wo.reshape(-1, 3))
    return f.reshape(wi.shape[:2])


def lowest(table: StackTable, coats: int) -> StackTable:
    """The lower parts of stacks: their last `coats` coats over the bottom."""
    names = ("alpha", "eta", "albedo", "sigma_t", "g")
    columns = {name: getattr(table, name)[:, table.coats - coats :] for name in names}
    return StackTable(**columns, kind=table.kind, bottom=table.bottom)


def first(table: StackTable, stacks: int) -> StackTable:
    """The first stacks of a table."""
    names = ("alpha", "eta", "albedo", "sigma_t", "g")
    columns = {name: getattr(table, name)[:stacks] for name in names}
    bottom = {name: values[:stacks] for name, values in table.bottom.items()}
    return StackTable(**columns, kind=table.kind, bottom=bottom)


def walk_all(
    table: StackTable, wi: np.ndarray, wo: np.ndarray, walks: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard error (S, M) of every stack at its pairs (S, M, 3)."""
    return _walk_chosen(table, np.ones(wi.shape[:2], bool), wi, wo, walks, seed)


def _walk_chosen(
    table: StackTable, chosen: np.ndarray, wi: np.ndarray, wo: np.ndarray, walks: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """`walk_all` at the pairs where `chosen` (S, M) is set; zero at the others."""
    f, se = np.zeros(chosen.shape, np.float32), np.zeros(chosen.shape, np.float32)
    row = np.nonzero(chosen)[0].astype(np.uint32)
    f[chosen], se[chosen] = walk_pairs(
        table, row, wi[chosen], wo[chosen], walks=walks, seed=seed
    )  # fmt: skip
    return f, se


def _adaptive(
    table: StackTable,
    wi: np.ndarray,
    wo: np.ndarray,
    rng: np.random.Generator,
    allot: Allotment,
    *,
    name: str,
    pilot: int = PILOT_WALKS,
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard error (S, M) of the walks that `allot` requires after a pilot run."""
    first, second = (int(word) for word in rng.integers(1 << 31, size=2))
    f, se = walk_all(table, wi, wo, pilot, first)
    walks_by_pair = allot(f, _pooled(f, se) * np.sqrt(pilot))
    exponent = np.ceil(np.log2(np.clip(walks_by_pair, pilot, MAX_WALKS))).astype(int)
    f, se = np.zeros_like(f), np.zeros_like(se)
    total = int((2**exponent).sum())
    with tqdm(total=total, desc=name, unit="walk", unit_scale=True, disable=None) as progress:
        for power in np.unique(exponent):
            chosen = exponent == power
            # Every power has its own seed, because random streams are numbered within one call.
            part = _walk_chosen(table, chosen, wi, wo, 1 << int(power), second + int(power))
            f, se = f + part[0], se + part[1]
            progress.update(int(chosen.sum()) << int(power))
    return f, se


def _pooled(f: np.ndarray, se: np.ndarray) -> np.ndarray:
    """Standard errors (S, M) raised by half of the stack's typical relative error.

    The error of a pair is too small if its rare bright walks are missing in the pilot run; the
    other pairs of the same stack show the noise.
    """
    relative = se / (f + error_metrics.DARK_OFFSET)
    typical = np.sqrt((relative**2).mean(axis=1, keepdims=True))
    return np.hypot(se, 0.5 * typical * f)


def _walks_for_errors(
    f: np.ndarray, sd: np.ndarray, cos_i: np.ndarray, cos_o: np.ndarray
) -> np.ndarray:
    """Walks (S, M) for which E of a stack's noise is `E_ERROR`, and P of a pair's noise `P_ERROR`.

    For E this minimises the total number of walks n at a fixed sum of w sd / sqrt(n), so that
    n ~ (w sd)^(2/3).
    """
    part = slice(None, E_PAIRS)
    weight = error_metrics.energy_weight(cos_i, cos_o)[:, part]
    share = (weight * sd[:, part]) ** (2 / 3)
    allowed = E_ERROR * (weight * f[:, part]).sum(1, keepdims=True)
    for_e = share * (share.sum(1, keepdims=True) / np.maximum(allowed, 1e-12)) ** 2
    for_p = (sd / (f + error_metrics.DARK_OFFSET) / P_ERROR)[:, E_PAIRS:] ** 2
    return np.concatenate([for_e, np.minimum(for_p, MAX_P_WALKS)], axis=1)


def _walks_for_probes(f: np.ndarray, sd: np.ndarray) -> np.ndarray:
    """Walks (S, M) for which P of a pair's noise is `PROBE_ERROR`; at most those of `encode`."""
    return np.minimum((sd / (f + error_metrics.DARK_OFFSET) / PROBE_ERROR) ** 2, STACK_WALKS)


def albedo_directions() -> np.ndarray:
    """Unit vectors wi (A, 3) of the `ALBEDO_COSINES`."""
    cosine = np.array(ALBEDO_COSINES)
    return np.stack([np.sqrt(1 - cosine**2), np.zeros_like(cosine), cosine], axis=-1)


def _albedo(
    table: StackTable, rng: np.random.Generator, name: str
) -> tuple[np.ndarray, np.ndarray]:
    """Directional albedo and its standard error (S, A), by the same quadrature as materials."""
    wi = albedo_directions()
    wo, weights = half_vector_rule(wi)
    count, nodes = weights.shape
    shape = len(table), count, nodes
    weights = weights * wo[..., 2]
    pairs_wi = np.tile(np.repeat(wi, nodes, axis=0).astype(np.float32), (len(table), 1, 1))
    pairs_wo = np.tile(wo.reshape(-1, 3).astype(np.float32), (len(table), 1, 1))

    def allot(f: np.ndarray, sd: np.ndarray) -> np.ndarray:
        """Minimise the total number n at a fixed sum of (w sd)^2 / n, so that n ~ w sd."""
        share = sd.reshape(shape) * weights
        walks = share * share.sum(-1, keepdims=True) / ALBEDO_ERROR**2
        return walks.reshape(sd.shape)

    f, se = (
        x.reshape(shape)
        for x in _adaptive(table, pairs_wi, pairs_wo, rng, allot, name=name, pilot=ALBEDO_PILOT)
    )
    return (
        (f * weights).sum(-1).astype(np.float32),
        np.sqrt(((se * weights) ** 2).sum(-1)).astype(np.float32),
    )


def reference_error(samples: Samples) -> tuple[np.ndarray, np.ndarray]:
    """The reference's own error by stack: E and the median of P of one standard error.

    Returns:
        Two float64 arrays (S,).
    """
    moved = samples.f + samples.se
    return stack_errors(moved, samples), np.median(pair_errors(moved, samples), axis=1)


def stack_errors(f_hat: np.ndarray, samples: Samples) -> np.ndarray:
    """E of every stack, (S,), from values (S, M) at all pairs."""
    part = slice(None, E_PAIRS)
    cos_i, cos_o = samples.wi[:, part, 2], samples.wo[:, part, 2]
    return error_metrics.stack_error(f_hat[:, part], samples.f[:, part], cos_i, cos_o)


def pair_errors(f_hat: np.ndarray, samples: Samples) -> np.ndarray:
    """P of every pair, (S, P_PAIRS), from values (S, M) at all pairs."""
    return error_metrics.pair_error(f_hat[:, E_PAIRS:], samples.f[:, E_PAIRS:])
