"""How well layering is learnt from a projection's codes: `quality.paper_layering WEIGHTS`.

Simulates a small set of stacks of one coat by Table 2 of Fan et al. (2022), projects them and their
components with the evaluation network of a weights file, and trains a layering network on three
quarters of the stacks. Prints the errors of the other quarter: of the projected codes and of those
that the layering network predicts, the mean absolute errors of f [1/sr] and of the compressed
x / (1 + x), x = f cos. About two minutes of one core for 64 stacks and 16 pairs.
"""

import argparse
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from urushi.fan2022 import PaperNetworks, layering, preset
from urushi.fan2022.architecture import init
from urushi.fan2022.inference import LIGHT_COSINE, direction_inputs, evaluate, layer
from urushi.fan2022.preset import Palette, PaperPreset
from urushi.fan2022.projection import compressed
from urushi.fan2022.store import DataSpec, Part, Store, generate
from urushi.fan2022.training import project_shard
from urushi.nets.mlp import Params

#: Components of each kind, stratified pairs of each BRDF, walks for each, and epochs of training.
COMPONENTS, PAIRS, WALKS, EPOCHS = 8, 5**4, 256, 400

#: Direction pairs of each BRDF in `value_errors`, at most; they are drawn without replacement.
VALUE_PAIRS = 4096


def small(stacks: int, pairs: int) -> PaperPreset:
    """The paper's training with few stacks, which its scale alone would not give."""

    def part(name: str, coats: int, count: int, bottom: str = "conductor") -> Part:
        source = Palette(coats, bottom, COMPONENTS, stacks, seed=1000)
        return Part(name, source, count, PAIRS, WALKS if coats else 1, "stratified")

    parts = (
        part("conductor", 0, COMPONENTS),
        part("dielectric", 0, COMPONENTS, "dielectric"),
        part("two-layer", 1, stacks),
        part("three-layer", 2, 1),  # not used, as there is no finetuning
    )
    return replace(
        preset.paper(1e-4, pairs),
        data=DataSpec(parts, seed=1, shard=16),
        validation=stacks // 4,
        layering_epochs=EPOCHS,
        finetuning_epochs=0,
    )


def value_errors(
    params: Params, preset: PaperPreset, store: Store, examples: layering.Examples
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
        at = rng.permutation(len(f))[:VALUE_PAIRS]
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


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("weights", help="weights file of the kind paper")
    parser.add_argument("--stacks", type=int, default=64)
    parser.add_argument("--pairs", type=int, default=16, help="of a projection's steps")
    options = parser.parse_args()
    model = PaperNetworks.read(options.weights)
    training = small(options.stacks, options.pairs)
    with tempfile.TemporaryDirectory() as folder:
        store = generate(training.data, Path(folder) / "data")
        codes = {
            part.name: np.concatenate(
                [
                    project_shard(model.params, store, index, shard, training.arch.adam)[0]
                    for shard in range(store.spec.shard_count(part))
                ]
            )
            for index, part in enumerate(training.data.parts)
        }
        sets = layering.examples(training, codes)
        state = layering.start(init(0))
        for epoch in range(EPOCHS):
            state, loss = layering.learn_epoch(state, sets, training, epoch)
        params = {**model.params, **state.params}
        errors = value_errors(params, training, store, sets["validation"])
    print(f"weights {model.fingerprint}, {options.stacks} stacks, {options.pairs} pairs")
    spread = sets["validation"].target.std(axis=0).mean()
    held = float(layering.l1_loss(state.params, sets["validation"]))
    print(f"L1 of codes: trained {loss:.4f}, held out {held:.4f}, their spread {spread:.4f}")
    for name, value in errors.items():
        print(f"{name:<24}{value:.5f}")


if __name__ == "__main__":
    main()
