"""The presets of `urushi train --preset NAME`, each a frozen value."""

import json
from dataclasses import asdict, dataclass, field
from typing import Any

from urushi.core.probe_pairs import ANISOTROPIC_PROBES
from urushi.errors import ParameterError
from urushi.nets.architecture import Architecture
from urushi.train.datasets import anisotropic_domain, validation, whole_domain
from urushi.train.distribution import Extended, Table2
from urushi.train.optimiser import Schedule
from urushi.train.spec import DataSpec, Part
from urushi.train.stages.decoding import Decoding
from urushi.train.stages.joint import Joint
from urushi.train.stages.layering import Layering, MirroredLayering
from urushi.train.stages.sampling import Sampling
from urushi.train.stages.stage import Stage


@dataclass(frozen=True)
class Preset:
    """A whole training: data, networks and stages.

    Attributes:
        name: its name on the command line.
        data: what is simulated; every part has a direction set of `examples.TRAINING`, or one of
            `examples.METRICS` for validation.
        stages: in order, each with its own options.
        pairs: direction pairs of each stack in a step, a multiple of 8 for the loss.
        seed: of the initial weights and of the order of the examples.
        arch: sizes of the trained networks.
    """

    name: str
    data: DataSpec
    stages: tuple[Stage, ...]
    pairs: int = 64
    seed: int = 0
    arch: Architecture = field(default_factory=Architecture)

    def architectures(self) -> list[Architecture]:
        """Sizes of the networks before the first stage, and during and after each stage."""
        sizes = [self.arch]
        for stage in reversed(self.stages):
            sizes.append(stage.arch_before(sizes[-1]))
        return sizes[::-1]

    def to_dict(self) -> dict[str, Any]:
        """Describe the preset for JSON, in checkpoints and in the weights' header."""
        return {
            "name": self.name,
            "data": self.data.to_dict(),
            "stages": [{"kind": type(s).__name__.lower(), **asdict(s)} for s in self.stages],
            "pairs": self.pairs,
            "seed": self.seed,
            "arch": json.loads(self.arch.to_json()),
        }


def _soap(steps: int) -> Schedule:
    """Schedule of the stages that follow the joint one."""
    return Schedule(
        steps=steps,
        warmup=128,
        learning_rate=0.002,
        clip=0.05,
        average=0.9995,
        rule="soap",
    )


def default() -> Preset:
    """Networks with an analytic lobe for the whole domain.

    Command: `urushi train --preset default`
    Time: 61 minutes on two cores (data 35, joint 15, the rest 11).
    Expected of `benchmarks.evaluation`: Table 2, two interfaces, E mean 0.7 %, P median 0.4 %.
    """
    stacks, coated, energy = (40, 112, 64, 16, 8, 8), (448, 192, 64, 32, 32), 0.9
    joint = Schedule(steps=53_248, warmup=256, learning_rate=0.012, clip=0.1)
    sampling = Schedule(steps=8_000, warmup=200, learning_rate=0.01, checkpoint_every=4_000)
    return Preset(
        name="default",
        data=whole_domain(0.36),
        stages=(
            Joint(joint, stacks, energy),
            Layering(_soap(8_192), coated, (224, 224, 224), energy_share=energy),
            Decoding(_soap(16_384), stacks, energy_share=energy),
            Layering(_soap(12_288), coated, None, 2, energy, name="relayering"),
            Sampling(sampling),
        ),
        arch=Architecture(
            latent=24,
            decoder=(16, 16),
            layerer=(256, 256, 256),
            sampler=(16,),
            activation="silu7",
        ),
    )


def anisotropic() -> Preset:
    """Networks of two GGX widths a surface, which anisotropic materials use.

    Command: `urushi train --preset anisotropic`
    Time: 70 minutes on two cores (data 16, joint 22, the rest 29); twice as long with AVX2.
    Expected: stacks of two interfaces of two widths, any index, E mean 1.7 %, P median 1.0 %.
    """
    stacks, coated, energy = (48, 136, 40, 8, 8, 8), (512, 128, 48, 40, 40), 0.9
    joint = Schedule(steps=65_536, warmup=256, learning_rate=0.012, clip=0.1)
    sampling = Schedule(steps=6_000, warmup=200, learning_rate=0.01, checkpoint_every=2_000)
    return Preset(
        name="anisotropic",
        data=anisotropic_domain(),
        stages=(
            Joint(joint, stacks, energy),
            Layering(_soap(4_096), coated, (224, 224, 224), energy_share=energy),
            Decoding(_soap(16_384), stacks, energy_share=energy),
            MirroredLayering(
                _soap(32_768), coated, (256, 256, 256), 2, energy, name="mirrored layering"
            ),
            Sampling(sampling),
        ),
        arch=Architecture(
            latent=27,
            decoder=(20, 20),
            layerer=(384, 384, 384),
            sampler=(16,),
            activation="silu7",
            probes=ANISOTROPIC_PROBES,
            widths=2,
        ),
    )


def smoke() -> Preset:
    """A five-hundredth of `default`, to check that everything runs.

    Command: `urushi train --preset smoke`
    Time: half a minute on two cores.
    Expected: no useful weights; E mean below 60 %.
    """
    parts = (
        Part("table2", Table2(1), 512, 128, 32),
        Part("diffuse-twice", Extended(2, "diffuse"), 128, 128, 32),
        Part("bare-diffuse", Extended(0, "diffuse"), 128, 128, 1),
        *validation(stacks=16, walks=256),
    )
    stacks, coated = (8, 48, 8), (48, 8)
    brief = Schedule(steps=128, warmup=16, learning_rate=0.001, average=0.95, rule="soap")
    return Preset(
        name="smoke",
        data=DataSpec(parts, seed=1),
        stages=(
            Joint(Schedule(steps=512, warmup=64, learning_rate=0.02, average=0.98), stacks),
            Layering(brief, coated),
            Decoding(brief, stacks),
            Layering(brief, coated, seed_offset=2, name="relayering"),
            Sampling(Schedule(steps=128, warmup=16, learning_rate=0.01, average=0.95)),
        ),
        arch=Architecture(
            latent=24,
            decoder=(24, 24),
            encoder=(64, 64),
            layerer=(64, 64, 64),
            lobes=1,
            sampler=(16,),
        ),
    )


_PRESETS = {preset.__name__: preset for preset in (default, anisotropic, smoke)}

#: The names that `--preset` takes.
NAMES = tuple(_PRESETS)


def get(name: str) -> Preset:
    """Find a preset by name."""
    if name not in _PRESETS:
        raise ParameterError(f"there is no preset '{name}'; choose one of {', '.join(NAMES)}")
    return _PRESETS[name]()
