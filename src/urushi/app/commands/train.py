"""`urushi train`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from urushi.app import extras


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
        extras.require("train")
        from urushi.train import loop, presets

        model = loop.train(
            self.preset if self.scale is None else presets.get(self.preset, self.scale),
            data=self.data,
            out=self.output,
            run=self.run_folder,
            resume=self.resume,
        )
        for name, value in model.header.get("metrics", {}).items():
            print(f"{name}  {value:.4g}")
        print(f"fingerprint  {model.fingerprint}")
        return 0
