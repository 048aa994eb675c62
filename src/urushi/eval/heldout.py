"""Errors of trained networks on layered materials that they were not trained on."""

import json
import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from tqdm import tqdm

from urushi.data import directions
from urushi.data import metrics as stack_metrics
from urushi.data.distribution import COAT_PARAMETERS, Distribution, Extended, Table2
from urushi.errors import ParameterError
from urushi.eval import metrics
from urushi.files import atomic_write
from urushi.material.texture import encode_texels, layer_texels
from urushi.nets import weights
from urushi.nets.default import default_model
from urushi.reference import StackTable, evaluate, walk_pairs

#: Drawn pairs of every stack: for E (cosine density) and for P (log half angle).
E_PAIRS, P_PAIRS = 100, 200

#: The first entropy word of every held-out draw: no training data are seeded with two words.
HELD_OUT_SEED = 4711

#: The reference's error in E and P that every stack aims at and most stay well below (the walks are
#: rounded up to a power of two); walks of the pilot run that measures it; the most for any pair.
REFERENCE_ERROR, PILOT_WALKS, MAX_WALKS = 0.005, 1024, 1 << 19


@dataclass(frozen=True)
class Group:
    """Held-out stacks of one distribution: `stacks` of them."""

    name: str
    distribution: Distribution
    stacks: int = 100


#: What `report` measures.
GROUPS = (
    Group("Table 2, two interfaces", Table2(coats=1)),
    Group("Table 2, three interfaces", Table2(coats=2)),
    Group("extended, two interfaces", Extended(coats=1)),
    Group("extended, complex conductor", Extended(coats=1, bottom="conductor_complex")),
    Group("extended, Lambertian", Extended(coats=1, bottom="diffuse")),
)

#: Columns of the table. (The mean of P is left out: a few pairs in dark tails rule it.)
COLUMNS = [("E", "mean"), ("E", "median"), ("E", "p95"), ("E", "reference")]
COLUMNS += [("P", "median"), ("P", "p95"), ("P", "reference")]


@dataclass(frozen=True)
class Samples:
    """Reference values of S stacks at M pairs each: `E_PAIRS` for E, then `P_PAIRS` for P.

    Attributes:
        table: the S stacks.
        wi, wo: (S, M, 3) float32.
        f, se: (S, M) float32 [1/sr], the walk's mean and standard error.
    """

    table: StackTable
    wi: np.ndarray
    wo: np.ndarray
    f: np.ndarray
    se: np.ndarray


def simulate(group: Group, seed: int = 0) -> Samples:
    """Draw a group's stacks and simulate each with as many walks as its noise asks for.

    A pilot run measures the noise and is then thrown away, so that the number of walks does not
    depend on the values that are kept: the reference stays unbiased.
    """
    table, wi, wo, seeds = draw(group, seed)
    everything = np.arange(group.stacks)
    pilot = Samples(table, wi, wo, *_walk(table, everything, wi, wo, PILOT_WALKS, seeds[0]))
    excess = (np.maximum(*reference_error(pilot)) / REFERENCE_ERROR) ** 2
    walks = PILOT_WALKS * 2 ** np.ceil(np.log2(np.maximum(excess, 1))).astype(int)
    walks = np.minimum(walks, MAX_WALKS)
    f, se = np.empty_like(pilot.f), np.empty_like(pilot.se)
    with tqdm(total=int(walks.sum()), desc=group.name, unit="walk", disable=None) as progress:
        for count in np.unique(walks):
            rows = np.flatnonzero(walks == count)
            f[rows], se[rows] = _walk(table, rows, wi[rows], wo[rows], int(count), seeds[1])
            progress.update(int(count) * len(rows))
    return Samples(table, wi, wo, f, se)


def draw(group: Group, seed: int = 0) -> tuple[StackTable, np.ndarray, np.ndarray, tuple[int, int]]:
    """Draw the stacks, every stack's own pairs (S, M, 3), and seeds for two runs of walks."""
    if group.stacks < 1:
        raise ParameterError(f"group '{group.name}' has {group.stacks} stacks; it needs some")
    rng = np.random.default_rng((HELD_OUT_SEED, seed))
    table = group.distribution.sample(rng, group.stacks)
    for_e = directions.cosine_pairs(rng, group.stacks * E_PAIRS)
    for_p = directions.half_angle_pairs(rng, group.stacks * P_PAIRS)
    wi, wo = (
        np.concatenate([e.reshape(-1, E_PAIRS, 3), p.reshape(-1, P_PAIRS, 3)], axis=1)
        for e, p in zip(for_e, for_p, strict=True)
    )
    first, second = (int(word) for word in rng.integers(1 << 31, size=2))
    return table, wi, wo, (first, second)


def _walk(
    table: StackTable, rows: np.ndarray, wi: np.ndarray, wo: np.ndarray, walks: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Simulate some rows of the table at their pairs (R, M, 3); two arrays (R, M)."""
    shape = wi.shape[:2]
    row = np.repeat(rows.astype(np.uint32), shape[1])
    f, se = walk_pairs(table, row, wi.reshape(-1, 3), wo.reshape(-1, 3), walks=walks, seed=seed)
    return f.reshape(shape), se.reshape(shape)


def reference_error(samples: Samples) -> tuple[np.ndarray, np.ndarray]:
    """The reference's own error by stack: E of one standard error, and the median of P's.

    Returns:
        Two float64 arrays (S,).
    """
    return stack_errors(samples.f + samples.se, samples), np.median(
        pair_errors(samples.f + samples.se, samples), axis=1
    )


def stack_errors(f_hat: np.ndarray, samples: Samples) -> np.ndarray:
    """E of every stack, (S,), from values (S, M) at all pairs."""
    part = slice(None, E_PAIRS)
    cos_i, cos_o = samples.wi[:, part, 2], samples.wo[:, part, 2]
    return stack_metrics.stack_error(f_hat[:, part], samples.f[:, part], cos_i, cos_o)


def pair_errors(f_hat: np.ndarray, samples: Samples) -> np.ndarray:
    """P of every pair, (S, P_PAIRS), from values (S, M) at all pairs."""
    return stack_metrics.pair_error(f_hat[:, E_PAIRS:], samples.f[:, E_PAIRS:])


def predict(model: weights.Model, table: StackTable, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """The networks' values of the stacks: the bottom encoded, then coat upon coat layered.

    Args:
        model: the networks.
        table: S stacks over a described bottom.
        wi, wo: (S, M, 3) float32 unit vectors.

    Returns:
        float32 (S, M) [1/sr].
    """
    probe_wi, probe_wo = (np.tile(w, (len(table), 1)) for w in model.networks.pairs())
    row = np.repeat(np.arange(len(table), dtype=np.uint32), len(probe_wi) // len(table))
    bottom = evaluate.rows(table.kind, table.bottom, row, probe_wi, probe_wo)
    z = encode_texels(model, bottom.reshape(len(table), -1))
    for index in reversed(range(table.coats)):
        coat = {name: getattr(table, name)[:, index] for name in COAT_PARAMETERS}
        z = layer_texels(model, z, **coat)
    return model.networks.f(z[:, None], wi, wo)


def measure(model: weights.Model, group: Group, seed: int = 0) -> dict[str, Any]:
    """Errors of the networks on one group.

    Returns:
        name, stacks, and by metric "E" (over stacks) and "P" (over all pairs): mean, median, p95
        and reference, the reference's own error (mean of E, median of P).
    """
    samples = simulate(group, seed)
    f_hat = predict(model, samples.table, samples.wi, samples.wo)
    own_e, own_p = reference_error(samples)
    return {
        "name": group.name,
        "stacks": group.stacks,
        "E": metrics.summary(stack_errors(f_hat, samples)) | {"reference": float(own_e.mean())},
        "P": metrics.summary(pair_errors(f_hat, samples)) | {"reference": float(np.median(own_p))},
    }


def report(
    weights_path: str | os.PathLike | None = None,
    output: str | os.PathLike | None = None,
    *,
    groups: tuple[Group, ...] = GROUPS,
    seed: int = 0,
) -> str:
    """Measure networks on every group and tabulate the errors in percent.

    Args:
        weights_path: file of the networks; default: the shipped ones.
        output: JSON file to write the figures to.
        groups: what to measure.
        seed: of the held-out stacks; no seed of training data gives the same ones.

    Raises:
        FileError: the weights are missing or damaged, or `output` cannot be written.
    """
    model = default_model() if weights_path is None else weights.load(weights_path)
    results = [measure(model, group, seed) for group in groups]
    if output is not None:
        content = {"weights": model.fingerprint, "seed": seed, "groups": results}
        with atomic_write(output) as temporary:
            temporary.write_text(json.dumps(content, indent=2) + "\n")
    return tabulate(results)


def tabulate(results: list[dict[str, Any]]) -> str:
    """A table of `measure`'s results in percent, one line a group."""
    heads = [f"{metric} {key}" for metric, key in COLUMNS]
    width = max(len(result["name"]) for result in results)
    lines = [" ".join([f"{'[%]':<{width}}", *(f"{head:>11}" for head in heads)])]
    for result in results:
        numbers = (f"{100 * result[metric][key]:11.2f}" for metric, key in COLUMNS)
        lines.append(" ".join([f"{result['name']:<{width}}", *numbers]))
    return "\n".join(lines)
