"""Coated surfaces by the specification's recipe, in closed form: what other renderers evaluate.

The recipe multiplies the base by the transmittance of the coat's interface (albedo scaling), by
coat_color and by a darkening factor, and widens the base's lobes (roughening). It does not follow
light through the coat. Three forms of it differ in the scaling of the base; see `Recipe`.
"""

from typing import Any, Literal, NamedTuple

import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.core import albedos, fresnel
from urushi.core.namespace import NUMPY
from urushi.errors import ParameterError
from urushi.openpbr_surface import formulas
from urushi.openpbr_surface.parameters import complete

#: "materialx": the graph `open_pbr_surface.mtlx` of MaterialX 1.39 as its generator for GLSL has
#: it; coat_color is the same for all directions. "specification": the text of OpenPBR 1.1.1, with
#: absorption by the refracted directions, a darkening by the base's roughness and the albedos of
#: exact Fresnel terms. "two_sided": as
#: the text, but the base is scaled by what the interface passes on both ways, the layering of the
#: coat in Adobe's openpbr-bsdf.
Recipe = Literal["materialx", "specification", "two_sided"]

RECIPES: tuple[Recipe, ...] = ("materialx", "specification", "two_sided")

#: Parameters that must have their defaults: the recipe is written for opaque coated surfaces.
_ABSENT = (
    *("transmission_weight", "subsurface_weight", "fuzz_weight", "thin_film_weight"),
    *("emission_luminance", "geometry_thin_walled"),
)

#: Coefficients of MaterialX's rational fit to the albedo of GGX facets (Apache-2.0): rows are the
#: powers of cosine x and width y (1, x, y, xy, x^2, y^2, x^2 y, x y^2, x^2 y^2), columns the
#: numerators of the factors of F0 and F90 and their denominators.
_FIT = np.array(
    [
        [0.1003, 0.9345, 1.0, 1.0],
        [-0.6303, -2.323, -1.765, 0.2281],
        [9.748, 2.229, 8.263, 15.94],
        [-2.038, -3.748, 11.53, -55.83],
        [29.34, 1.424, 28.96, 13.08],
        [-8.245, -0.7684, -7.507, 41.26],
        [-26.44, 1.436, -36.11, 54.9],
        [19.99, 0.2913, 15.86, 300.2],
        [-5.448, 0.6286, 33.37, -285.1],
    ]
)


class _Pairs(NamedTuple):
    """Cosines (N, 1) of N pairs; `half` is the half vector (N, 3), `facet` its cosine to both."""

    i: np.ndarray
    o: np.ndarray
    half: np.ndarray
    facet: np.ndarray
    between: np.ndarray


def f(
    parameters: dict[str, Any], wi: np.ndarray, wo: np.ndarray, recipe: Recipe = "materialx"
) -> np.ndarray:
    """The BRDF by the recipe.

    Args:
        parameters: of OpenPBR, constants by name; others have their defaults.
        wi, wo: (N, 3) unit vectors above the horizon, z the normal and x the tangent. wi is the
            direction of view, which matters: the recipe is not reciprocal.
        recipe: see `Recipe`.

    Returns:
        (N, 3) [1/sr], without cosine.

    Raises:
        ParameterError: a parameter does not exist, is out of range, or does not belong to an opaque
            surface with base and coat.

    Source: Andersson et al., OpenPBR Surface 1.1.1, Coat; `open_pbr_surface.mtlx` and the nodes of
    MaterialX 1.39.5.
    """
    p = complete(parameters, "recipe")
    for name in _ABSENT:
        if p[name]:
            raise ParameterError(
                f"recipe: {name} is {p[name]:g}; the recipe has base and coat only"
            )
    pairs = _pairs(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
    coat = p["coat_weight"]
    base = _base(p, pairs, recipe)
    if coat == 0:
        return base
    widths = _widths(p["coat_roughness"], p["coat_roughness_anisotropy"])
    reflection, passed = _dielectric(pairs, p["coat_ior"], widths, recipe)
    base = base * _darkening(p, recipe) * _absorption(p, pairs, recipe)
    scale = 1 - coat * (1 - passed(pairs.i))
    if recipe == "two_sided":
        scale = scale * (1 - coat * (1 - passed(pairs.o)))
    return coat * reflection + scale * base


def _pairs(wi: np.ndarray, wo: np.ndarray) -> _Pairs:
    half = wi + wo
    half = half / np.linalg.norm(half, axis=1, keepdims=True)
    dot = (wi * half).sum(1, keepdims=True)
    between = (wi * wo).sum(1, keepdims=True)
    return _Pairs(wi[:, 2:], wo[:, 2:], half, dot, between)


def _base(p: dict[str, Any], pairs: _Pairs, recipe: Recipe) -> np.ndarray:
    """The base, whose lobes the coat widens (3.4.3)."""
    coat, rough = p["coat_weight"], p["specular_roughness"]
    covered = min(1.0, rough**4 + 2 * p["coat_roughness"] ** 4) ** 0.25
    rough = rough + coat * (covered - rough)
    widths = _widths(rough, p["specular_roughness_anisotropy"])
    reflection, passed = _dielectric(pairs, _index(p), widths, recipe)
    cosines = pairs.i, pairs.o, np.maximum(pairs.between, 0)
    diffuse = p["base_weight"] * formulas.eon(
        *cosines, p["base_color"], p["base_diffuse_roughness"]
    )
    dielectric = p["specular_color"] * reflection + passed(pairs.i) * diffuse
    f82 = fresnel.f82(pairs.facet, p["base_weight"] * p["base_color"], p["specular_color"])
    shine = p["specular_weight"] * f82 * _lobe(pairs, widths)
    shine = shine * _compensation(pairs.i, widths, f82)
    return dielectric + p["base_metalness"] * (shine - dielectric)


def _index(p: dict[str, Any]) -> float:
    """The index of the base's interface: below one its inverse, which is not reflected totally."""
    ratio = p["specular_ior"] / p["coat_ior"]
    mixed = p["specular_ior"] + p["coat_weight"] * (max(ratio, 1 / ratio) - p["specular_ior"])
    return formulas.modulated_index(mixed, p["specular_weight"])


def _widths(rough: float, anisotropy: float) -> tuple[float, float]:
    """The GGX widths, above zero and at most one."""
    u, v = formulas.widths(rough, anisotropy)
    return float(np.clip(u, 1e-6, 1)), float(np.clip(v, 1e-6, 1))


def _dielectric(
    pairs: _Pairs, eta: float, widths: tuple[float, float], recipe: Recipe
) -> tuple[np.ndarray, Any]:
    """The reflection of an interface, and its transmittance as a function of the cosine."""
    reflectance = fresnel.dielectric(pairs.facet, eta, NUMPY)[0]
    lobe = reflectance * _lobe(pairs, widths) * _compensation(pairs.i, widths, reflectance)

    def passed(cosine: np.ndarray) -> np.ndarray:
        if recipe == "materialx":
            low, high = _albedo_terms(cosine, widths)
            single = ((eta - 1) / (eta + 1)) ** 2 * low + high
        else:
            single = _interface_albedo(cosine, eta, widths)
        # The compensation is by the Fresnel term of the pair, as in MaterialX.
        return 1 - single * _compensation(cosine, widths, reflectance)

    return lobe, passed


def _interface_albedo(cosine: np.ndarray, eta: float, widths: tuple[float, float]) -> np.ndarray:
    """The albedo of an interface by single scattering, linear between the nodes of the table."""
    table = albedos.tables(float(eta)).reflected[0]
    alpha = max(np.sqrt(widths[0] * widths[1]), MIN_ALPHA)
    row = albedos.roughness_coordinate(alpha) * (len(table) - 1)
    low = min(int(row), len(table) - 2)
    line = table[low] + (row - low) * (table[low + 1] - table[low])
    at = albedos.cosine_coordinate(cosine, float(eta))
    return np.interp(at, np.linspace(0, 1, len(line)), line)


def _darkening(p: dict[str, Any], recipe: Recipe) -> np.ndarray:
    """The factor of the base for reflections inside the coat."""
    color, share, eta = p["base_color"], p["base_metalness"], p["coat_ior"]
    if recipe == "materialx":
        f0 = ((eta - 1) / (eta + 1)) ** 2
        internal = 1 - (1 - f0) / eta**2
        albedo = color + share * (p["specular_weight"] * color - color)
    else:
        color = p["base_weight"] * color
        f0 = ((_index(p) - 1) / (_index(p) + 1)) ** 2
        metallic = min(p["specular_weight"], 1.0) * color
        albedo = f0 + (1 - f0) * color
        albedo = albedo + share * (metallic - albedo)
        internal = formulas.internal(eta, p["specular_roughness"], share, f0)
    full = (1 - internal) / (1 - albedo * internal)
    return 1 + p["coat_weight"] * p["coat_darkening"] * (full - 1)


def _absorption(p: dict[str, Any], pairs: _Pairs, recipe: Recipe) -> np.ndarray:
    """The factor of the base for absorption in the coat's medium."""
    exponent: Any = 1.0
    if recipe != "materialx":
        inside = [np.sqrt(1 - (1 - c * c) / p["coat_ior"] ** 2) for c in (pairs.i, pairs.o)]
        exponent = 0.5 / inside[0] + 0.5 / inside[1]
    return 1 + p["coat_weight"] * (p["coat_color"] ** exponent - 1)


def _lobe(pairs: _Pairs, widths: tuple[float, float]) -> np.ndarray:
    """D G / (4 cos cos) of GGX; masking is correlated by height and of the mean width."""
    u, v = widths
    x, y, z = pairs.half.T[..., None]
    density = 1 / (np.pi * u * v * ((x / u) ** 2 + (y / v) ** 2 + z * z) ** 2)
    a2 = u * v
    i, o = (np.sqrt(a2 + (1 - a2) * c * c) for c in (pairs.i, pairs.o))
    return density * 0.5 / (o * pairs.i + i * pairs.o)


def _albedo_terms(cosine: np.ndarray, widths: tuple[float, float]) -> tuple[Any, Any]:
    """The factors of F0 and F90 in the albedo of GGX facets of Schlick's reflectance."""
    x, y = cosine, np.sqrt(widths[0] * widths[1]) * np.ones_like(cosine)
    powers = np.stack([x**0, x, y, x * y, x * x, y * y, x * x * y, x * y * y, (x * y) ** 2], -1)
    r = powers @ _FIT
    low, high = (np.clip(r[..., k] / r[..., k + 2], 0, 1) for k in (0, 1))
    return low, high


def _compensation(cosine: np.ndarray, widths: tuple[float, float], reflectance: Any) -> Any:
    """The factor for light that is scattered more than once (Turquin 2019)."""
    single = sum(_albedo_terms(cosine, widths))
    return 1 + reflectance * (1 - single) / single
