"""The training data of the presets, as specifications of data stores."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from urushi.core.probe_pairs import PROBES
from urushi.train.distribution import (
    Anisotropic,
    Clear,
    Distribution,
    Extended,
    Practical,
    Table2,
)
from urushi.train.spec import DataSpec, Part
from urushi.walk.bottoms import KINDS

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
    are analytic and need no walks; those that are one lobe teach the networks nothing and are left
    out. Matt bottoms have additional pairs at grazing angles: an excess of a few percent there
    makes the limit of energy darken white ones at all angles.

    share: of all these numbers of stacks.
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

    Of bare bottoms only those are included that are more than one lobe.
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
