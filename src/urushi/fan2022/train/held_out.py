"""Errors of values on the two-layer BRDFs that no network was trained on."""

from collections.abc import Iterator, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from urushi.fan2022.adam import compressed
from urushi.fan2022.inference import LIGHT_COSINE, direction_inputs, evaluate, layer
from urushi.fan2022.train.layering import Examples
from urushi.fan2022.train.preset import PaperPreset
from urushi.nets.mlp import Params
from urushi.train.data.store import Store

#: Direction pairs of each BRDF, at most; they are drawn without replacement.
PAIRS = 4096


def value_errors(
    params: Params, preset: PaperPreset, store: Store, examples: Examples
) -> dict[str, float]:
    """Mean absolute errors of projected codes, and of those that the layering network predicts.

    They are given for f [1/sr] and, as "compressed", for x / (1 + x), where x is f times the
    light's cosine. The averages over BRDFs and stratified pairs weigh all angles equally.

    examples: the layerings of the last `preset.validation` two-layer BRDFs, in this order.
    """
    codes = {
        "projected": jnp.asarray(examples.target),
        "layered": layer(params, *map(jnp.asarray, examples[:4])),
    }
    sums: dict[str, list[float]] = {}
    rng = np.random.default_rng((preset.seed, 3))
    for index, (wi, wo, f) in enumerate(_brdfs(preset, store)):
        at = rng.permutation(len(f))[:PAIRS]
        directions = jnp.asarray(direction_inputs(wi[at], wo[at]))
        for name, z in codes.items():
            errors = _errors(params, z[index], directions, jnp.asarray(f[at]))
            for measure, value in zip(("L1", "compressed L1"), errors, strict=True):
                sums.setdefault(f"{measure} {name}", []).append(float(value))
    return {name: float(np.mean(values)) for name, values in sums.items()}


def _brdfs(preset: PaperPreset, store: Store) -> Iterator[tuple[np.ndarray, ...]]:
    """Directions wi, wo (P, 3) and values f (P,) of every held-out BRDF."""
    part = [described.name for described in preset.data.parts].index("two-layer")
    described = preset.data.parts[part]
    first = described.stacks - preset.validation
    for shard in range(store.spec.shard_count(described)):
        rows = preset.data.rows(part, shard)
        if rows.stop <= first:
            continue
        arrays: Mapping[str, Any] = store.read_shard(part, shard, ("wi", "wo", "f"))
        for row in range(max(first, rows.start) - rows.start, rows.stop - rows.start):
            yield arrays["wi"][row], arrays["wo"][row], arrays["f"][row]


@jax.jit
def _errors(params: Params, z: jax.Array, directions: jax.Array, f: jax.Array) -> tuple[Any, Any]:
    value = jnp.maximum(evaluate(params, z, directions), 0)
    cos = directions[:, LIGHT_COSINE]
    difference = compressed(value * cos) - compressed(f * cos)
    return jnp.mean(jnp.abs(value - f)), jnp.mean(jnp.abs(difference))
