"""`urushi paper`: the published networks of Fan et al. 2022, from files of PyTorch."""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from urushi import platform
from urushi.app.commands.train import ProjectionName, adam_projection
from urushi.ranges import Pairs

#: Direction pairs in a step of the projection by Adam, unless a user gives another number.
PAIRS = 64


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
    projection: ProjectionName = "adam"
    """How BRDFs are projected to codes with these weights. adam is the authors' method; the
    layering network was trained on its codes. levenberg-marquardt takes a second per channel."""
    projection_pairs: Pairs | None = None
    """Only for the projection adam: direction pairs in each of its 1,000 steps. Default: 64, which
    takes some seconds for each channel. The authors' 4096 take some minutes."""
    fit_sampler: bool = False
    """Train a sampling network, a few minutes. Default: directions are drawn by the cosine."""

    def run(self) -> int:
        pairs = self.projection_pairs
        if pairs is None and self.projection == "adam":
            pairs = PAIRS
        adam = adam_projection(self.projection, pairs)
        if self.fit_sampler:
            platform.require_extra("train")
        from urushi.fan2022 import PaperNetworks, published
        from urushi.fan2022.architecture import PaperArchitecture

        params = published.networks(self.representation, self.layering)
        sampler = published.cosine_proxy()
        if self.fit_sampler:
            from urushi.fan2022.train.proxy import fitted_proxy

            fitted, divergence = fitted_proxy(params)
            sampler = dict(fitted)
            print(f"proxy divergence  {divergence:.4g}")
        header = {
            "published": {
                name: {"file": path.name, "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}
                for name, path in (
                    ("representation", self.representation),
                    ("layering", self.layering),
                )
            },
            "sampler": "fitted" if self.fit_sampler else "cosine",
        }
        arch = PaperArchitecture(adam)
        networks = PaperNetworks(arch, {**params, **sampler}, header).save(self.output)
        print(f"{self.output}  {networks.fingerprint}")
        return 0
