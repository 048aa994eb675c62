"""The analytic lobe in Dr.Jit: the counterpart of `nets.lobe`.

Numbers of a lobe are lists of Dr.Jit floats in the order of `nets.lobe.NUMBERS`. A `LobeKind`
states what all lobes of a plugin have in common when its code is recorded: terms that vanish
everywhere are left out, and channels share equal terms.
"""

from collections.abc import Sequence
from typing import NamedTuple

import drjit as dr
import numpy as np

from urushi.checks import Widths
from urushi.nets.lobe import (
    COSINES,
    FEATURE_MEANS,
    FEATURE_SCALES,
    NUMBERS,
    VISIBLE,
    WIDTH_PLACES,
)


class LobeKind(NamedTuple):
    """What is known of the lobes of a plugin's codes, at all texels.

    Attributes:
        schlick: whether the factors normal and grazing may differ from zero.
        exact: whether the factor of the exact term may differ from zero.
        plain: whether that factor is one everywhere.
        absorbing: whether k may differ from zero.
        same_alpha: whether all channels have the same width.
        same_reflectance: whether all channels have the same five other numbers.
        widths: 2 if lobes have two widths.
    """

    schlick: bool = True
    exact: bool = True
    plain: bool = False
    absorbing: bool = True
    same_alpha: bool = False
    same_reflectance: bool = False
    widths: int = 1

    @property
    def size(self) -> int:
        """How many numbers a lobe has."""
        return len(NUMBERS[self.widths])

    @property
    def present(self) -> bool:
        """Whether any lobe reflects."""
        return self.schlick or self.exact

    def numbers(self, channel: int) -> list[int]:
        """Places of the numbers that the lobe of a channel needs, less those of the first one."""
        needed = {
            0: self.present,
            1: self.schlick,
            2: self.schlick,
            3: self.exact and not self.plain,
            4: self.exact,
            5: self.absorbing,
        }
        if self.widths == 2:
            needed[6] = self.present
        own = dict.fromkeys(needed, not self.same_reflectance)
        own |= dict.fromkeys(WIDTH_PLACES[self.widths], not self.same_alpha)
        return [i for i in needed if needed[i] and (own[i] or channel == 0)]

    def complete(self, lobes: Sequence[Sequence]) -> list[list]:
        """The lobes (N) of all channels from the numbers that `numbers` names, None elsewhere."""
        complete: list[list] = []
        for channel, given in enumerate(lobes):
            whole = [None] * self.size if channel == 0 else list(complete[0])
            for place, value in zip(self.numbers(channel), given, strict=True):
                whole[place] = value
            complete.append(whole)
        return complete

    def mean(self, latents: Sequence[Sequence]) -> list:
        """The mean over channels of codes that are lists of Dr.Jit floats."""
        alphas = WIDTH_PLACES[self.widths]
        same = [self.same_alpha if i in alphas else self.same_reflectance for i in range(self.size)]
        return [
            values[0] if place < self.size and same[place] else sum(values) * (1 / len(values))
            for place, values in enumerate(zip(*latents, strict=True))
        ]


#: No lobe reflects.
NO_LOBE = LobeKind(schlick=False, exact=False, absorbing=False)

#: Nothing is known of lobes of one width.
ANY_LOBE = LobeKind()


def kind_of(lowest: np.ndarray, highest: np.ndarray, same: np.ndarray) -> LobeKind:
    """The kind of lobes with numbers between lowest and highest (N,).

    same: (N,) whether a number is the same in all channels.
    """
    _, normal, grazing, exact, _, k, *across = np.maximum(abs(lowest), abs(highest)) > 0
    widths = 1 + len(across)
    return LobeKind(
        schlick=bool(normal or grazing),
        exact=bool(exact),
        plain=bool(lowest[3] == 1 and highest[3] == 1),
        absorbing=bool(exact and k),
        same_alpha=bool(same[list(WIDTH_PLACES[widths])].all()),
        same_reflectance=bool(same[1:6].all()),
        widths=widths,
    )


def f(lobes: Sequence[Sequence], wi, wo, kind: LobeKind) -> list:
    """The BRDF [1/sr] of each channel's lobe (N); wi and wo are above the horizon.

    Exchanging wi and wo gives the same bits.
    """
    h = wi + wo
    cosine = dr.minimum(0.5 * dr.sqrt(dr.fma(h.x, h.x, dr.fma(h.y, h.y, h.z * h.z))), 1)
    first = lobes[0]
    alphas = [_width(lobe, kind) for lobe in (lobes[:1] if kind.same_alpha else lobes)]
    shapes = [shape(alpha, wi, wo) for alpha in alphas]
    values = [
        reflectance(lobe, cosine, kind) for lobe in ([first] if kind.same_reflectance else lobes)
    ]
    if kind.same_alpha and kind.same_reflectance:
        return [shapes[0] * values[0]] * len(lobes)
    count = len(lobes)
    return [a * b for a, b in zip(_each(shapes, count), _each(values, count), strict=True)]


def _each(values: list, count: int) -> list:
    """One value for each of `count` channels."""
    return values * count if len(values) == 1 else values


def _width(lobe: Sequence, kind: LobeKind):
    """The width of a lobe (N), or the two `Widths`."""
    return lobe[0] if kind.widths == 1 else Widths(lobe[0], lobe[6])


def shape(alpha, wi, wo):
    """The lobe [1/sr] for a reflectance of one, see `nets.lobe.shape`."""
    if isinstance(alpha, Widths):
        return _anisotropic_shape(alpha, wi, wo)
    alpha2 = alpha * alpha
    x, y, z = wi.x + wo.x, wi.y + wo.y, wi.z + wo.z
    across, z2 = x * x + y * y, z * z
    rest = 1 - alpha2
    masking = (wi.z + dr.sqrt(alpha2 + rest * (wi.z * wi.z))) * (
        wo.z + dr.sqrt(alpha2 + rest * (wo.z * wo.z))
    )
    facing = across + alpha2 * z2 + 1e-18
    ratio = (across + z2) / facing
    return (alpha2 * dr.inv_pi) * (ratio * ratio) / masking


def _anisotropic_shape(alpha: Widths, wi, wo):
    """`shape` for two widths."""
    product, u_v, v_u = alpha.u * alpha.v, alpha.u / alpha.v, alpha.v / alpha.u
    x, y, z = wi.x + wo.x, wi.y + wo.y, wi.z + wo.z
    x2, y2, z2 = x * x, y * y, z * z

    def masked(w):
        sine2 = (w.x * w.x) * u_v + (w.y * w.y) * v_u
        return w.z + dr.sqrt(product * sine2 + w.z * w.z)

    ratio = (x2 + y2 + z2) / (x2 * v_u + y2 * u_v + product * z2 + 1e-18)
    return (product * dr.inv_pi) * (ratio * ratio) / (masked(wi) * masked(wo))


def reflectance(lobe: Sequence, cosine, kind: LobeKind):
    """F of a lobe (N) at a cosine to the facet's normal, see `nets.lobe.reflectance`."""
    normal, grazing, factor, eta, k = lobe[1:6]
    value = 0
    if kind.schlick:
        away = 1 - cosine
        away2 = away * away
        fifth = away2 * away2 * away
        value = normal * (1 - fifth) + grazing * fifth
    if kind.exact:
        exact = complex_fresnel(cosine, eta, k) if kind.absorbing else fresnel(cosine, eta)
        value = value + (exact if kind.plain else factor * exact)
    return value


def fresnel(cosine, eta):
    """Unpolarised reflectance of a smooth dielectric of index eta; eta < 1 reflects totally."""
    cos2 = cosine * cosine
    sin2 = 1 - cos2
    inside = (eta - 1) * (eta + 1) + cos2  # eta^2 - sin2 without loss of digits at grazing angles
    root = dr.sqrt(dr.select(inside > 0, inside, 0))
    across = root * cosine
    n1, d1 = root - cosine, root + cosine
    n2, d2 = across - sin2, across + sin2
    ratio = n1 / (d1 * d2 + 1e-12)
    return 0.5 * (ratio * ratio) * (d2 * d2 + n2 * n2)


def complex_fresnel(cosine, eta, k):
    """Unpolarised reflectance of a smooth surface of index eta - i k (PBRT v3, 8.2.1)."""
    cos2 = cosine * cosine
    sin2 = 1 - cos2
    eta2, k2 = eta * eta, k * k
    difference = ((eta - 1) * (eta + 1) - k2) + cos2  # eta^2 - k^2 - sin2
    size = dr.sqrt(difference * difference + 4 * eta2 * k2)
    above = 0.5 * (size + difference)  # zero under total reflection, where a selection keeps NaN
    a = dr.sqrt(dr.select(above > 0, above, 0))  # out of the derivative
    first, second = size + cos2, 2 * a * cosine
    third, fourth = cos2 * size + sin2 * sin2, second * sin2
    perpendicular = (first - second) / (first + second)
    ratio = (third - fourth + 1e-12) / (third + fourth + 1e-12)
    return 0.5 * perpendicular * (1 + ratio)


def lobe_features(lobe: Sequence, kind: LobeKind) -> list:
    """The features of a lobe (N), see `nets.lobe.lobe_features`."""
    alpha, across = lobe[0], lobe[6:]
    if kind.present:
        at = [reflectance(lobe, cosine, kind) for cosine in COSINES]
        mean = (at[0] + at[1] + at[2]) * (1 / 3)
        seen = mean / (mean + VISIBLE)
        columns = [seen * dr.log(alpha), seen * alpha, *at, dr.log(mean + VISIBLE)]
        columns += [x for width in across for x in (seen * dr.log(width), seen * width)]
    else:
        columns = [type(alpha)(0)] * 5 + [type(alpha)(float(np.log(VISIBLE)))]
        columns += [type(alpha)(0)] * (2 * len(across))
    further = 2 * len(across)
    means = FEATURE_MEANS + FEATURE_MEANS[:further]
    scales = FEATURE_SCALES + FEATURE_SCALES[:further]
    return [
        (column - offset) * (1 / scale)
        for column, offset, scale in zip(columns, means, scales, strict=True)
    ]
