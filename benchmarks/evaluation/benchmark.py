"""The stored benchmark set: reference values that networks are compared with by default.

One safetensors file of about 1 MB. It holds, for every group that must be simulated, the stacks'
parameters, f in single and its standard error in half precision, the values at the probe pairs and
the directional albedo. The pairs of directions are drawn again from the seed; the last pair of
every stack is stored to detect if other pairs are drawn.

`python -m benchmarks.evaluation.benchmark FILE` simulates it in about a quarter of an hour on two
idle cores. Groups that the file holds already are kept to the bit.
"""

import os
import platform
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.samples import ALBEDO_STACKS, E_PAIRS, GROUPS, Group, Samples
from benchmarks.measures import DARK_OFFSET, in_plane
from tqdm import tqdm

from urushi import files
from urushi.checks import CoatParameters
from urushi.core import error_metrics
from urushi.core.probe_pairs import PROBES, probe_pairs
from urushi.core.quadrature import half_vector_rule
from urushi.errors import FileError
from urushi.material.source import STACK_WALKS
from urushi.walk import StackTable, walk_pairs
from urushi.walk.bottoms import KINDS

#: Seed of the stored set.
SEED = 0
KIND, FILE = "benchmark", Path(__file__).with_suffix(".safetensors")
_REMEDY = "restore it from the repository"

#: Errors that determine the number of walks: the reference's own E, P of every pair, and the
#: standard error of the directional albedo. Most errors are far smaller, as walks are rounded up.
E_ERROR, P_ERROR, ALBEDO_ERROR = 0.003, 0.003, 0.0015

#: Walks per pair: number in the pilot run, maximum, and maximum for P. Without the last limit a few
#: pairs in dark tails would take most of the time without changing the median of P.
PILOT_WALKS, MAX_WALKS, MAX_P_WALKS = 2048, 1 << 22, 1 << 16

#: Noise, as P, of the simulated values that codes are solved from; about that of `urushi.encode`.
PROBE_ERROR = 0.005

#: Number of walks of the pilot run for each of the 1536 nodes of the albedo's quadrature.
ALBEDO_PILOT = 64

#: Function from f and the standard deviation of one walk to the number of walks; all (S, M).
Allotment = Callable[[np.ndarray, np.ndarray], np.ndarray]


def read(path: str | os.PathLike = FILE, groups: tuple[Group, ...] = GROUPS) -> dict[str, Samples]:
    """Read a set that `write` wrote; groups without coats are evaluated.

    Args:
        path: the file; default: the stored set.
        groups: to return.

    Raises:
        FileError: missing, foreign, or made for other groups.
    """
    description, arrays = files.read_tensors(path, KIND)
    stored = {group["name"]: group for group in description["groups"]}
    result = {}
    for group in groups:
        if not group.distribution.coats:
            result[group.name] = simulate(group, description["seed"])
            continue
        if stored.get(group.name) != describe(group):
            raise FileError(
                f"the benchmark set '{path}' lacks the group '{group.name}' or was made for other "
                f"stacks of that name; {_REMEDY}"
            )
        prefix, kind = f"{group.name}.", group.distribution.bottom
        own = {k.removeprefix(prefix): v for k, v in arrays.items() if k.startswith(prefix)}
        wi, wo = sampling.draw_pairs(group, description["seed"])
        # Within rounding: sines may differ in the last digit between machines.
        last = np.stack([wi[:, -1], wo[:, -1]], axis=1)
        if not np.allclose(last, own["last_pair"], atol=1e-5):
            raise FileError(
                f"the directions of the benchmark set '{path}' cannot be reproduced: another NumPy "
                f"or another Urushi made it; {_REMEDY}"
            )
        columns = zip(CoatParameters._fields, np.moveaxis(own["coats"], -1, 0), strict=True)
        bottom = dict(zip(KINDS[kind].parameters, own["bottom"].T, strict=True))
        table = StackTable(**dict(columns), kind=kind, bottom=bottom)
        probed = {coats: own[f"probed{coats}"] for coats in group.probed}
        values = own["f"], own["se"].astype(np.float32), probed, own["albedo"], own["albedo_se"]
        result[group.name] = Samples(table, wi, wo, *values)
    return result


def describe(group: Group) -> dict[str, object]:
    fields = asdict(group.distribution)
    if fields.get("indices") == "common":  # the stored set has no indices where they are common
        del fields["indices"]
    return {
        "name": group.name,
        "distribution": {"kind": type(group.distribution).__name__.lower(), **fields},
        "stacks": group.stacks,
        "probed": list(group.probed),
        "pairs": [sampling.E_PAIRS, sampling.P_PAIRS, PROBES],
    }


def write(
    path: str | os.PathLike, sets: Mapping[str, Samples], groups: tuple[Group, ...] = GROUPS
) -> None:
    """Write simulated sets by the groups' names to a file."""
    simulated = [group for group in groups if group.distribution.coats]
    arrays: dict[str, np.ndarray] = {}
    for group in simulated:
        held = sets[group.name]
        table, names = held.table, KINDS[held.table.kind].parameters
        own = {
            "coats": np.stack([getattr(table, name) for name in CoatParameters._fields], axis=-1),
            "bottom": np.stack([table.bottom[name] for name in names], axis=-1),
            "last_pair": np.stack([held.wi[:, -1], held.wo[:, -1]], axis=1),
            "f": held.f,
            "se": held.se.astype(np.float16),
            **{f"probed{coats}": values for coats, values in held.probed.items()},
            "albedo": held.albedo,
            "albedo_se": held.albedo_se,
        }
        arrays |= {f"{group.name}.{name}": array for name, array in own.items()}
    packages = {name: version(name) for name in ("urushi", "numpy", "drjit")}
    description: dict[str, Any] = {
        "seed": SEED,
        "groups": [describe(group) for group in simulated],
        "versions": {"python": platform.python_version(), **packages},
    }
    files.write_tensors(path, KIND, description, arrays)


def simulate(group: Group, seed: int = 0, *, only_e: bool = False) -> Samples:
    """Draw a group's stacks and simulate each pair with a number of walks that follows its noise.

    A pilot run measures the noise. Its values are discarded, so that the number of walks does not
    depend on the values that are kept and the reference stays unbiased.

    only_e: leave out the pairs for P and the albedo, which take most of the time.
    """
    table, (wi, wo) = sampling.draw_stacks(group, seed), sampling.draw_pairs(group, seed)
    if only_e:
        wi, wo = wi[:, :E_PAIRS], wo[:, :E_PAIRS]
    if not table.coats:
        return Samples(table, wi, wo, *sampling.walk_all(table, wi, wo, 0, 0))
    rng = sampling.generator(group, seed, 2)
    cosines = wi[..., 2], wo[..., 2]
    walked = partial(_adaptive, rng=rng, name=group.name)
    f, se = walked(table, wi, wo, allot=lambda f, sd: _walks_for_errors(f, sd, *cosines))
    pairs = [np.tile(w, (len(table), 1, 1)) for w in probe_pairs(PROBES)]

    def for_probes(f: np.ndarray, sd: np.ndarray) -> np.ndarray:
        """Walks for which P of a pair's noise is `PROBE_ERROR`; at most those of `encode`."""
        return np.minimum((sd / (f + DARK_OFFSET) / PROBE_ERROR) ** 2, STACK_WALKS)

    probed = {
        coats: walked(sampling.part(table, lowest=coats), *pairs, allot=for_probes)[0]
        for coats in group.probed
    }
    if only_e:
        return Samples(table, wi, wo, f, se, probed)
    first = sampling.part(table, slice(ALBEDO_STACKS))
    return Samples(table, wi, wo, f, se, probed, *_albedo(first, rng, group.name))


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
    f, se = sampling.walk_all(table, wi, wo, pilot, first)
    # The error of a pair is too small if its rare bright walks are missing in the pilot run. The
    # other pairs of the stack show the noise: half of their typical relative error is added.
    typical = np.sqrt(((se / (f + DARK_OFFSET)) ** 2).mean(axis=1, keepdims=True))
    walks_by_pair = allot(f, np.hypot(se, 0.5 * typical * f) * np.sqrt(pilot))
    exponent = np.ceil(np.log2(np.clip(walks_by_pair, pilot, MAX_WALKS))).astype(int)
    f, se = np.zeros_like(f), np.zeros_like(se)
    total = int((2**exponent).sum())
    with tqdm(total=total, desc=name, unit="walk", unit_scale=True, disable=None) as progress:
        for power in np.unique(exponent):
            chosen = exponent == power
            # Every power has its own seed, because random streams are numbered within one call.
            count, seed = 1 << int(power), second + int(power)
            row = np.nonzero(chosen)[0].astype(np.uint32)
            part = walk_pairs(table, row, wi[chosen], wo[chosen], walks=count, seed=seed)
            f[chosen], se[chosen] = part
            progress.update(int(chosen.sum()) << int(power))
    return f, se


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
    for_p = (sd / (f + DARK_OFFSET) / P_ERROR)[:, E_PAIRS:] ** 2
    return np.concatenate([for_e, np.minimum(for_p, MAX_P_WALKS)], axis=1)


def _albedo(
    table: StackTable, rng: np.random.Generator, name: str
) -> tuple[np.ndarray, np.ndarray]:
    """Directional albedo and its standard error (S, A), by the same quadrature as materials."""
    wi = in_plane(np.arccos(sampling.ALBEDO_COSINES)).astype(np.float64)
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
    mean, error = (f * weights).sum(-1), np.sqrt(((se * weights) ** 2).sum(-1))
    return mean.astype(np.float32), error.astype(np.float32)


def main(path: Path) -> None:
    """Write the set, or complete it."""
    held = {}
    if path.exists():
        held = {group["name"]: group for group in files.read_tensors(path, KIND)[0]["groups"]}
    kept = tuple(group for group in GROUPS if held.get(group.name) == describe(group))
    sets = read(path, kept) if kept else {}
    write(path, {g.name: sets.get(g.name) or simulate(g, SEED) for g in GROUPS})


if __name__ == "__main__":
    main(Path(sys.argv[1]))
