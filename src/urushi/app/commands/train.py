"""`urushi train`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from urushi.app import extras


@dataclass(frozen=True)
class Train:
    """Train the networks by a preset: its data are simulated first, unless they are there.

    A run that was stopped resumes at its last checkpoint, and ends in the same weights.

    Example: urushi train --preset quick
    """

    preset: str = "quick"
    """Name of the preset."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("runs")
    """Folder for data, checkpoints and weights; the preset gets one of its own in it."""

    def run(self) -> int:
        extras.require("train")
        from urushi.train import loop, presets

        print(loop.train(presets.get(self.preset), self.output / self.preset))
        return 0
