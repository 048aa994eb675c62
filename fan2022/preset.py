"""The preset of the paper's training, at full or smaller scale."""

from dataclasses import asdict, dataclass, field
from typing import Any

from fan2022.architecture import PaperArchitecture
from fan2022.networks import PAIRS
from fan2022.palette import PaperData
from fan2022.proxy import INCOMING
from urushi.errors import ParameterError


@dataclass(frozen=True)
class PaperPreset:
    """Neural Layered BRDFs (Fan et al. 2022, section 4), trained as published or smaller.

    `scale` is the share of the paper's 2.3e11 training samples: BRDFs and epochs shrink by its
    fourth root, direction pairs by its square root. The incoming directions of the sampling
    network's histograms shrink by its power of 1.5, to no less than 12. The total decay of the
    rates stays the same. The latents' rate is raised by the inverse square root of scale, at most a
    hundredfold, because the latents would otherwise stay near their initial value in the few steps.

    With `evaluation`, the fingerprint of networks whose evaluation network is kept, BRDFs are only
    projected. They have the 4,096 pairs of the authors' projection then, at all scales.

    Command: `python -m fan2022 train --scale 4e-5`
    Time: half an hour on two cores at that scale, 214 minutes at 8e-4, 40 hours of a GPU at 1.
    Expected: at that scale no sharp highlights, and errors far above the paper's; the header of the
        weights file has the mean absolute errors of the projections.
    """

    scale: float = 1.0
    # The projection, in training and later; the authors' number of pairs is 4,096.
    arch: PaperArchitecture = field(default_factory=lambda: PaperArchitecture(pairs=16))
    stacks: int = 64  # BRDFs in a step
    pairs: int = 64  # direction pairs of each
    seed: int = 0  # of the initial weights and of the order of the examples
    evaluation: str | None = None  # fingerprint of the networks whose evaluation network is kept

    name = "paper"  # of the default folder of its training

    def __post_init__(self) -> None:
        if not 0 < self.scale <= 1:
            raise ParameterError(f"the paper's scale is {self.scale!r}; it must be in (0, 1]")

    def to_dict(self) -> dict[str, Any]:
        """Describe the preset for JSON, in checkpoints and in the weights' header."""
        return {"name": self.name, **asdict(self), "data": asdict(self.data)}

    def _shrunk(self, count: int, least: int) -> int:
        return max(least, round(count * self.scale**0.25))

    @property
    def data(self) -> PaperData:
        pairs = PAIRS if self.evaluation else max(3, round(25 * self.scale**0.125)) ** 4
        counts = self._shrunk(300, 4), self._shrunk(12_720, 16), self._shrunk(1_800, 4)
        return PaperData(*counts, pairs)

    @property
    def validation(self) -> int:
        """Number of two-layer BRDFs, the last ones, that are not trained on."""
        return self._shrunk(720, 4)

    @property
    def trained(self) -> int:
        """Number of two-layer BRDFs to train on; they are the first ones of the part."""
        return self.data.two_layer - self.validation

    @property
    def epochs(self) -> int:
        """Passes over the two-layer BRDFs."""
        return self._shrunk(50, 1)

    def rates(self, epoch: int) -> tuple[float, float]:
        """Adam's learning rates of the evaluation network and of the latents in an epoch."""
        decay = 0.9 ** (50 / self.epochs)
        return 3e-4 * decay**epoch, 1e-4 * min(100.0, self.scale**-0.5) * decay**epoch

    @property
    def layering_epochs(self) -> int:
        """Passes of the layering network over the two-layer BRDFs."""
        return self._shrunk(1_000, 20)

    @property
    def finetuning_epochs(self) -> int:
        """Passes of the layering network over the three-layer BRDFs, after the others."""
        return self._shrunk(100, 2)

    @property
    def proxy_materials(self) -> int:
        """Materials that the sampling proxy learns from."""
        return self._shrunk(1_024, 4)

    @property
    def proxy_incoming(self) -> int:
        """Incoming directions over which the histograms of the proxy are averaged."""
        return max(INCOMING, round(1_600 * self.scale**1.5))
