"""The analytic lobe in Dr.Jit, by the formulas of `core` and `nets.lobe`.

Numbers of a lobe are lists of Dr.Jit floats in the order of `nets.lobe.NUMBERS`. A `LobeKind`
states what all lobes of a plugin have in common when its code is recorded: terms that vanish
everywhere are left out, and channels share equal terms.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import Widths
from urushi.core import microfacet
from urushi.core.namespace import DRJIT
from urushi.nets.lobe import WIDTH_PLACES, reflectance_of
from urushi.nets.transmittance import has_edges, transmittance


class LobeKind(NamedTuple):
    """Properties that the lobes of a plugin's codes have at all texels."""

    #: Whether the number at each place may differ from its common value; the first: whether any
    #: lobe reflects.
    needed: tuple[bool, ...]
    edged: bool = True  # whether any may have edges of total reflection, see `has_edges`
    same_alpha: bool = False  # whether all channels have the same width
    same_reflectance: bool = False  # whether all channels have the same five other numbers

    @property
    def present(self) -> bool:
        """Whether any lobe reflects."""
        return self.needed[0]

    @property
    def widths(self) -> int:
        """2 if lobes have two widths."""
        return len(self.needed) - 5

    def numbers(self, channel: int) -> list[int]:
        """Places of the numbers of a channel's lobe that the first channel does not give."""
        shared = zip(self.needed, self._alike, strict=True)
        return [i for i, (needed, alike) in enumerate(shared) if needed and not (channel and alike)]

    def complete(self, lobes: Sequence[Sequence]) -> list[list]:
        """The lobes (N) of all channels from the numbers that `numbers` names, None elsewhere."""
        complete: list[list] = []
        for channel, given in enumerate(lobes):
            whole = [*complete[0]] if complete else [None] * len(self.needed)
            for place, value in zip(self.numbers(channel), given, strict=True):
                whole[place] = value
            complete.append(whole)
        return complete

    def mean(self, lobes: Sequence[Sequence]) -> list:
        """The mean over channels of lobes (N) of Dr.Jit floats."""
        return [
            values[0] if alike else sum(values) * (1 / len(values))
            for alike, values in zip(self._alike, zip(*lobes, strict=True), strict=True)
        ]

    @property
    def _alike(self) -> list[bool]:
        """Whether all channels have the same number at each place."""
        alphas = WIDTH_PLACES[self.widths]
        places = range(len(self.needed))
        return [self.same_alpha if i in alphas else self.same_reflectance for i in places]


#: No lobe reflects.
NO_LOBE = LobeKind((False,) * 6, edged=False)


def kind_of(lobes: np.ndarray) -> LobeKind:
    """Common properties of lobes (C, ..., N) of channels."""
    others = tuple(range(lobes.ndim - 1))
    same = (lobes == lobes[:1]).all(axis=others)
    _, normal, grazing, exact, _, k, *across = (lobes != 0).any(axis=others).tolist()
    schlick, plain = normal or grazing, bool((lobes[..., 3] == 1).all())
    present, places = schlick or exact, WIDTH_PLACES[1 + len(across)]
    needed = present, schlick, schlick, exact and not plain, exact, exact and k
    return LobeKind(
        (*needed, *[present] * len(across)),
        edged=bool(has_edges(lobes).any()),
        same_alpha=bool(same[list(places)].all()),
        same_reflectance=bool(same[1:6].all()),
    )


def f(lobes: Sequence[Sequence], wi, wo, kind: LobeKind) -> list:
    """The BRDF [1/sr] of each channel's lobe (N); wi and wo are above the horizon.

    Exchanging wi and wo gives the same bits.
    """
    if not kind.present:
        return [wi.z * 0] * len(lobes)
    h = wi + wo
    cosine = microfacet.facet_cosine(h, DRJIT)
    # Dr.Jit merges equal expressions of channels.
    return [
        microfacet.lobe_shape(width_of(lobe, kind), wi, wo, h, DRJIT)
        * reflectance(lobe, cosine, kind)
        for lobe in lobes
    ]


def with_rests(lobes: Sequence[Sequence], rests: Sequence, wi, wo, kind: LobeKind) -> list:
    """The BRDF [1/sr] of each channel: its lobe (N), and its rest through `nets.transmittance`.

    rests: g [1/sr] of each channel.
    """
    if not kind.present:
        return [*rests]
    if kind.edged:
        shares = [passed(lobe, wi, kind) * passed(lobe, wo, kind) for lobe in lobes]
        rests = [a * b for a, b in zip(shares, rests, strict=True)]
    return [a + b for a, b in zip(f(lobes, wi, wo, kind), rests, strict=True)]


def passed(lobe: Sequence, w, kind: LobeKind) -> Any:
    """T of a lobe (N) for a direction above the horizon, see `nets.transmittance`."""
    if not kind.edged:
        return 1.0
    numbers = [lobe[i] if kind.needed[i] else None for i in (3, 4, 5)]
    return transmittance(width_of(lobe, kind), numbers, w, DRJIT)


def width_of(lobe: Sequence, kind: LobeKind):
    """The width of a lobe (N), or the two `Widths`."""
    return lobe[0] if kind.widths == 1 else Widths(lobe[0], lobe[6])


def reflectance(lobe: Sequence, cosine, kind: LobeKind):
    """F of a lobe (N) at a cosine to the facet's normal, see `nets.lobe.reflectance_of`."""
    needed = kind.needed
    numbers = [lobe[i] if needed[i] else None for i in range(1, 6)]
    return reflectance_of(numbers, cosine, DRJIT)
