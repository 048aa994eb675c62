"""`urushi data`: stores of simulated BRDF values for training."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from urushi import platform
from urushi.app.commands.train import find_preset
from urushi.ranges import Share


@dataclass(frozen=True)
class Generate:
    """Simulate the training data of a preset.

    An interrupted run continues where it stopped and ends in the same store.

    Example: urushi data generate --preset default -o runs/default.zarr
    """

    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Store to write (.zarr)."""
    preset: str = "default"
    """Training preset whose data are simulated: default, anisotropic, quick, smoke or paper."""
    scale: Share | None = None
    """Only for the preset "paper": fraction of its training samples, as for `urushi train`."""

    def run(self) -> int:
        platform.require_extra("train")
        from urushi.train.data.store import generate

        preset = find_preset(self.preset, self.scale)
        store = generate(preset.data, self.output)
        print(f"{self.output}  {store.hash()}")
        return 0


@dataclass(frozen=True)
class Show:
    """Print the contents of a store and how much of it is simulated.

    Example: urushi data show runs/default.zarr
    """

    store: tyro.conf.Positional[Path]
    """Store to read (.zarr)."""

    def run(self) -> int:
        platform.require_extra("train")
        from urushi.train.data.store import Store

        store = Store.open(self.store)
        total, missing = len(list(store.spec.shards())), len(store.missing())
        print(f"{self.store}: seed {store.spec.seed}, {total - missing} of {total} shards done")
        for part in store.spec.parts:
            print(
                f"  {part.name}: {part.stacks:,} stacks × {part.pairs:,} pairs × "
                f"{part.walks:,} walks of {part.distribution}"
            )
        return 0


@dataclass(frozen=True)
class Data:
    """Simulate training data, or show what a store holds.

    Example: urushi data generate --preset default -o runs/default.zarr
    """

    command: (
        Annotated[Generate, tyro.conf.subcommand("generate")]
        | Annotated[Show, tyro.conf.subcommand("show")]
    )

    def run(self) -> int:
        return self.command.run()
