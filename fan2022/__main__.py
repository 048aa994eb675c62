"""`python -m fan2022`: training, the published networks, and scenes with the paper's plugins."""

import hashlib
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from fan2022 import PaperNetworks, published, separate_kernels
from fan2022.architecture import PaperArchitecture
from fan2022.preset import PaperPreset
from urushi import files, platform
from urushi.app import cli, render
from urushi.app.train import Training
from urushi.ranges import Pairs, Share


@dataclass(frozen=True)
class Train(Training):
    """Train the three networks as the paper does. Missing training data are computed first.

    A run that was interrupted continues with --resume and ends in the same weights. PRESET is
    paper.

    Example: python -m fan2022 train --scale 4e-5
    """

    scale: Share = 1.0
    """Fraction of the paper's training samples to use, in (0, 1]. 4e-5 takes about half an hour on
    two cores."""
    projection_pairs: Pairs = 16
    """Direction pairs in each of the 1,000 steps of a projection. The authors' number is 4096."""

    evaluation: Path | None = None
    """Weights file whose evaluation network is kept: the layering network and the sampling network
    alone are trained."""

    def trained(self, **options: Any) -> PaperNetworks:
        from fan2022.training import train

        kept = PaperNetworks.read(self.evaluation) if self.evaluation else None
        arch = PaperArchitecture(pairs=self.projection_pairs)
        preset = PaperPreset(self.scale, arch, evaluation=kept.fingerprint if kept else None)
        return train(preset, evaluation=kept, **options)


@dataclass(frozen=True)
class Import:
    """Convert the published PyTorch networks of Fan et al. 2022 into a weights file.

    PyTorch is not needed, and no code in the files is executed. docs/published.md lists what the
    files may hold.

    Example: python -m fan2022 import RepreNetwork.pth LayeringNetwork.pth -o published.safetensors
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
        params: dict[str, Any] = published.networks(self.representation, self.layering)
        arch = PaperArchitecture(pairs=self.projection_pairs)
        if self.fit_sampler:
            platform.require_extra("train")
            from fan2022.proxy import fitted_proxy

            fitted, divergence = fitted_proxy(params, arch)
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
        networks = PaperNetworks(arch, params, header).save(self.output)
        print(f"{self.output}  {networks.fingerprint}")
        return 0


@dataclass(frozen=True)
class Render(render.Render):
    """Render a scene with the plugins `fan2022_brdf` and `fan2022_layered`, as `urushi render`.

    Every layer of the networks has a kernel of its own.

    Example: python -m fan2022 render scene.xml -o scene.exr
    """

    #: Camera rays of a pass, at most: activations take about 4 kB for every ray.
    RAYS = 1 << 17

    def run(self) -> int:
        with separate_kernels():
            return super().run()


COMMANDS = {
    "train": (Train, "Train the networks of Fan et al. 2022."),
    "import": (Import, "Read the published networks of Fan et al. 2022."),
    "render": (Render, "Render a scene with the plugins of these networks."),
}


def main(args: list[str] | None = None) -> int:
    """Run a command as `urushi.app.cli.main` does."""
    return cli.main(args, COMMANDS, "python -m fan2022", __doc__ or "")


if __name__ == "__main__":
    sys.exit(main())
