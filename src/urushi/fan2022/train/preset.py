"""The preset of the paper's training, at full or smaller scale."""

import json
from dataclasses import asdict, dataclass, field
from typing import Any

from urushi.errors import ParameterError
from urushi.fan2022.architecture import AdamProjection, PaperArchitecture
from urushi.fan2022.palette import Palette
from urushi.train.data.spec import DataSpec, Part

#: Pairs of direction strata in memory together, at most: bounds memory to some hundred MB.
SHARD_PAIRS = 1 << 21


@dataclass(frozen=True)
class PaperPreset:
    """Data and schedules of Fan et al. 2022, section 4.

    Attributes:
        name: the value of `--preset`.
        scale: share of the paper's number of training samples.
        data: parts "conductor", "dielectric", "two-layer" and "three-layer".
        validation: number of two-layer BRDFs, the last ones, that are not trained on.
        epochs, decay: passes over the two-layer BRDFs, and the factor on both rates after each.
        weights_rate, latents_rate: Adam's learning rates of evaluation network and latents.
        stacks, pairs: BRDFs in a step, and direction pairs of each.
        layering_epochs, layering_rate, layering_decay: training of the layering network; the rate
            is multiplied by the decay twenty times.
        finetuning_epochs, finetuning_rate: its training on the three-layer BRDFs, at a fixed rate.
        rows: layerings in a step.
        proxy_materials, proxy_incoming: materials that the sampling proxy learns from, and
            incoming directions over which their histograms are averaged.
        seed: of the initial weights and of the order of the examples.
        arch: the architecture, with the projection.
    """

    name: str
    scale: float
    data: DataSpec
    validation: int
    epochs: int
    decay: float
    weights_rate: float
    latents_rate: float
    layering_epochs: int
    finetuning_epochs: int
    proxy_materials: int
    proxy_incoming: int
    stacks: int = 64
    pairs: int = 64
    layering_rate: float = 3e-3
    layering_decay: float = 0.7
    finetuning_rate: float = 3e-4
    rows: int = 64
    seed: int = 0
    arch: PaperArchitecture = field(default_factory=PaperArchitecture)

    def part(self, name: str) -> Part:
        """A part of the data."""
        return next(part for part in self.data.parts if part.name == name)

    def to_dict(self) -> dict[str, Any]:
        """Describe the preset for JSON, in checkpoints and in the weights' header."""
        arch = json.loads(self.arch.to_json())
        return asdict(self) | {"data": self.data.to_dict(), "arch": arch}


def paper(scale: float = 1.0, adam: AdamProjection | None = None) -> PaperPreset:
    """Neural Layered BRDFs (Fan et al. 2022), trained as published or at a smaller scale.

    `scale` is the share of the paper's 2.3e11 training samples: BRDFs and epochs shrink by its
    fourth root, direction pairs by its square root. The total decay of the rates stays the same.
    The latents' rate is raised by the inverse square root of scale, at most a hundredfold, because
    the latents would otherwise stay near their initial value in the few steps. `adam`: project by
    Adam with these options, in training and in the weights file; None: by Levenberg-Marquardt.

    Command: `urushi train --preset paper --scale 4e-5`
    Time: at most 25 minutes on two cores at that scale, 214 at 8e-4, 40 hours of a GPU at 1.
    Expected: at that scale no sharp highlights, and errors far above the paper's; the header of the
        weights file has the mean absolute errors of the projections.
    """
    if not 0 < scale <= 1:
        raise ParameterError(f"the paper preset's scale is {scale!r}; it must be in (0, 1]")
    fourth = scale**0.25

    def shrunk(count: int, least: int) -> int:
        return max(least, round(count * fourth))

    pairs = max(3, round(25 * scale**0.125)) ** 4
    components, stacks, epochs = shrunk(300, 4), shrunk(12_720, 16), shrunk(50, 1)

    def part(name: str, coats: int, count: int, bottom: str = "conductor") -> Part:
        source = Palette(coats, bottom, components, stacks)
        return Part(name, source, count, pairs, 256 if coats else 1, "stratified")

    parts = (
        part("conductor", 0, components),
        part("dielectric", 0, components, "dielectric"),
        part("two-layer", 1, stacks),
        part("three-layer", 2, shrunk(1_800, 4)),
    )
    return PaperPreset(
        name="paper",
        scale=scale,
        data=DataSpec(parts, seed=1, shard=max(1, min(256, SHARD_PAIRS // pairs))),
        validation=shrunk(720, 4),
        epochs=epochs,
        decay=0.9 ** (50 / epochs),
        weights_rate=3e-4,
        latents_rate=1e-4 * min(100.0, scale**-0.5),
        layering_epochs=shrunk(1_000, 20),
        finetuning_epochs=shrunk(100, 2),
        proxy_materials=shrunk(1_024, 4),
        proxy_incoming=max(4, round(1_600 * scale**0.5)),
        arch=PaperArchitecture(adam),
    )
