"""The formulas of OpenPBR Surface 1.1.1, in the order of the specification.

Section numbers are the specification's (Andersson et al., OpenPBR Surface 1.1.1). All functions
take NumPy or Dr.Jit arrays; `xp` has their functions.

3.1    microfacet widths           `widths`, `lobe_widths`, `lobe_width`
3.2    index of the base           `relative_index`, `modulated_index`, `base_index`
3.2.2  glossy-diffuse base         `internal_reflectance`, `slab_albedo`, `promised`
       rough diffuse slab          `eon`, `eon_albedo`, `eon_mean_albedo`
3.2.3  medium of subsurface_color  `subsurface_albedo`
3.2.4  translucent medium          `translucent_medium`
3.4    darkening of the coat       `mean_fresnel`, `internal`, `boost`
3.5    fuzz                        `fuzz_albedo`, `fuzz_transform`, `fuzz_density`

The Fresnel terms (`fresnel`) and the coat's medium (`appearance`) are in `urushi.core`, section 3.3
is in `thin_film`.
"""

import functools
import math
from typing import Any

import numpy as np

from urushi.checks import ETA_RANGE, MIN_ALPHA, MIN_INDEX_STEP
from urushi.core.appearance import DIFFUSE, REFRACTED
from urushi.core.facets import multiple_albedo
from urushi.core.namespace import NUMPY, Namespace
from urushi.material import adding

#: Least index of refraction of a medium.
LEAST_INDEX = 0.1

#: Least colour of a medium.
LEAST_COLOR = 1e-6

#: Optical depth of the medium that stands for the half-space of a subsurface_color, over 1 - g.
HALF_SPACE = 200.0

#: Number of albedos at which its colours are computed.
COLORS = 25

#: Least fuzz_roughness that the fits of the fuzz cover.
LEAST_FUZZ_ROUGHNESS = 0.01


# 3.1 Microfacet model


def widths(roughness: Any, anisotropy: Any, xp: Namespace = NUMPY) -> tuple[Any, Any]:
    """The GGX widths along the tangent and across it: alpha_t^2 + alpha_b^2 = 2 roughness^4.

    roughness, anisotropy: in [0, 1].

    Returns:
        (alpha_t, alpha_b), zero or more; alpha_t may exceed one.
    """
    ratio = 1 - anisotropy
    along = roughness * roughness * xp.sqrt(2 / (1 + ratio * ratio))
    return along, ratio * along


def lobe_widths(roughness: Any, anisotropy: Any, xp: Namespace = NUMPY) -> tuple[Any, Any]:
    """`widths` clipped to [0.01, 1], which the interfaces take: a mirror has the narrowest lobe."""
    along, across = widths(roughness, anisotropy, xp)
    return tuple(xp.clip(width, MIN_ALPHA, 1) for width in (along, across))


def lobe_width(roughness: Any, xp: Namespace = NUMPY) -> Any:
    """The GGX width of an isotropic surface: roughness squared, at least 0.01."""
    return xp.clip(roughness * roughness, MIN_ALPHA, 1)


# 3.2 Base substrate: the index of the dielectric base


def relative_index(ior: Any, coat_ior: Any, coat_weight: Any, xp: Namespace = NUMPY) -> Any:
    """An index relative to the medium above: air, the coat, or linear in between (3.4).

    ior, coat_ior: zero or more, taken as at least `LEAST_INDEX`. coat_weight: in [0, 1].
    """
    ior, coat_ior = (xp.maximum(x, LEAST_INDEX) for x in (ior, coat_ior))
    return ior + coat_weight * (ior / coat_ior - ior)


def modulated_index(ratio: Any, specular_weight: Any, xp: Namespace = NUMPY) -> Any:
    """The relative index whose reflectance at normal incidence is specular_weight times another's.

    ratio: the other relative index, positive. specular_weight: zero or more.

    Returns:
        A positive ratio, on the same side of one; 1 where the interface vanishes. The reflectance
        is at most 0.98.
    """
    amplitude = (ratio - 1) / (ratio + 1)  # the signed root of the reflectance
    # An amplitude of one would be an index without bound; the interfaces end far below.
    scaled = xp.clip(amplitude * xp.sqrt(specular_weight), -0.99, 0.99)
    return (1 + scaled) / (1 - scaled)


def base_index(
    specular_ior: Any, coat_ior: Any, coat_weight: Any, specular_weight: Any, xp: Namespace = NUMPY
) -> Any:
    """The index of the dielectric base relative to the medium above it, in [1/3, 3].

    An index below one reflects totally at grazing angles, which light refracted by a smooth coat
    does not reach. The specification (3.4.4) recommends the inverse ratio where refraction by the
    coat is not followed; here it is followed.
    """
    ratio = relative_index(specular_ior, coat_ior, coat_weight, xp)
    return xp.clip(modulated_index(ratio, specular_weight, xp), 1 / 3, 3)


def interface_index(ratio: Any, xp: Namespace = NUMPY) -> Any:
    """A relative index in the range of the walk: in [0.5, 3], and 1 near 1."""
    ratio = xp.clip(ratio, *ETA_RANGE)
    return xp.where(xp.absolute(ratio - 1) < MIN_INDEX_STEP, 1, ratio)


# 3.2.2 Glossy-diffuse. The interface conserves energy and has the directional reflectance E(w). It
# passes 1 - E(w) of the light to a diffuse slab, whose reflection does not depend on the direction.
# All orders of reflection between both are a geometric series.


def internal_reflectance(passed_mean: Any, eta: Any) -> Any:
    """Share of diffuse light from below that the interface reflects down again.

    passed_mean: the cosine-weighted mean of 1 - E over the hemisphere above.
    eta: index of the slab relative to the medium above.

    Returns:
        1 - passed_mean / eta^2, in [0, 1).

    Source: reciprocity of the transmitted radiance; for smooth interfaces Elias and Elias 2001.
    """
    return 1 - passed_mean / (eta * eta)


def slab_albedo(color: Any, internal: Any) -> Any:
    """The albedo rho of the diffuse slab that gives the base the colour base_color.

    The specification defines base_color as the share of the transmitted light that leaves again
    at normal incidence, (1 - internal) rho / (1 - rho internal); this is solved for rho.

    color: base_weight times base_color, in [0, 1]. internal: of `internal_reflectance`.

    Returns:
        rho, in [0, 1], at least `color`.
    """
    return color / (1 - internal + color * internal)


def promised(rho: Any, internal: Any) -> Any:
    """The inverse of `slab_albedo`: the share of the transmitted light that leaves again."""
    return (1 - internal) * rho / (1 - rho * internal)


# 3.2.2 Diffuse slab: energy-preserving Oren-Nayar reflection. Cosines are to the normal, in [0, 1].
# `color` is the albedo of the facets and `roughness` is base_diffuse_roughness, both in [0, 1].
# Source: Portsmouth, Kutz and Hill 2025, EON: A practical energy-preserving rough diffuse BRDF; the
# single-scattering term is Fujii's (2012).

_EON_FIRST = 0.5 - 2 / (3 * math.pi)
_EON_SECOND = 2 / 3 - 28 / (15 * math.pi)


def eon_single_albedo(cosine: Any, roughness: Any, xp: Namespace = NUMPY) -> Any:
    """Directional albedo of the single-scattering term for a facet albedo of one."""
    sine = xp.sqrt(xp.maximum(1 - cosine * cosine, 0))
    angle = xp.arccos(xp.clip(cosine, 0, 1))
    # (sine / cosine)(1 - sine^3) without the quotient: 1 - sine^2 = cosine^2.
    ratio = sine * cosine * (1 + sine + sine * sine) / (1 + sine)
    g = sine * (angle - sine * cosine) + 2 / 3 * (ratio - sine)
    return (1 + roughness * g / math.pi) / (1 + _EON_FIRST * roughness)


def eon_single_mean(roughness: Any) -> Any:
    """The cosine-weighted mean of `eon_single_albedo` over the hemisphere."""
    return (1 + _EON_SECOND * roughness) / (1 + _EON_FIRST * roughness)


def eon_single_over_azimuths(i: Any, o: Any, roughness: Any) -> Any:
    """Mean over the azimuth of pi times the single-scattering term, for a facet albedo of one."""
    sines2 = np.maximum(1 - i * i, 0) * np.maximum(1 - o * o, 0)
    larger = np.maximum(np.maximum(i, o), 1e-7)
    shape = np.sqrt(sines2) * (1 / larger - 1) / math.pi
    return (1 + roughness * shape) / (1 + _EON_FIRST * roughness)


def eon_deviation(roughness: Any) -> Any:
    """Deviation of a white BRDF from a Lambertian one, as a share of the deviation at roughness 1.

    It is the same for all directions.
    """
    return roughness * ((1 + _EON_FIRST) / (1 + _EON_FIRST * roughness))


def eon_multiple_albedo(color: Any, roughness: Any) -> Any:
    """Albedo, by all further scattering, of the light that the single-scattering term loses."""
    return multiple_albedo(color, eon_single_mean(roughness))


def eon_albedo(cosine: Any, color: Any, roughness: Any, xp: Namespace = NUMPY) -> Any:
    """Directional albedo of the BRDF, one for a colour of one."""
    single = eon_single_albedo(cosine, roughness, xp)
    return color * single + eon_multiple_albedo(color, roughness) * (1 - single)


def eon_mean_albedo(color: Any, roughness: Any) -> Any:
    """The cosine-weighted mean of `eon_albedo` over the hemisphere."""
    mean = eon_single_mean(roughness)
    return color * mean + eon_multiple_albedo(color, roughness) * (1 - mean)


def eon(i: Any, o: Any, between: Any, color: Any, roughness: Any, xp: Namespace = NUMPY) -> Any:
    """The BRDF [1/sr], without cosine.

    i, o: cosines of wi and wo. between: the cosine between wi and wo.
    """
    s = between - i * o
    shape = xp.minimum(s, 0) + xp.maximum(s, 0) / xp.maximum(xp.maximum(i, o), 1e-7)
    single = color * (1 + roughness * shape) / (1 + _EON_FIRST * roughness)
    lost = [1 - eon_single_albedo(cosine, roughness, xp) for cosine in (i, o)]
    # For a roughness of zero nothing is lost, and the quotient is 0 / 0.
    share = lost[0] * lost[1] / xp.maximum(1 - eon_single_mean(roughness), 1e-7)
    return (single + eon_multiple_albedo(color, roughness) * share) / math.pi


# 3.2.3 and 3.2.4: the media of bodies that transmit light


def translucent_medium(color: Any, depth: float, scatter: Any) -> tuple[Any, Any]:
    """The extinction and scattering coefficients, (3,) each, of transmission_* parameters.

    color, scatter: (3,). depth: positive. Absorption has no negative channel.
    """
    scattering = scatter / depth
    absorption = -np.log(np.maximum(color, LEAST_COLOR)) / depth - scattering
    return absorption - min(absorption.min(), 0) + scattering, scattering


def subsurface_albedo(color: np.ndarray, g: float, eta: float) -> np.ndarray:
    """The single-scattering albedo of the medium that gives a body its subsurface_color.

    Args:
        color: share of the light along the normal that enters through the interface and leaves it
            again, in [0, 1].
        g: subsurface_scatter_anisotropy.
        eta: index of the body relative to the medium outside.

    Source: the specification inverts van de Hulst's albedo of a half-space without an interface.
    """
    s, colors = _colors(float(g), float(eta))
    s2 = np.interp(color, colors, s) ** 2
    return (1 - s2) / (1 - g * s2)


@functools.lru_cache(maxsize=16)
def _colors(g: float, eta: float) -> tuple[np.ndarray, np.ndarray]:
    """Van de Hulst's similarity parameters (N,), and colours (N,), nearly linear in them."""
    s = np.linspace(1, 0, COLORS)
    back, weights = adding.interface_modes(MIN_ALPHA, eta)[0], adding.grid().weights
    passed = weights * (1 - back @ weights)
    colors = [0.0]
    for x in s[1:-1] ** 2:
        albedo = (1 - x) / (1 - g * x)
        below = adding.medium(*adding.resolved(albedo, HALF_SPACE / (1 - g), g))[0][0]
        trapped = (below * weights) @ (back * weights)
        colors.append(np.linalg.solve(np.eye(len(weights)) - trapped, below)[0] @ passed)
    return s, np.array([*colors, 1.0])


# 3.4 Coat


def mean_fresnel(eta: Any) -> Any:
    """Cosine-weighted mean of the Fresnel reflectance of a smooth dielectric of index eta >= 1.

    Fitted to integrals in r = (eta - 1) / (eta + 1), which is the root of the reflectance at normal
    incidence: within 0.04 % of one up to an index of 3, within 0.5 % for all.
    """
    r = (eta - 1) / (eta + 1)
    return r * (0.64 + r * (2.75 + r * 2.16)) / (1 + r * (9.97 - r * 5.42))


def internal(coat_eta: Any, roughness: Any, metalness: Any, reflectance: Any) -> Any:
    """Share K of the light leaving the base that the coat's interface returns to it (3.4.1).

    It interpolates between the shares of diffuse light and of light along the normal, by the
    roughness of the base.

    Args:
        coat_eta: the coat's index. roughness: specular_roughness. metalness: base_metalness.
        reflectance: of the dielectric base's interface at normal incidence.
    """
    diffuse = internal_reflectance(1 - mean_fresnel(coat_eta), coat_eta)
    root = (coat_eta - 1) / (coat_eta + 1)
    dielectric = 1 + (roughness - 1) * reflectance
    rough = dielectric + (roughness - dielectric) * metalness
    return root * root + (diffuse - root * root) * rough


def boost(darkening: Any, k: Any, albedo: Any, color: Any = 1.0, xp: Namespace = NUMPY) -> Any:
    """The factor B of the base's BRDF under the coat for a coat_darkening in [0, 1] (3.4.1).

    The darkening results from the light transport between the layers. B cancels it: 1 for a
    darkening of one. For zero the coated albedo at normal incidence is F0 + (1 - F0) C E_b, which
    needs a base of albedo E_b / ((1 - K) P + K Q E_b): the specification's Delta = (1 - K) /
    (1 - B E_b K) with B Delta = 1, and a medium. P is the share that the medium passes of light
    that leaves obliquely, over light along the normal; Q, of light from the base to itself.

    k: K of `internal`. albedo: E_b, the base's directional albedo at normal incidence.
    color: C, coat_color.

    Returns:
        At least one. No base gets more than a white one that is not brightened, whose coated albedo
        is F0 + (1 - F0) C (1 - K) / (1 - K C) where the medium absorbs along the normal.
    """
    color = xp.clip(color, LEAST_COLOR, 1)
    oblique, inside = color ** (0.5 * (REFRACTED - 1)), color**DIFFUSE
    limit = xp.minimum(1, (1 - k) / (1 - k * color) / xp.maximum(albedo, 1e-6))
    undarkened = limit / ((1 - k) * oblique + k * inside * limit * albedo)
    return 1 + (xp.maximum(undarkened, 1) - 1) * (1 - darkening)


# 3.5 Fuzz: a layer of fibres, whose reflection is a linearly transformed cosine (Zeltner, Burley
# and Chiang 2022, Practical multiple-scattering sheen), by the rational fits of MaterialX.


def fuzz_albedo(cosine: Any, roughness: Any, xp: Namespace) -> Any:
    """Share of the light from a direction of a cosine in [0, 1] that white fuzz reflects."""
    x, y = cosine, xp.clip(roughness, LEAST_FUZZ_ROUGHNESS, 1)
    s = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y))
    m = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y)
    o = y * (0.000654023 + y * (-0.0207818 + 0.119681 * y)) / (1.26264 + y * (-1.92021 + y))
    t = (x - m) / s
    value = xp.exp(-0.5 * t * t) / (s * math.sqrt(2 * math.pi)) + o
    return xp.clip(value, 0, 1)


def fuzz_transform(cosine: Any, roughness: Any, xp: Namespace) -> tuple[Any, Any]:
    """a and c of the fuzz's lobe for a direction of a cosine.

    Directions of the lobe, transformed by [[a, 0, b], [0, a, 0], [0, 0, 1]], have cosine density.
    x has the azimuth of the given direction, and b = c sin.
    """
    x, y = cosine, xp.clip(roughness, LEAST_FUZZ_ROUGHNESS, 1)
    a = (2.58126 * x + 0.813703 * y) * y / (1 + 0.310327 * x * x + 2.60994 * x * y)
    # The fit of b has the factor sqrt(1 - x), the sine over sqrt(1 + x).
    c = (y - 1) * y * y * y / xp.sqrt(1 + x)
    return a, c / (2.54053e-5 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y)


def fuzz_density(cosine: Any, up: Any, across: Any, roughness: Any, xp: Namespace) -> Any:
    """The fuzz's lobe over its cosine: a density over the upper hemisphere is `up` times it [1/sr].

    Args:
        cosine: of the given direction.
        up: cosine of the other.
        across: product of both sines and of the cosine between the azimuths. It takes no azimuth,
            which the normal does not have.
        roughness: fuzz_roughness.
        xp: see the module.
    """
    a, c = fuzz_transform(cosine, roughness, xp)
    b2 = c * c * (1 - cosine * cosine)
    length2 = a * a * (1 - up * up) + up * (2 * a * c * across + (1 + b2) * up)
    ratio = a / length2
    return ratio * ratio / math.pi
