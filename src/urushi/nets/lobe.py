"""The analytic lobe of a material: the reflection of its topmost interface, or of bare metal.

A latent code begins with the `LOBE_NUMBERS` numbers of one GGX lobe with the separable Smith term.
Its Fresnel term is a sum of Schlick's (1994) and of the exact one of an index eta - i k:

    F(c) = normal (1 - (1 - c)^5) + grazing (1 - c)^5 + exact F(c; eta, k)

A dielectric interface has exact = 1 and k = 0 (total reflection for eta < 1 included), a conductor
exact = 1, or normal = R0 and grazing = 1. All three factors are 0 for a surface without a lobe. The
BRDF is linear in the factors, so that blends of codes are blends of BRDFs if widths and indices
agree. The decoder evaluates the rest of the BRDF.

A lobe of anisotropic networks has a seventh number, the width across the tangent (the y axis); its
first number is the width along it (the x axis).

Functions take arrays of NumPy or JAX. `urushi.mitsuba.networks.lobe` is the counterpart in Dr.Jit.
"""

import math
from typing import Any

from urushi.checks import Widths
from urushi.nets.columns import Normalisation, stacked

#: The numbers: the GGX width, the factors of the Fresnel terms, and the complex index.
LOBE_NUMBERS = ("alpha", "normal", "grazing", "exact", "eta", "k")

#: The numbers of a lobe with one GGX width, and with two.
NUMBERS = {1: LOBE_NUMBERS, 2: ("alpha_u", *LOBE_NUMBERS[1:], "alpha_v")}

#: Places of the widths among these numbers.
WIDTH_PLACES = {1: (0,), 2: (0, len(LOBE_NUMBERS))}

#: The numbers of a surface without a lobe.
NO_LOBE = (1.0, 0.0, 0.0, 0.0, 1.5, 0.0)

#: Features of a lobe: mean and scale; see `lobe_features`. Each further width has the first two.
FEATURE_MEANS = (-0.9, 0.22, 0.45, 0.47, 0.55, -1.5)
FEATURE_SCALES = (1.1, 0.3, 0.4, 0.4, 0.35, 1.5)
LOBE_FEATURES = {1: len(FEATURE_MEANS), 2: len(FEATURE_MEANS) + 2}

_FEATURES = {
    6: Normalisation(FEATURE_MEANS, FEATURE_SCALES),
    7: Normalisation(FEATURE_MEANS + FEATURE_MEANS[:2], FEATURE_SCALES + FEATURE_SCALES[:2]),
}

#: Cosines at which `lobe_features` contains the reflectance.
COSINES = (1.0, 0.5, 0.2)

#: Mean reflectance at which half of a lobe's width counts in `lobe_features`.
VISIBLE = 0.01


def no_lobe(widths: int = 1) -> tuple[float, ...]:
    """The numbers of a surface without a lobe, for lobes with this number of widths."""
    return NO_LOBE + NO_LOBE[:1] * (widths - 1)


def width(lobe: Any) -> Any:
    """The GGX width (...) of lobes (..., 6), or the two `Widths` of lobes (..., 7)."""
    first = lobe[..., 0]
    return first if lobe.shape[-1] == len(LOBE_NUMBERS) else Widths(first, lobe[..., -1])


def with_two_widths(lobe: Any) -> Any:
    """Lobes (..., 7) of two equal widths from lobes (..., 6)."""
    xp = lobe.__array_namespace__()
    return xp.concat([lobe, lobe[..., :1]], axis=-1)


def reflectance(lobe: Any, cosine: Any) -> Any:
    """Return F (...) of lobes (..., N) at cosines (...) between direction and facet normal."""
    xp = lobe.__array_namespace__()
    away = xp.clip(1.0 - cosine, 0.0, 1.0)
    away2 = away * away
    fifth = away2 * away2 * away
    schlick = lobe[..., 1] * (1.0 - fifth) + lobe[..., 2] * fifth
    return schlick + lobe[..., 3] * fresnel(cosine, lobe[..., 4], lobe[..., 5])


def fresnel(cosine: Any, eta: Any, k: Any) -> Any:
    """Return the unpolarised reflectance of a smooth surface of index eta - i k (PBRT v3, 8.2.1).

    k = 0 is a dielectric; eta < 1 reflects totally beyond the critical angle.
    """
    xp = eta.__array_namespace__()
    cos2 = cosine * cosine
    sin2 = 1.0 - cos2
    # eta^2 - k^2 - sin2 without loss of digits at grazing angles
    difference = ((eta - 1.0) * (eta + 1.0) - k * k) + cos2
    size = xp.sqrt(difference * difference + 4.0 * (eta * eta) * (k * k))
    a = xp.sqrt(0.5 * _positive(size + difference))
    first, second = size + cos2, 2.0 * a * cosine
    perpendicular = (first - second) / (first + second)
    third, fourth = cos2 * size + sin2 * sin2, second * sin2
    ratio = (third - fourth + 1e-12) / (third + fourth + 1e-12)
    return 0.5 * perpendicular * (1.0 + ratio)


def _positive(x: Any) -> Any:
    """x, at least zero; by its real part if it is complex, as in a complex step."""
    xp = x.__array_namespace__()
    return xp.where(x.real > 0.0, x, 0.0)


def f(lobe: Any, wi: Any, wo: Any) -> Any:
    """Return the lobe's BRDF (...) [1/sr] for lobes (..., N) and directions (..., 3).

    The arguments broadcast. wi and wo are above the horizon. Exchanging them gives the same bits.
    """
    return shape(width(lobe), wi, wo) * reflectance(lobe, cosine_to_facet(wi, wo))


def cosine_to_facet(wi: Any, wo: Any) -> Any:
    """Return the cosine (...) between either direction (..., 3) and their half vector."""
    xp = wi.__array_namespace__()
    x, y, z = (wi[..., i] + wo[..., i] for i in range(3))
    return xp.clip(0.5 * xp.sqrt(x * x + y * y + z * z), 0.0, 1.0)


def shape(alpha: Any, wi: Any, wo: Any) -> Any:
    """Return the lobe (...) [1/sr] of a GGX width alpha (...) for a reflectance of one.

    D G / (4 cos_i cos_o) by Walter et al. (2007), eqs. 20, 33 and 34, written without the cosines
    in the denominator, and in the half vector wi + wo without normalising it. For two `Widths` see
    Heitz (2014), eqs. 80 and 85.
    """
    xp = wi.__array_namespace__()
    cos_i, cos_o = xp.clip(wi[..., 2], 0.0, 1.0), xp.clip(wo[..., 2], 0.0, 1.0)
    if isinstance(alpha, Widths):
        return _anisotropic_shape(alpha, wi, wo, cos_i, cos_o)
    alpha2 = alpha * alpha
    x, y, z = wi[..., 0] + wo[..., 0], wi[..., 1] + wo[..., 1], cos_i + cos_o
    across, z2 = x * x + y * y, z * z
    ratio = (across + z2) / (across + alpha2 * z2 + 1e-18)
    rest = 1.0 - alpha2
    masking = (cos_i + xp.sqrt(alpha2 + rest * (cos_i * cos_i))) * (
        cos_o + xp.sqrt(alpha2 + rest * (cos_o * cos_o))
    )
    return (alpha2 / math.pi) * (ratio * ratio) / masking


def _anisotropic_shape(alpha: Widths, wi: Any, wo: Any, cos_i: Any, cos_o: Any) -> Any:
    """`shape` for two widths."""
    xp = wi.__array_namespace__()
    product, u_v, v_u = alpha.u * alpha.v, alpha.u / alpha.v, alpha.v / alpha.u
    x, y, z = wi[..., 0] + wo[..., 0], wi[..., 1] + wo[..., 1], cos_i + cos_o
    x2, y2, z2 = x * x, y * y, z * z
    ratio = (x2 + y2 + z2) / (x2 * v_u + y2 * u_v + product * z2 + 1e-18)

    def masked(w: Any, cos: Any) -> Any:
        sine2 = (w[..., 0] * w[..., 0]) * u_v + (w[..., 1] * w[..., 1]) * v_u
        return cos + xp.sqrt(product * sine2 + cos * cos)

    return (product / math.pi) * (ratio * ratio) / (masked(wi, cos_i) * masked(wo, cos_o))


def lobe_features(lobe: Any) -> Any:
    """Return features (..., F) of lobes (..., N), about of mean 0 and variance 1.

    Width and logarithmic width, which vanish with the reflectance; the reflectance at three angles,
    and the logarithm of their mean; width and logarithmic width across the tangent, if the lobes
    have them.
    """
    xp = lobe.__array_namespace__()
    # One call for all cosines: for a few lobes, the number of calls is the price. The cosines come
    # first, so that many lobes are a row of numbers for NumPy.
    cosines = xp.asarray(COSINES, dtype=lobe.real.dtype).reshape((-1, *[1] * (lobe.ndim - 1)))
    at = list(reflectance(lobe, cosines))
    mean = (at[0] + at[1] + at[2]) * (1.0 / 3.0)
    seen = mean / (mean + VISIBLE)
    alpha = lobe[..., 0]
    columns = [seen * xp.log(alpha), seen * alpha, *at, xp.log(mean + VISIBLE)]
    if lobe.shape[-1] > len(LOBE_NUMBERS):
        across = lobe[..., -1]
        columns += [seen * xp.log(across), seen * across]
    return _FEATURES[lobe.shape[-1]](columns)


def scaled_lobe(lobe: Any, factor: Any) -> Any:
    """Return lobes (..., N) whose BRDF is `factor` (...) times that of `lobe` (..., N)."""
    xp = lobe.__array_namespace__()
    one = xp.ones_like(factor)
    others = [one] * (lobe.shape[-1] - 4)
    return lobe * xp.stack([one, factor, factor, factor, *others], axis=-1)


def of_coat(alpha: Any, eta: Any) -> Any:
    """Return the lobe (..., N) of a dielectric interface; alpha and eta broadcast.

    alpha: the GGX width, or two `Widths`, with which the lobe has a number more.
    """
    along, across = (alpha.u, [alpha.v]) if isinstance(alpha, Widths) else (alpha, [])
    xp = along.__array_namespace__()
    zero, one = xp.zeros_like(along), xp.ones_like(along)
    return stacked([along, zero, zero, one, eta, zero, *across])
