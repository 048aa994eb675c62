"""The trainings that `urushi train --preset NAME` knows, each a frozen value."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from urushi.data.distribution import Extended, Table2
from urushi.data.spec import DataSpec, Part
from urushi.errors import ParameterError
from urushi.nets.architecture import Architecture
from urushi.train.datasets import enlarged_domain, validation, whole_domain

#: What a schedule's precision and rule may be.
PRECISIONS = ("float32", "bfloat16")
RULES = ("muon", "soap")


@dataclass(frozen=True)
class Schedule:
    """How long and how fast one stage learns.

    Attributes:
        steps: optimiser steps; the learning rate falls to zero at the last one (half a cosine).
        warmup: steps in which the learning rate rises from zero.
        learning_rate: its peak.
        clip: largest norm of the gradient.
        average: decay by step of the exponential moving average of the weights that is exported.
        steps_per_call: steps that run in one call of the compiled loop.
        checkpoint_every: steps between two checkpoints, a multiple of `steps_per_call`.
        precision: of the hidden layers' products, "float32" or "bfloat16"; see `precision`.
        rule: of the optimiser, "muon" or "soap"; see `optimiser`.
    """

    steps: int
    warmup: int
    learning_rate: float
    clip: float = 1.0
    average: float = 0.999
    steps_per_call: int = 16
    checkpoint_every: int = 2048
    precision: str = "float32"
    rule: str = "muon"

    def __post_init__(self) -> None:
        for name, choices in (("precision", PRECISIONS), ("rule", RULES)):
            if getattr(self, name) not in choices:
                raise ParameterError(
                    f"the schedule's {name} is {getattr(self, name)!r}; choose one of "
                    + ", ".join(choices)
                )
        for name in ("steps", "checkpoint_every"):
            if getattr(self, name) % self.steps_per_call:
                raise ParameterError(
                    f"the schedule's {name} is {getattr(self, name)}; "
                    f"it must be a multiple of its {self.steps_per_call} steps_per_call"
                )


@dataclass(frozen=True)
class Layering:
    """The stage that trains the layerer alone, see `layering`.

    Attributes:
        schedule: as for the other stages.
        stacks: stacks of 1, 2, ... coats that a step sees.
        before: widths of the layerer's hidden layers in the stage before; None: as afterwards.
    """

    schedule: Schedule
    stacks: tuple[int, ...]
    before: tuple[int, ...] | None = None


@dataclass(frozen=True)
class Preset:
    """A whole training: data, networks, and its stages.

    Attributes:
        name: what `--preset` calls it.
        data: what is generated; its parts are `parts.TRAINING` or validate, by `parts.METRICS`.
        networks: schedule of encoder, layerer and decoder, trained together.
        layering: the stage that then trains the layerer alone.
        decoding: schedule of the decoder alone, on the codes of the others.
        relayering: schedule of the layerer once more, by that decoder; None: it stays as it is.
        proposal: schedule of the sampler, trained on their latents afterwards.
        stacks: stacks of 0, 1, 2, ... coats that a step sees.
        pairs: direction pairs that a step sees of each stack, a multiple of 8 for the loss.
        weigh_pairs: whether the decoder's stage weighs pairs by their scatter, see `decoding`.
        memory: direction pairs held in memory at most, 36 bytes each; a larger store streams.
        seed: of the initial weights and of the order of the examples.
        arch: sizes of the networks.
    """

    name: str
    data: DataSpec
    networks: Schedule
    layering: Layering
    decoding: Schedule
    relayering: Schedule | None
    proposal: Schedule
    stacks: tuple[int, ...]
    pairs: int = 64
    weigh_pairs: bool = True
    memory: int = 1 << 26
    seed: int = 0
    arch: Architecture = field(default_factory=Architecture)

    @property
    def first_arch(self) -> Architecture:
        """Sizes of the networks while they are trained together."""
        return replace(self.arch, layerer=self.layering.before or self.arch.layerer)

    def to_dict(self) -> dict[str, Any]:
        """Describe the preset for JSON, in checkpoints and in the weights' header."""
        return {
            "name": self.name,
            "data": self.data.to_dict(),
            "networks": asdict(self.networks),
            "layering": asdict(self.layering),
            "decoding": asdict(self.decoding),
            "relayering": self.relayering and asdict(self.relayering),
            "proposal": asdict(self.proposal),
            "stacks": list(self.stacks),
            "pairs": self.pairs,
            "weigh_pairs": self.weigh_pairs,
            "memory": self.memory,
            "seed": self.seed,
            "arch": asdict(self.arch),
        }


def _soap(steps: int, learning_rate: float) -> Schedule:
    return Schedule(
        steps=steps,
        warmup=128,
        learning_rate=learning_rate,
        clip=0.05,
        average=0.9995,
        rule="soap",
    )


def base() -> Preset:
    """The shipped default: the whole domain.

    Command: `urushi train --preset base`
    Time: 89 minutes on two cores (data 28, networks 39, layering 7, decoding 7, relayering 7,
        proposal 1).
    Expected of `urushi eval`: Table 2 stacks of two interfaces E mean 0.5 %, P median 0.3 %; the
        extended domain E mean 0.7 %, six interfaces 0.8 %.
    """
    return Preset(
        name="base",
        data=enlarged_domain(),
        networks=Schedule(steps=122_880, warmup=256, learning_rate=0.01, clip=0.1),
        layering=Layering(
            _soap(16_384, learning_rate=0.002), (512, 128, 48, 40, 40), before=(256, 256, 256)
        ),
        decoding=_soap(49_152, learning_rate=0.002),
        relayering=_soap(16_384, learning_rate=0.002),
        proposal=Schedule(steps=8_000, warmup=200, learning_rate=0.01, checkpoint_every=4_000),
        stacks=(64, 136, 40, 10, 7, 7),
        memory=1 << 28,
        arch=Architecture(decoder=(60, 60, 60), layerer=(288, 288, 288)),
    )


def small() -> Preset:
    """A decoder of 2,465 parameters and codes of 18 numbers, for rendering at the least cost.

    Its decoder has no room for measured-like BRDFs, which its data leave out. Clear coats, weights
    of pairs and a second stage of the layerer made most stacks better and the worst ones worse.

    Command: `urushi train --preset small`
    Time: 55 minutes on two cores that did other work as well (data 29, networks 18, the others 8).
    Expected of `urushi eval`: Table 2 stacks of two interfaces E mean 0.9 %, P median 0.7 %; the
        extended domain E mean 1.4 %, six interfaces 1.6 %.
    """
    return replace(
        base(),
        name="small",
        data=whole_domain(measured_like=False),
        stacks=(48, 128, 40, 10, 7, 7),
        networks=Schedule(steps=73_728, warmup=256, learning_rate=0.017, clip=0.3),
        layering=replace(base().layering, schedule=_soap(12_288, learning_rate=0.002)),
        decoding=_soap(10_240, learning_rate=0.002),
        relayering=None,
        weigh_pairs=False,
        pairs=128,
        arch=Architecture(latent=18, decoder=(32, 32), layerer=(320, 320, 320), activation="silu7"),
    )


def quick() -> Preset:
    """Table 2 first, and enough of everything else to be usable: for experiments.

    Command: `urushi train --preset quick`
    Time: 17 minutes on two cores (data 3.5, networks and proposal 13).
    Expected of `urushi eval`: Table 2 stacks of two interfaces E mean about 1.0 %, P median 0.8 %.
    """
    pairs, walks = 512, 32
    parts = (
        Part("table2", Table2(1), 20_480, pairs, walks),
        Part("conductor", Extended(1, "conductor"), 3_072, pairs, walks),
        Part("complex", Extended(1, "conductor_complex"), 2_048, pairs, walks),
        Part("diffuse", Extended(1, "diffuse"), 3_072, pairs, walks),
        Part("mixture", Extended(1, "mixture"), 5_120, pairs, walks),
        Part("table2-twice", Table2(2), 2_560, pairs, walks),
        Part("conductor-twice", Extended(2, "conductor"), 1_024, pairs, walks),
        Part("diffuse-twice", Extended(2, "diffuse"), 1_024, pairs, walks),
        Part("mixture-twice", Extended(2, "mixture"), 1_024, pairs, walks),
        Part("bare-conductor", Extended(0, "conductor"), 2_048, pairs, 1),
        Part("bare-complex", Extended(0, "conductor_complex"), 1_024, pairs, 1),
        Part("bare-dielectric", Extended(0, "dielectric"), 2_048, pairs, 1),
        Part("bare-diffuse", Extended(0, "diffuse"), 512, pairs, 1),
        Part("bare-mixture", Extended(0, "mixture"), 4_096, pairs, 1),
        *validation(),
    )
    return Preset(
        name="quick",
        data=DataSpec(parts, seed=1),
        networks=Schedule(steps=20_480, warmup=256, learning_rate=0.02, checkpoint_every=1_024),
        layering=Layering(_soap(4_096, learning_rate=0.002), (512, 128)),
        decoding=_soap(2_048, learning_rate=0.002),
        relayering=_soap(2_048, learning_rate=0.002),
        proposal=Schedule(steps=8_000, warmup=200, learning_rate=0.01, checkpoint_every=4_000),
        stacks=(36, 160, 44),
        pairs=128,
    )


def smoke() -> Preset:
    """The same system at a five-hundredth of the size, to see that everything runs.

    Command: `urushi train --preset smoke`
    Time: half a minute on two cores.
    Expected: no useful weights; E mean below 60 %.
    """
    parts = (
        Part("table2", Table2(1), 512, 128, 32),
        Part("diffuse-twice", Extended(2, "diffuse"), 128, 128, 32),
        Part("bare-conductor", Extended(0, "conductor"), 128, 128, 1),
        *validation(stacks=16, walks=256),
    )
    brief = Schedule(steps=128, warmup=16, learning_rate=0.001, average=0.95, rule="soap")
    return Preset(
        name="smoke",
        data=DataSpec(parts, seed=1),
        networks=Schedule(steps=512, warmup=64, learning_rate=0.02, average=0.98),
        layering=Layering(brief, (48, 8)),
        decoding=brief,
        relayering=brief,
        proposal=Schedule(steps=128, warmup=16, learning_rate=0.01, average=0.95),
        stacks=(8, 48, 8),
    )


_PRESETS: dict[str, Callable[[], Preset]] = {
    "base": base,
    "small": small,
    "quick": quick,
    "smoke": smoke,
}

#: The names that `--preset` takes.
NAMES = tuple(_PRESETS)


def get(name: str) -> Preset:
    """Look a preset up by name.

    Raises:
        ParameterError: there is none of that name.
    """
    if name not in _PRESETS:
        raise ParameterError(f"there is no preset '{name}'; choose one of {', '.join(NAMES)}")
    return _PRESETS[name]()
