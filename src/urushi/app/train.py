"""`urushi data`, `train` and `paper`: training data, training, and published networks."""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from urushi import files, platform
from urushi.errors import ParameterError, choice
from urushi.ranges import Pairs, Share

if TYPE_CHECKING:
    from urushi.fan2022.preset import PaperPreset
    from urushi.train.presets import Preset


def find_preset(
    name: str, scale: float | None = None, pairs: int | None = None
) -> "Preset | PaperPreset":
    """The training preset of a name; the others are for "paper", see `fan2022.preset.paper`."""
    from urushi.fan2022.preset import paper
    from urushi.train import presets

    if name == "paper":
        return paper(scale or 1.0, pairs or 16)
    if scale or pairs:
        raise ParameterError(
            f"the preset '{name}' takes neither --scale nor --projection-pairs; only 'paper' does"
        )
    if name not in presets.NAMES:
        names = *presets.NAMES, "paper"
        raise ParameterError(f"there is no preset '{name}'; {choice(name, names)}")
    return presets.get(name)


@dataclass(frozen=True)
class Train:
    """Train by a preset: basis and layering network. Missing training data are computed first.

    A run that was interrupted continues with --resume and ends in the same weights.

    Example: urushi train --preset default
    """

    preset: str = "default"
    """Name of the preset: default, anisotropic (two GGX widths), smoke (half a minute, a check that
    training runs), or paper (the system of Fan et al. 2022)."""
    scale: Share | None = None
    """Only for the preset "paper": fraction of its training samples to use, in (0, 1]. 4e-5 takes
    about half an hour on two cores."""
    projection_pairs: Pairs | None = None
    """Only for the preset "paper": direction pairs in each of the 1,000 steps of a projection.
    Default: 16; the authors' number is 4096."""
    data: Path | None = None
    """Folder of training data. Default: runs/PRESET/data."""
    run_folder: Path | None = None
    """Folder for checkpoints and log. Default: runs/PRESET."""
    output: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Weights file to write (.safetensors). Default: weights.safetensors in the run folder."""
    resume: bool = False
    """Continue from the checkpoint in the run folder."""

    def run(self) -> int:
        platform.require_extra("train")
        from urushi.fan2022 import training as paper_training
        from urushi.fan2022.preset import PaperPreset
        from urushi.train import training

        preset = find_preset(self.preset, self.scale, self.projection_pairs)
        train: Any = paper_training if isinstance(preset, PaperPreset) else training
        model = train.train(
            preset, data=self.data, out=self.output, run=self.run_folder, resume=self.resume
        )
        for name, value in model.header.get("metrics", {}).items():
            print(f"{name}  {value:.4g}")
        print(f"fingerprint  {model.fingerprint}")
        return 0


@dataclass(frozen=True)
class Data:
    """Compute the training data of a preset.

    An interrupted run continues where it stopped and ends in the same store.

    Example: urushi data --preset default -o runs/default/data
    """

    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Folder to write."""
    preset: str = "default"
    """Training preset whose data are computed: default, anisotropic, smoke or paper."""
    scale: Share | None = None
    """Only for the preset "paper": fraction of its training samples, as for `urushi train`."""

    def run(self) -> int:
        platform.require_extra("train")
        from urushi.fan2022 import store as walks
        from urushi.train import tables

        spec: Any = find_preset(self.preset, self.scale).data
        made: Any = tables if isinstance(spec, tables.TableSpec) else walks
        store = made.generate(spec, self.output)
        print(f"{self.output}  {store.hash()}")
        return 0


@dataclass(frozen=True)
class Paper:
    """Convert the published PyTorch networks of Fan et al. 2022 into a weights file.

    PyTorch is not needed, and no code in the files is executed. docs/published.md lists what the
    files may hold.

    Example: urushi paper RepreNetwork.pth LayeringNetwork.pth -o published.safetensors
    """

    representation: tyro.conf.Positional[Path]
    """File of the representation (evaluation) network (.pth)."""
    layering: tyro.conf.Positional[Path]
    """File of the layering network (.pth)."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Weights file to write (.safetensors)."""
    projection_pairs: Pairs = 64
    """Direction pairs in each of the 1,000 steps by which a BRDF is projected to a code. 64 take
    some seconds for each channel, the authors' 4096 some minutes."""
    fit_sampler: bool = False
    """Train a sampling network, a few minutes. Default: directions are drawn by the cosine."""

    def run(self) -> int:
        files.check_name(self.output)
        if self.fit_sampler:
            platform.require_extra("train")
        from urushi.fan2022 import PaperNetworks, published
        from urushi.fan2022.architecture import AdamProjection, PaperArchitecture

        params: dict[str, Any] = published.networks(self.representation, self.layering)
        adam = AdamProjection(pairs=self.projection_pairs)
        if self.fit_sampler:
            from urushi.fan2022.proxy import fitted_proxy

            fitted, divergence = fitted_proxy(params, adam)
            params |= fitted
            print(f"proxy divergence  {divergence:.4g}")
        else:
            params |= published.cosine_proxy()
        paths = {"representation": self.representation, "layering": self.layering}
        header = {
            "published": {
                name: {"file": path.name, "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}
                for name, path in paths.items()
            },
            "sampler": "fitted" if self.fit_sampler else "cosine",
        }
        networks = PaperNetworks(PaperArchitecture(adam), params, header).save(self.output)
        print(f"{self.output}  {networks.fingerprint}")
        return 0
