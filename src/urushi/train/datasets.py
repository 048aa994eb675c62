"""The training data of the presets, as specifications of data stores."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from urushi.data.distribution import Clear, Distribution, Extended, Table2
from urushi.data.spec import DataSpec, Part
from urushi.geometry.probe_pairs import PROBES

#: Numbers of stacks by distribution: "table2", or the kind of bottom of an `Extended`.
Counts = Mapping[str, int]
_NAMES = ("table2", "conductor", "conductor_complex", "dielectric", "diffuse", "mixture")


def validation(stacks: int = 64, walks: int = 8192) -> tuple[Part, ...]:
    """Table 2 stacks, never trained on, at the direction pairs of metrics E and P."""
    return (
        Part("validation-e", Table2(1), stacks, 128, walks, "cosine"),
        Part("validation-p", Table2(1), stacks, 128, walks, "half_angle"),
    )


def whole_domain(measured_like: bool = True) -> DataSpec:
    """Every kind of bottom under up to five coats: 11.0 G walks, about 22 minutes on two cores.

    Four fifths of the walks are spent on one coat, where the error must be a fraction of a percent.
    Deeper stacks train the layering network on its own outputs. 19,000 layered BRDFs also have
    values at the encoder's probe pairs. Bare bottoms are analytic and need no walks.

    measured_like: whether some bottoms are like measured BRDFs; without them it is 9.5 G walks.
    """
    deep = _counts(8, 4, 4, 2, 4, 6)
    layered = (_counts(128, 60, 44, 36, 60, 96), _counts(48, 16, 12, 8, 16, 24), deep, deep, deep)
    probed = _counts(2, 1, 1, 1, 1, 2)
    bare = _counts(0, 32, 16, 16, 2, 64)
    parts: list[Part] = []
    for coats, counts in enumerate(layered, start=1):
        parts += _parts("", counts, coats, pairs=256 if coats == 1 else 128, walks=64)
    for coats in (1, 2, 3):
        counts = {name: count if coats == 1 else count // 2 for name, count in probed.items()}
        parts += _parts("probed-", counts, coats, pairs=PROBES + 128, walks=128, of="probed")
    parts += [Part(f"bare-{kind}", Extended(0, kind), n, 256, 1) for kind, n in bare.items()]
    parts += validation()
    parts += _measured_like() if measured_like else []
    return DataSpec(tuple(parts), seed=1, shard=1024)


def enlarged_domain() -> DataSpec:
    """The whole domain and 9.7 G more walks of one coat: 20.9 G, about 28 minutes on two cores.

    After the layerer's own stages its error is mostly the noise of these walks. Lambertians are
    added, mostly at grazing angles: an excess of a few percent there makes the limit of energy
    darken white Lambertians at all angles. Clear coats are added because the stacks with the
    largest errors had them.
    """
    counts = {**_counts(80, 38, 27, 22, 38, 60), "measured_like": 40 * 1024}
    spec = whole_domain()
    more = _parts("more-", counts, coats=1, pairs=64, walks=256)
    matt = Part("more-bare-diffuse", Extended(0, "diffuse"), 14 * 1024, 256, 1, "grazing")
    bottoms = _counts(0, 128, 56, 48, 8, 40)
    clear = _parts("clear-", bottoms, coats=1, pairs=64, walks=256, drawn=_clear)
    return replace(spec, parts=(*spec.parts, *more, matt, *clear))


def _measured_like() -> list[Part]:
    """Bottoms whose tails and grazing behaviour are those of measured BRDFs, bare and coated."""
    kind = "measured_like"
    parts = [Part(f"bare-{kind}", Extended(0, kind), 96 * 1024, 256, 1)]
    for coats, thousands in enumerate((64, 12, 4, 3, 3), start=1):
        pairs = 256 if coats == 1 else 128
        parts += _parts("", {kind: 1024 * thousands}, coats, pairs=pairs, walks=64)
    for coats in (1, 2):
        parts += _parts(
            "probed-", {kind: 2048 // coats}, coats, pairs=PROBES + 128, walks=128, of="probed"
        )
    return parts


def _counts(*thousands: int) -> Counts:
    """Counts from multiples of 1,024 in the order of `_NAMES`; zeros are left out."""
    named = zip(_NAMES, thousands, strict=True)
    return {name: 1024 * count for name, count in named if count}


def _distribution(name: str, coats: int) -> Distribution:
    return Table2(coats) if name == "table2" else Extended(coats, name)


def _clear(name: str, coats: int) -> Distribution:
    return Clear(coats, name)


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
