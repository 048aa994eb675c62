"""`urushi train` and `urushi eval`: making networks, and measuring them on held-out stacks."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from urushi import platform
from urushi.errors import ParameterError

if TYPE_CHECKING:
    from urushi.paper.train.preset import PaperPreset
    from urushi.train.presets import Preset


def find_preset(name: str, scale: float | None = None) -> "Preset | PaperPreset":
    """The training preset of a name; scale: shrinks "paper", see `paper.train.preset.paper`.

    Raises:
        ParameterError: there is none of that name, or it cannot be scaled.
    """
    from urushi.paper.train.preset import paper
    from urushi.train import presets

    if name == "paper":
        return paper() if scale is None else paper(scale)
    if scale is not None and name in presets.NAMES:
        raise ParameterError(f"the preset '{name}' has one size; only 'paper' takes a scale")
    if name not in presets.NAMES:
        raise ParameterError(
            f"there is no preset '{name}'; choose one of {', '.join((*presets.NAMES, 'paper'))}"
        )
    return presets.get(name)


@dataclass(frozen=True)
class Train:
    """Train the networks by a preset: its data are simulated first, unless they are there.

    A run that was stopped goes on by --resume, and ends in the same weights.

    Example: urushi train --preset base
    """

    preset: str = "base"
    """Name of the preset: base, small, quick for experiments, smoke to see in half a minute that
    everything runs, or paper, the system of Fan et al. 2022."""
    scale: float | None = None
    """For the preset "paper": the share of its training samples that is seen, in (0, 1]; 4e-5 takes
    two cores about half an hour."""
    data: Path | None = None
    """Data store (.zarr); default: runs/PRESET/data.zarr."""
    run_folder: Path | None = None
    """Folder of checkpoints and log; default: runs/PRESET."""
    output: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Weights file to write (.safetensors); default: weights.safetensors in the run folder."""
    resume: bool = False
    """Go on from the run folder's checkpoint."""

    def run(self) -> int:
        platform.require_extra("train")
        from urushi.paper.train import training as paper_training
        from urushi.paper.train.preset import PaperPreset
        from urushi.train import training

        preset = find_preset(self.preset, self.scale)
        places: dict[str, Any] = {
            "data": self.data,
            "out": self.output,
            "run": self.run_folder,
            "resume": self.resume,
        }
        if isinstance(preset, PaperPreset):
            model = paper_training.train(preset, **places)
        else:
            model = training.train(preset, **places)
        for name, value in model.header.get("metrics", {}).items():
            print(f"{name}  {value:.4g}")
        print(f"fingerprint  {model.fingerprint}")
        return 0


@dataclass(frozen=True)
class Evaluate:
    """Measure networks on layered materials that they were not trained on.

    Prints the errors E (of energy) and P (of pairs) of every kind of stack, in percent, beside the
    reference's own; how well laws of physics are kept; sizes and times. docs/conventions.md says
    what E and P are. The reference values are stored: it takes seconds.

    Example: urushi eval --weights runs/small/weights.safetensors -o runs/small/figures
    """

    weights: str | None = None
    """Networks: base (the default), small, or a weights file."""
    output: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Folder to write the figures (JSON) and plots to."""
    seed: int | None = None
    """Simulate other stacks by this seed instead of the stored ones; about ten minutes."""
    protocol: Literal["table", "adapter"] = "table"
    """What to measure: the table, or, at 10 to 20 minutes, the direction tables of 89 stacks by
    which the Neural Material Adapter was compared."""

    def run(self) -> int:
        if self.protocol == "adapter":
            from urushi.eval import direction_tables

            if self.seed is not None:
                raise ParameterError("--seed goes with the table; leave it out with adapter")
            print(direction_tables.report(self.weights, self.output))
            return 0
        if self.output is not None:
            platform.require_extra("eval")
        from urushi.eval import report

        print(report.report(self.weights, self.output, seed=self.seed))
        return 0
