"""The presets of `urushi train --preset NAME`: data, networks and stages, each a frozen value."""

import json
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from urushi.core.probe_pairs import ANISOTROPIC_PROBES, PROBES
from urushi.errors import ParameterError
from urushi.nets.architecture import Architecture
from urushi.train.distribution import (
    Anisotropic,
    Clear,
    Distribution,
    Extended,
    Practical,
    Table2,
)
from urushi.train.optimiser import Schedule
from urushi.train.stages import Stage
from urushi.train.stages.decoding import Decoding
from urushi.train.stages.joint import Joint
from urushi.train.stages.layering import Layering, MirroredLayering
from urushi.train.stages.sampling import Sampling
from urushi.train.store import DataSpec, Part
from urushi.walk.bottoms import KINDS


@dataclass(frozen=True)
class Preset:
    """A whole training: data, networks and stages."""

    name: str  # on the command line
    # The simulated data. The direction set of a part is one of `examples.TRAINING`, or of
    # `examples.METRICS` for validation.
    data: DataSpec
    stages: tuple[Stage, ...]  # in order, each with its own options
    pairs: int = 64  # direction pairs of each stack in a step, a multiple of 8 for the loss
    seed: int = 0  # of the initial weights and of the order of the examples
    arch: Architecture = field(default_factory=Architecture)  # sizes of the trained networks

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


#: Numbers of stacks by distribution: "table2", or the kind of bottom of an `Extended`.
Counts = Mapping[str, int]
_NAMES = (
    "table2",
    "conductor",
    "conductor_complex",
    "dielectric",
    "diffuse",
    "mixture",
    "measured_like",
)


def validation(stacks: int = 64, walks: int = 8192) -> tuple[Part, ...]:
    """Table 2 stacks, never trained on, at the direction pairs of metrics E and P."""
    return (
        Part("validation-e", Table2(1), stacks, 128, walks, "cosine"),
        Part("validation-p", Table2(1), stacks, 128, walks, "half_angle"),
    )


def whole_domain(share: float = 1.0) -> DataSpec:
    """Every kind of bottom under up to five coats: 20.6 G walks, 97 minutes on two cores.

    About half of the stacks are `Practical`; the others are spread over the whole domain. Most
    walks are spent on one coat, where the error must be a fraction of a percent; a part of them on
    clear coats, which are the hardest to predict. Deeper stacks train the layerer on its own
    outputs. Layered BRDFs with values at the encoder's probe pairs train the encoder. Bare bottoms
    are analytic and need no walks. Bottoms of one lobe teach the networks nothing and are left out.
    Matt bottoms have additional pairs at grazing angles: an excess of a few percent there makes the
    limit of energy darken white ones at all angles.

    share: factor on all numbers of stacks.
    """
    deep = _counts(6, 4, 4, 2, 4, 6, 3)
    layered = (
        _counts(96, 40, 30, 24, 40, 64, 40),
        _counts(56, 36, 28, 14, 28, 40, 18),
        deep,
        deep,
        deep,
    )
    practical = (
        _counts(0, 160, 120, 30, 80, 120, 40),
        _counts(0, 64, 48, 16, 48, 64, 24),
        _counts(0, 16, 12, 4, 12, 16, 6),
        _counts(0, 4, 3, 1, 3, 4, 2),
        _counts(0, 4, 3, 1, 3, 4, 2),
    )
    parts: list[Part] = []
    for coats, counts in enumerate(layered, start=1):
        parts += _parts("", counts, coats, pairs=256 if coats == 1 else 128, walks=64)
    for coats, counts in enumerate(practical, start=1):
        parts += _parts("practical-", counts, coats, pairs=128, walks=64, drawn=_practical)
    for coats in (1, 2, 3):
        counts = dict.fromkeys(_NAMES, 1024 * (2 if coats == 1 else 1))
        for name, drawn in {"probed-": _distribution, "probed-practical-": _practical}.items():
            parts += _parts(name, counts, coats, PROBES + 128, walks=128, of="probed", drawn=drawn)
    bare = {"diffuse": 2, "mixture": 64, "measured_like": 96}
    parts += [
        Part(f"bare-{kind}", Extended(0, kind), 1024 * thousands, 256, 1)
        for kind, thousands in bare.items()
    ]
    parts += [Part("grazing-bare-diffuse", Extended(0, "diffuse"), 14 * 1024, 256, 1, "grazing")]
    clear = _counts(0, 96, 48, 32, 8, 40, 16)
    parts += _parts("clear-", clear, coats=1, pairs=64, walks=128, drawn=_clear)
    parts = [replace(part, stacks=max(round(share * part.stacks), 1)) for part in parts]
    return DataSpec((*parts, *validation()), seed=1, shard=1024)


def anisotropic_domain() -> DataSpec:
    """Stacks of two widths under up to five coats: 4.6 G walks, half an hour on two cores.

    Bare bottoms of one lobe are left out.
    """
    kinds = ("conductor", "conductor_complex", "dielectric", "mixture", "diffuse", "measured_like")
    layered = ((40, 24, 12, 40, 16, 8), (28, 16, 8, 16, 8, 4), *3 * [(6, 4, 2, 4, 2, 2)])
    parts: list[Part] = []
    for coats, thousands in enumerate(layered, start=1):
        for kind, count in zip(kinds, thousands, strict=True):
            drawn = Anisotropic(coats, _anisotropic_bottom(kind), indices="whole")
            pairs = 256 if coats == 1 else 128
            name = f"{kind}-{coats}"
            parts.append(Part(name, drawn, 1024 * count, pairs, 64, "anisotropic"))
    for kind, count in {"conductor": 40, "conductor_complex": 20, "mixture": 56}.items():
        drawn = Anisotropic(1, _anisotropic_bottom(kind), indices="whole", clear=True)
        parts.append(Part(f"clear-{kind}-1", drawn, 1024 * count, 64, 128, "anisotropic"))
    for kind, count in {"mixture": 48, "diffuse": 2, "measured_like": 24}.items():
        drawn = Anisotropic(0, _anisotropic_bottom(kind))
        parts.append(Part(f"bare-{kind}", drawn, 1024 * count, 256, 1, "anisotropic"))
    held_back = Anisotropic(1, _anisotropic_bottom("conductor"))
    checks = (
        Part("validation-e", held_back, 64, 128, 8192, "cosine"),
        Part("validation-p", held_back, 64, 128, 8192, "slopes"),
    )
    return DataSpec((*parts, *checks), seed=2, shard=1024)


def _anisotropic_bottom(kind: str) -> str:
    """The kind with two widths, if there is one."""
    return f"{kind}_anisotropic" if f"{kind}_anisotropic" in KINDS else kind


def _counts(*thousands: int) -> Counts:
    """Counts from multiples of 1,024 in the order of `_NAMES`; zeros are left out."""
    named = zip(_NAMES, thousands, strict=True)
    return {name: 1024 * count for name, count in named if count}


def _distribution(name: str, coats: int) -> Distribution:
    return Table2(coats) if name == "table2" else Extended(coats, name, indices="whole")


def _clear(name: str, coats: int) -> Distribution:
    return Clear(coats, name, indices="whole")


def _practical(name: str, coats: int) -> Distribution:
    return Practical(coats, "conductor" if name == "table2" else name)


def _parts(
    prefix: str,
    counts: Counts,
    coats: int,
    pairs: int,
    walks: int,
    of: str = "training",
    drawn: Callable[[str, int], Distribution] = _distribution,
) -> list[Part]:
    return [
        Part(f"{prefix}{name}-{coats}", drawn(name, coats), count, pairs, walks, of)
        for name, count in counts.items()
    ]


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
