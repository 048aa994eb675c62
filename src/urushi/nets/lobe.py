"""The analytic lobe of a material: the reflection of its topmost interface, or of bare metal.

A latent code begins with the `LOBE_NUMBERS` numbers of one GGX lobe with the separable Smith term.
Its Fresnel term is a sum of Schlick's (1994) and of the exact one of an index eta - i k:

    F(c) = normal (1 - (1 - c)^5) + grazing (1 - c)^5 + exact F(c; eta, k)

A dielectric interface has exact = 1 and k = 0 (total reflection for eta < 1 included), a conductor
exact = 1, or normal = R0 and grazing = 1. All three factors are 0 for a surface without a lobe. The
BRDF is linear in the factors, so that blends of codes are blends of BRDFs if widths and indices
agree. The basis evaluates the rest of the BRDF.

A lobe of two widths has a seventh number, the width across the tangent (the y axis); its
first number is the width along it (the x axis).

Functions take arrays of NumPy or JAX. An argument `xp` lets them serve Dr.Jit and shaders, too.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from urushi.checks import Widths
from urushi.core import fresnel, microfacet
from urushi.core.namespace import Components, Namespace, arrays, components, stacked
from urushi.nets.features import Normalisation

#: The numbers: the GGX width, the factors of the Fresnel terms, and the complex index.
LOBE_NUMBERS = ("alpha", "normal", "grazing", "exact", "eta", "k")

#: The numbers of a lobe with one GGX width, and with two.
NUMBERS = {1: LOBE_NUMBERS, 2: ("alpha_u", *LOBE_NUMBERS[1:], "alpha_v")}

#: Places of the widths among these numbers.
WIDTH_PLACES = {1: (0,), 2: (0, len(LOBE_NUMBERS))}

#: The numbers of a surface without a lobe.
NO_LOBE = (1.0, 0.0, 0.0, 0.0, 1.5, 0.0)

#: Cosines at which `lobe_features` contains the reflectance.
COSINES = (1.0, 0.5, 0.2)

#: Features of a lobe: formula, mean, scale; see `lobe_features`. With F the reflectance, and F_m
#: its mean over `COSINES`.
FEATURE_TABLE = (
    ("s ln alpha, s = F_m / (F_m + 0.01)", -0.9, 1.1),
    ("s alpha", 0.22, 0.3),
    ("F(1)", 0.45, 0.4),
    ("F(0.5)", 0.47, 0.4),
    ("F(0.2)", 0.55, 0.35),
    ("ln(F_m + 0.01)", -1.5, 1.5),
)

#: Normalisations of the features of lobes with one width and with two, and their numbers. Each
#: further width has the first two features.
FEATURES = {1: Normalisation(FEATURE_TABLE), 2: Normalisation(FEATURE_TABLE + FEATURE_TABLE[:2])}
LOBE_FEATURES = {widths: len(own.constants) for widths, own in FEATURES.items()}

#: Mean reflectance at which half of a lobe's width counts in `lobe_features`.
VISIBLE = 0.01


def no_lobe(widths: int = 1) -> np.ndarray:
    """The numbers float32 (N,) of a surface without a lobe, for this number of widths."""
    return np.array(NO_LOBE + NO_LOBE[:1] * (widths - 1), np.float32)


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
    return reflectance_of([lobe[..., i] for i in range(1, 6)], cosine, arrays(lobe))


def reflectance_of(numbers: Sequence[Any], cosine: Any, xp: Namespace) -> Any:
    """The Fresnel term of the numbers normal, grazing, exact, eta and k at a cosine in [0, 1].

    None stands for numbers that are known: the factors normal and exact or eta are None for terms
    that vanish, exact alone is None for a factor of one, and k is None for dielectrics.
    """
    normal, grazing, factor, eta, k = numbers
    value: Any = 0.0
    if normal is not None:
        away = xp.named("away", 1.0 - cosine)
        away2 = xp.named("away2", away * away)
        fifth = xp.named("fifth", away2 * away2 * away)
        value = normal * (1.0 - fifth) + grazing * fifth
    if eta is not None:
        exact = fresnel.exact(cosine, eta, k, xp)
        value = value + (exact if factor is None else factor * exact)
    return xp.named("fresnel", value)


def f(lobe: Any, wi: Any, wo: Any) -> Any:
    """Return the lobe's BRDF (...) [1/sr] for lobes (..., N) and directions (..., 3).

    The arguments broadcast. wi and wo are above the horizon. Exchanging them gives the same bits.
    """
    return shape(width(lobe), wi, wo) * reflectance(lobe, cosine_to_facet(wi, wo))


def cosine_to_facet(wi: Any, wo: Any) -> Any:
    """Return the cosine (...) between either direction (..., 3) and their half vector."""
    return microfacet.facet_cosine(components(wi + wo), arrays(wi))


def shape(alpha: Any, wi: Any, wo: Any) -> Any:
    """Return `microfacet.lobe_shape` (...) [1/sr] of a GGX width alpha (...) or two `Widths`."""
    xp = arrays(wi)
    wi, wo = (Components(w.x, w.y, xp.positive(w.z)) for w in map(components, (wi, wo)))
    return microfacet.lobe_shape(alpha, wi, wo, microfacet.half_vector(wi, wo, xp), xp)


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
    alphas = [lobe[..., place] for place in WIDTH_PLACES[1 + (lobe.shape[-1] > 6)]]
    return FEATURES[len(alphas)](feature_columns(alphas, at, arrays(lobe)))


def feature_columns(alphas: Sequence[Any], at: Sequence[Any], xp: Namespace) -> list[Any]:
    """The features of a lobe before normalisation.

    alphas: its width or two. at: its reflectance at `COSINES`.
    """
    mean = xp.named("mean_fresnel", (at[0] + at[1] + at[2]) * (1.0 / 3.0))
    seen = xp.named("seen", mean / (mean + VISIBLE))
    first, *others = [[seen * xp.log(alpha), seen * alpha] for alpha in alphas]
    return [*first, *at, xp.log(mean + VISIBLE), *(x for other in others for x in other)]


def under(lobe: Any, index: Any) -> Any:
    """Return lobes (..., N) below a medium: indices of conductors (k > 0) are divided by `index`.

    index: (...) of that medium, relative to the one that lies above the lobes now.
    """
    xp = lobe.__array_namespace__()
    scale = xp.where(lobe[..., 5] > 0, 1 / index, 1.0)
    one = xp.ones_like(scale)
    return lobe * xp.stack([*[one] * 4, scale, scale, *[one] * (lobe.shape[-1] - 6)], axis=-1)


def of_coat(alpha: Any, eta: Any) -> Any:
    """Return the lobe (..., N) of a dielectric interface; alpha and eta broadcast.

    alpha: the GGX width, or two `Widths`, with which the lobe has a number more.
    """
    along, across = (alpha.u, [alpha.v]) if isinstance(alpha, Widths) else (alpha, [])
    xp = along.__array_namespace__()
    zero, one = xp.zeros_like(along), xp.ones_like(along)
    return stacked([along, zero, zero, one, eta, zero, *across])
