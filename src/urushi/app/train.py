"""`urushi data` and `urushi train`: training data, and training."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from urushi import platform


@dataclass(frozen=True)
class Training:
    """The options of all trainings, and what they print."""

    data: Path | None = None
    """Folder of training data. Default: runs/PRESET/data."""
    run_folder: Path | None = None
    """Folder for checkpoints and log. Default: runs/PRESET."""
    output: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Weights file to write (.safetensors). Default: weights.safetensors in the run folder."""
    resume: bool = False
    """Continue from the checkpoint in the run folder."""
    cluster: str | None = None
    """Who computes missing training data: the address of a scheduler of Dask, such as
    tcp://node:8786, or local:N, N processes. Default: this machine's cores."""

    def run(self) -> int:
        platform.require_extra("train")
        model = self.trained(
            data=self.data,
            out=self.output,
            run=self.run_folder,
            resume=self.resume,
            cluster=self.cluster,
        )
        for name, value in model.header.get("metrics", {}).items():
            print(f"{name}  {value:.4g}")
        print(f"fingerprint  {model.fingerprint}")
        return 0

    def trained(self, **options: Any) -> Any:
        """The networks, with `header` and `fingerprint`."""
        raise NotImplementedError


@dataclass(frozen=True)
class Train(Training):
    """Train by a preset: basis and layering network. Missing training data are computed first.

    A run that was interrupted continues with --resume and ends in the same weights.

    Example: urushi train --preset default
    """

    preset: str = "default"
    """Name of the preset: default, anisotropic (two GGX widths), or smoke (half a minute, a check
    that training runs)."""

    def trained(self, **options: Any) -> Any:
        from urushi.train import training

        return training.train(self.preset, **options)


@dataclass(frozen=True)
class Data:
    """Compute the training data of a preset.

    An interrupted run continues where it stopped and ends in the same store.

    Example: urushi data --preset default -o runs/default/data
    """

    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Folder to write."""
    preset: str = "default"
    """Training preset whose data are computed: default, anisotropic or smoke."""
    cluster: str | None = None
    """The address of a scheduler of Dask, or local:N, as for `urushi train`."""

    def run(self) -> int:
        platform.require_extra("train")
        from urushi.train import presets, tables

        spec = presets.get(self.preset).data
        store = tables.generate(spec, self.output, cluster=self.cluster)
        print(f"{self.output}  {store.hash()}")
        return 0
