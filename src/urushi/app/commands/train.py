"""`urushi data` and `urushi train`: training data and training."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from urushi import platform
from urushi.errors import ParameterError
from urushi.ranges import Pairs, Share

if TYPE_CHECKING:
    from urushi.fan2022.architecture import AdamProjection
    from urushi.fan2022.train.preset import PaperPreset
    from urushi.train.presets import Preset

ProjectionName = Literal["levenberg-marquardt", "adam"]


def find_preset(
    name: str, scale: float | None = None, adam: "AdamProjection | None" = None
) -> "Preset | PaperPreset":
    """The training preset of a name; the others are for "paper", see `fan2022.train.preset.paper`.

    Raises:
        ParameterError: there is no such preset, or it takes no scale or projection.
    """
    from urushi.fan2022.train.preset import paper
    from urushi.train import presets

    if name == "paper":
        return paper(1.0 if scale is None else scale, adam)
    if scale is not None and name in presets.NAMES:
        raise ParameterError(f"the preset '{name}' has one size; only 'paper' takes a scale")
    if adam is not None and name in presets.NAMES:
        raise ParameterError(f"the preset '{name}' has no projection; only 'paper' has one")
    if name not in presets.NAMES:
        raise ParameterError(
            f"there is no preset '{name}'; choose one of {', '.join((*presets.NAMES, 'paper'))}"
        )
    return presets.get(name)


def adam_projection(name: ProjectionName, pairs: int | None) -> "AdamProjection | None":
    """The options of a projection by name; None is Levenberg-Marquardt.

    Raises:
        ParameterError: the number of pairs is out of range, or given without Adam.
    """
    from urushi.fan2022.architecture import AdamProjection

    if name == "adam":
        return AdamProjection() if pairs is None else AdamProjection(pairs=pairs)
    if pairs is not None:
        raise ParameterError(
            "--projection-pairs needs --projection adam; give both, or leave it out"
        )
    return None


@dataclass(frozen=True)
class Train:
    """Train networks by a preset. Training data that are missing are simulated first.

    A run that was interrupted continues with --resume and ends in the same weights.

    Example: urushi train --preset default
    """

    preset: str = "default"
    """Name of the preset: default, anisotropic (two GGX widths), quick (for experiments), smoke
    (half a minute, a check that training runs), or paper (the system of Fan et al. 2022)."""
    scale: Share | None = None
    """Only for the preset "paper": fraction of its training samples to use, in (0, 1]. 4e-5 takes
    about half an hour on two cores."""
    projection: ProjectionName = "levenberg-marquardt"
    """Only for the preset "paper": how BRDFs are projected to codes. adam is the authors' way."""
    projection_pairs: Pairs | None = None
    """Only for the projection adam: direction pairs in each of its 1,000 steps. Default: 4096."""
    data: Path | None = None
    """Store of training data (.zarr). Default: runs/PRESET/data.zarr."""
    run_folder: Path | None = None
    """Folder for checkpoints and log. Default: runs/PRESET."""
    output: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Weights file to write (.safetensors). Default: weights.safetensors in the run folder."""
    resume: bool = False
    """Continue from the checkpoint in the run folder."""

    def run(self) -> int:
        platform.require_extra("train")
        from urushi.fan2022.train import training as paper_training
        from urushi.fan2022.train.preset import PaperPreset
        from urushi.train import training

        adam = adam_projection(self.projection, self.projection_pairs)
        preset = find_preset(self.preset, self.scale, adam)
        files: dict[str, Any] = {
            "data": self.data,
            "out": self.output,
            "run": self.run_folder,
            "resume": self.resume,
        }
        model: Any
        if isinstance(preset, PaperPreset):
            model = paper_training.train(preset, **files)
        else:
            model = training.train(preset, **files)
        for name, value in model.header.get("metrics", {}).items():
            print(f"{name}  {value:.4g}")
        print(f"fingerprint  {model.fingerprint}")
        return 0


@dataclass(frozen=True)
class Data:
    """Simulate the training data of a preset.

    An interrupted run continues where it stopped and ends in the same store.

    Example: urushi data --preset default -o runs/default.zarr
    """

    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Store to write (.zarr)."""
    preset: str = "default"
    """Training preset whose data are simulated: default, anisotropic, quick, smoke or paper."""
    scale: Share | None = None
    """Only for the preset "paper": fraction of its training samples, as for `urushi train`."""

    def run(self) -> int:
        platform.require_extra("train")
        from urushi.train.data.generate import generate

        preset = find_preset(self.preset, self.scale)
        store = generate(preset.data, self.output)
        print(f"{self.output}  {store.hash()}")
        return 0
