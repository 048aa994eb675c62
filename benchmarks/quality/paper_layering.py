"""How well layering is learnt from a projection's codes: `quality.paper_layering WEIGHTS`.

Simulates a small set of stacks of one coat by Table 2 of Fan et al. (2022), projects them and their
components with the evaluation network of a weights file, and trains a layering network on three
quarters of the stacks. Prints the errors of the other quarter: of the projected codes and of those
that the layering network predicts, the mean absolute errors of f [1/sr] and of the compressed
x / (1 + x), x = f cos. About two minutes of one core for 64 stacks and 16 pairs.
"""

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

from urushi.fan2022 import PaperNetworks
from urushi.fan2022.architecture import AdamProjection, init
from urushi.fan2022.train import layering, preset
from urushi.fan2022.train import training as paper_training
from urushi.fan2022.train.preset import Palette
from urushi.fan2022.train.projection import project_part
from urushi.train.data.generate import generate
from urushi.train.data.spec import DataSpec, Part

#: Components of each kind, stratified pairs of each BRDF, walks for each, and epochs of training.
COMPONENTS, PAIRS, WALKS, EPOCHS = 8, 5**4, 256, 400


def small(stacks: int, adam: AdamProjection | None) -> preset.PaperPreset:
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
        preset.paper(1e-4, adam),
        data=DataSpec(parts, seed=1, shard=16),
        validation=stacks // 4,
        layering_epochs=EPOCHS,
        finetuning_epochs=0,
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("weights", help="weights file of the kind paper")
    parser.add_argument("--stacks", type=int, default=64)
    parser.add_argument("--pairs", type=int, help="of Adam's steps; default: Levenberg-Marquardt")
    options = parser.parse_args()
    model = PaperNetworks.read(options.weights)
    training = small(options.stacks, options.pairs and AdamProjection(pairs=options.pairs))
    with tempfile.TemporaryDirectory() as folder:
        store = generate(training.data, Path(folder) / "data.zarr")
        codes = {
            part.name: project_part(model.params, store, index, 0, training.arch.adam)[0]
            for index, part in enumerate(training.data.parts)
        }
        sets = layering.examples(training, codes)
        state = layering.start(init(0))
        for epoch in range(EPOCHS):
            state, loss = layering.learn_epoch(state, sets, training, epoch)
        params = {**model.params, **state.params}
        errors = paper_training.value_errors(params, training, store, sets["validation"])
    print(f"weights {model.fingerprint}, {options.stacks} stacks, {options.pairs or 'no'} pairs")
    spread = sets["validation"].target.std(axis=0).mean()
    held = float(layering.l1_loss(state.params, sets["validation"]))
    print(f"L1 of codes: trained {loss:.4f}, held out {held:.4f}, their spread {spread:.4f}")
    for name, value in errors.items():
        print(f"{name:<24}{value:.5f}")


if __name__ == "__main__":
    main()
