"""Surface shaders of MaterialX's library as formulas for the parameters of OpenPBR.

The right side of each formula reads inputs of the shader by name. Formulas follow the node graphs
that define the shaders in MaterialX's `libraries/bxdf`, and OpenPBR Surface 1.1.1.
`docs/materialx.md` lists where they differ from MaterialX's own translations.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np

from urushi.errors import FileError
from urushi.openpbr_surface.materialx.conversions import (
    edge_tint,
    f0_of,
    ior_of,
    mix,
    peak,
    roughness_of,
    stretched,
    unit,
)
from urushi.openpbr_surface.materialx.nodes import CHANNELS

#: The shader whose inputs are the parameters.
TARGET = "open_pbr_surface"


@dataclass(frozen=True)
class Inputs:
    """Inputs of a shader by name, or their defaults."""

    evaluation: Any  # at some points, an `evaluation.Evaluation`
    shader: Any  # its `graph.Node`
    # The least and the largest value (channels,) of an input on the surface. What the plugin needs
    # to be the same everywhere depends on them: thin walls, the index of what transmits light, the
    # medium inside.
    ends: Callable[[str], tuple[np.ndarray, np.ndarray]]

    def __getattr__(self, name: str) -> np.ndarray:
        """The value (..., channels) at the points; one channel stands for all."""
        value, declared = self.evaluation.input(self.shader, name), self.shader.inputs.get(name)
        channels = CHANNELS[declared.getAttribute("type")] if declared else value.shape[-1]
        if value.shape[-1] not in (1, channels):
            raise FileError(
                f"{self.shader.where}: {name} has {value.shape[-1]} channels instead of {channels}"
            )
        return value


Formula = Callable[[Inputs], np.ndarray]
Formulas = Mapping[str, Formula]

#: Formulas for parameters, by shader; a parameter that is missing has OpenPBR's default.
TRANSLATIONS: dict[str, Formulas] = {}

#: Reflectance at the normal of an index of 3, the largest of OpenPBR's dielectric here.
MOST_F0 = 0.25

#: Weights of MaterialX's node `luminance`, which the opacity of standard_surface goes through.
_LUMA = np.array([0.2722287, 0.6740818, 0.0536895])


def _anywhere(i: Inputs, name: str) -> bool:
    """Whether an input is above 0 somewhere."""
    return bool((i.ends(name)[1] > 0).any())


def _constant(value: float) -> Formula:
    return lambda _: np.full(1, value)


_zero = _constant(0.0)


def renamed(pairs: str) -> dict[str, Formula]:
    """Formulas: "PARAMETER=INPUT", one name of both, or "PARAMETER=NUMBER"."""
    parts = (pair.partition("=") for pair in pairs.split())
    return {
        name: _constant(float(x)) if x[:1].isdigit() else attrgetter(x or name)
        for name, _, x in parts
    }


def _has_one_index(i: Inputs, clear: str, *strengths: str) -> bool:
    """Whether the strength of reflections must not change the index, but be in their colour.

    In the shaders' graphs it does not change the direction of refraction, as OpenPBR's
    specular_weight does; and what lets light inside needs one index.

    clear: the weight of transmission. strengths: inputs that the index would vary with.
    """
    varies = any((low != high).any() for low, high in map(i.ends, strengths))
    return _anywhere(i, clear) or (varies and _anywhere(i, "subsurface"))


def _gloss(i: Inputs, metalness: str) -> tuple[np.ndarray, np.ndarray]:
    """OpenPBR's specular_weight and specular_color of a dielectric."""
    if _has_one_index(i, "transmission", "specular", metalness):
        return np.ones(1), i.specular * i.specular_color
    largest = np.maximum(peak(i.specular_color), 1)
    return i.specular * largest, i.specular_color / largest


def _under_coat(i: Inputs, color: np.ndarray, share: np.ndarray | float = 1.0) -> np.ndarray:
    """A colour of standard_surface, raised to the power of coat_affect_color."""
    gamma = 1 + np.clip(i.coat, 0, 1) * i.coat_affect_color * share
    return np.maximum(color, 0) ** gamma


TRANSLATIONS["standard_surface"] = renamed(
    "base_weight=base base_diffuse_roughness=diffuse_roughness base_metalness=metalness "
    "specular_ior=specular_IOR transmission_weight=transmission transmission_color "
    "transmission_depth transmission_scatter transmission_scatter_anisotropy "
    "subsurface_weight=subsurface fuzz_color=sheen_color coat_weight=coat "
    "coat_color coat_ior=coat_IOR thin_film_ior=thin_film_IOR emission_luminance=emission "
    "emission_color geometry_thin_walled=thin_walled geometry_normal=normal "
    "geometry_tangent=tangent geometry_coat_normal=coat_normal coat_darkening=0"
) | {
    "base_color": lambda i: _under_coat(i, i.base_color, 1 - i.metalness),
    "specular_weight": lambda i: mix(_gloss(i, "metalness")[0], 1, i.metalness),
    "specular_color": lambda i: mix(
        _gloss(i, "metalness")[1],
        edge_tint(i.base * i.base_color, i.specular * i.specular_color),
        i.metalness,
    ),
    "specular_roughness": lambda i: stretched(i.specular_roughness, i.specular_anisotropy),
    "specular_roughness_anisotropy": lambda i: np.clip(i.specular_anisotropy, 0, 0.98),
    "transmission_dispersion_scale": lambda i: np.where(i.transmission_dispersion > 0, 1, 0),
    "transmission_dispersion_abbe_number": lambda i: np.where(
        i.transmission_dispersion > 0, i.transmission_dispersion, 20
    ),
    "subsurface_color": lambda i: _under_coat(i, i.subsurface_color),
    "subsurface_radius": lambda i: i.subsurface_scale * peak(i.subsurface_radius),
    "subsurface_radius_scale": lambda i: unit(i.subsurface_radius),
    # A thin wall transmits all of it.
    "subsurface_scatter_anisotropy": lambda i: np.where(i.thin_walled, 1, i.subsurface_anisotropy),
    "fuzz_weight": lambda i: i.sheen * (1 - i.metalness) * (1 - i.transmission),
    "fuzz_roughness": lambda i: i.sheen_roughness**0.4,  # as MaterialX translates it
    "coat_roughness": lambda i: stretched(i.coat_roughness, i.coat_anisotropy),
    "coat_roughness_anisotropy": lambda i: np.clip(i.coat_anisotropy, 0, 0.98),
    "thin_film_weight": lambda i: np.where(i.thin_film_thickness > 0, 1, 0),
    "thin_film_thickness": lambda i: 1e-3 * i.thin_film_thickness,
    "geometry_opacity": lambda i: (i.opacity * _LUMA).sum(-1, keepdims=True),
}


def _gltf_widths(i: Inputs) -> tuple[np.ndarray, np.ndarray]:
    """GGX widths of KHR_materials_anisotropy."""
    width = np.clip(i.roughness**2, 1e-5, 1)
    return mix(width, 1, i.anisotropy_strength**2), width


def _gltf_medium(i: Inputs) -> bool:
    """Whether a volume absorbs light inside (KHR_materials_volume)."""
    absorbs = (i.attenuation_color < 1).any() and _anywhere(i, "transmission")
    return bool(absorbs) and _anywhere(i, "thickness") and _anywhere(i, "attenuation_distance")


def _gltf_tinted(i: Inputs) -> bool:
    """Whether base_color tints light that crosses the surface."""
    return bool((i.ends("base_color")[0] < 0.98).any())


def _gltf_deep(i: Inputs) -> bool:
    """Whether transmission_color is the medium's: OpenPBR has no tint of the surface beside it."""
    return _gltf_medium(i) and not _gltf_tinted(i)


TRANSLATIONS["gltf_pbr"] = renamed(
    "base_color base_metalness=metallic specular_ior=ior transmission_weight=transmission "
    "coat_weight=clearcoat coat_ior=1.5 coat_darkening=0 "
    "coat_roughness=clearcoat_roughness thin_film_weight=iridescence "
    "thin_film_ior=iridescence_ior emission_luminance=emissive_strength emission_color=emissive "
    "geometry_normal=normal geometry_tangent=tangent geometry_coat_normal=clearcoat_normal"
) | {
    "specular_weight": lambda i: mix(_gloss(i, "metallic")[0], 1, i.metallic),
    "specular_color": lambda i: mix(_gloss(i, "metallic")[1], 1, i.metallic),
    "specular_roughness": lambda i: roughness_of(*_gltf_widths(i)),
    "specular_roughness_anisotropy": lambda i: 1 - np.divide(*_gltf_widths(i)[::-1]),
    "transmission_color": lambda i: i.attenuation_color if _gltf_deep(i) else i.base_color,
    "transmission_depth": lambda i: i.attenuation_distance * _gltf_deep(i),
    # A volume of thickness 0 is a thin wall (KHR_materials_volume).
    "geometry_thin_walled": lambda i: np.full(
        1, _anywhere(i, "transmission") and not _anywhere(i, "thickness")
    ),
    "transmission_dispersion_scale": lambda i: np.where(i.dispersion > 0, 1, 0),
    "transmission_dispersion_abbe_number": lambda i: (
        20 / np.where(i.dispersion > 0, i.dispersion, 1)
    ),
    "fuzz_weight": lambda i: peak(i.sheen_color),
    "fuzz_color": lambda i: unit(i.sheen_color),
    "fuzz_roughness": lambda i: i.sheen_roughness**0.8,  # its square in standard_surface
    "thin_film_thickness": lambda i: 1e-3 * i.iridescence_thickness,
    "geometry_opacity": lambda i: np.where(
        i.alpha_mode == 0, 1, np.where(i.alpha_mode == 1, i.alpha >= i.alpha_cutoff, i.alpha)
    ),
}


def _usd_transparent(i: Inputs) -> np.ndarray:
    """Whether opacity is one of transmission, not of presence."""
    return (i.opacityMode == 0) & (i.opacityThreshold <= 0)


def _usd_clear(i: Inputs) -> bool:
    """Whether something transmits light, which is refracted by the input ior."""
    return bool(_usd_transparent(i).all() and (i.ends("opacity")[0] < 1).any())


def _usd_gloss(i: Inputs) -> tuple[np.ndarray, np.ndarray]:
    """Index and specular_color of the dielectric."""
    with_color = i.useSpecularWorkflow == 1
    if _usd_clear(i):
        return i.ior, np.where(with_color, i.specularColor / f0_of(i.ior), 1)
    index = np.where(with_color, ior_of(np.minimum(peak(i.specularColor), MOST_F0)), i.ior)
    return index, np.where(with_color, unit(i.specularColor), 1)


def _usd_base(i: Inputs) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Metalness, and the base's and the metal's edge color.

    A specularColor above `MOST_F0` is a metal's. Metal m and dielectric 1 - m of one base_color b
    have its albedo s, m b + (1 - m) MOST_F0 = s, and the diffuse one, (1 - m) (1 - MOST_F0) b =
    (1 - s) diffuseColor: a quadratic equation of m.
    """
    diffuse, color, s = i.diffuseColor, i.specularColor, peak(i.specularColor)
    more = s - MOST_F0
    if _usd_clear(i):
        more = 0 * more
    kept = (1 - s) / (1 - MOST_F0) * diffuse
    linear = peak(kept) + more - MOST_F0
    m = (np.sqrt(linear**2 + 4 * MOST_F0 * np.maximum(more, 0)) - linear) / (2 * MOST_F0)
    m = np.where(more > 0, np.clip(m, 0, 1), 0)
    below = np.where(m < 1, kept / np.maximum(1 - m, 1e-6), 0)
    metal = (color - (1 - m) * MOST_F0 * unit(color)) / np.maximum(m, 1e-6)
    mixed = np.clip(np.where(m > 0, mix(below, metal, m * m), diffuse), 0, 1)
    by_metal = i.useSpecularWorkflow == 0
    return (
        np.where(by_metal, i.metallic, m),
        np.where(by_metal, diffuse, mixed),
        np.where(by_metal, edge_tint(diffuse, diffuse), 1),
    )


TRANSLATIONS["UsdPreviewSurface"] = renamed(
    "specular_roughness=roughness coat_weight=clearcoat "
    "coat_roughness=clearcoatRoughness coat_ior=ior emission_color=emissiveColor "
    "geometry_normal=normal coat_darkening=0 emission_luminance=1"
) | {
    "base_metalness": lambda i: _usd_base(i)[0],
    "base_color": lambda i: _usd_base(i)[1],
    "specular_color": lambda i: mix(_usd_gloss(i)[1], _usd_base(i)[2], _usd_base(i)[0]),
    "specular_ior": lambda i: _usd_gloss(i)[0],
    "transmission_weight": lambda i: _usd_transparent(i) * (1 - i.opacity),
    "geometry_opacity": lambda i: np.where(
        i.opacityThreshold > 0,
        i.opacity >= i.opacityThreshold,
        np.where(i.opacityMode == 1, i.opacity, 1),
    ),
}


def _disney_gloss(i: Inputs) -> tuple[np.ndarray, np.ndarray]:
    """Index and specular_color of the dielectric; light is refracted by the input ior."""
    f0, tint = 0.08 * i.specular, i.specularTint * (1 - i.metallic)
    if _has_one_index(i, "specTrans", "specular"):
        return i.ior, mix(1, i.baseColor, tint) * f0 / f0_of(i.ior)
    return ior_of(f0), mix(1, i.baseColor, tint)


TRANSLATIONS["disney_principled"] = renamed(
    "base_color=baseColor base_metalness=metallic transmission_weight=specTrans "
    "transmission_color=baseColor subsurface_weight=subsurface subsurface_color=baseColor "
    "coat_weight=clearcoat coat_ior=1.5 coat_darkening=0"
) | {
    "specular_color": lambda i: _disney_gloss(i)[1],
    "specular_roughness": lambda i: stretched(i.roughness, i.anisotropic),
    "specular_roughness_anisotropy": lambda i: np.clip(i.anisotropic, 0, 0.98),
    "specular_ior": lambda i: _disney_gloss(i)[0],
    "subsurface_radius": lambda i: peak(i.subsurfaceDistance),
    "subsurface_radius_scale": lambda i: unit(i.subsurfaceDistance),
    "fuzz_weight": lambda i: i.sheen * (1 - i.metallic) * (1 - i.specTrans),
    "fuzz_color": lambda i: mix(1, i.baseColor, i.sheenTint),
    "fuzz_roughness": _constant(0.3**0.4),
    "coat_roughness": lambda i: 1 - i.clearcoatGloss,
}

TRANSLATIONS["surface_unlit"] = renamed(
    "emission_luminance=emission emission_color base_weight=0 specular_weight=0"
) | {"geometry_opacity": lambda i: i.opacity * (1 - i.transmission)}

#: The roughness of transmitted light, of shaders in which it is not that of reflected light.
TRANSMITTED_ROUGHNESS: dict[str, Formula] = {
    "standard_surface": lambda i: stretched(
        np.clip(i.specular_roughness + i.transmission_extra_roughness, 0, 1), i.specular_anisotropy
    ),
    "UsdPreviewSurface": _zero,
    "disney_principled": _zero,
}


def separated(formulas: Formulas, roughness: Formula) -> tuple[Formula, Formulas, Formulas]:
    """A material as a mixture of what is opaque and of what transmits light.

    roughness: of the light that is transmitted; the reflections of this share get it, too.

    Returns:
        The weight of what transmits, and the formulas of both.
    """
    metalness, clear = formulas["base_metalness"], formulas["transmission_weight"]
    thin = formulas.get("geometry_thin_walled", _zero)

    def weight(i: Inputs) -> np.ndarray:
        return (1 - metalness(i)) * clear(i)

    opaque = {
        "base_metalness": lambda i: metalness(i) / np.maximum(1 - weight(i), 1e-6),
        "transmission_weight": _zero,
        # A thin wall is seen from inside, too.
        "geometry_thin_walled": lambda i: thin(i) + (not _anywhere(i, "subsurface")) > 0,
    }
    through = renamed("base_metalness=0 transmission_weight=1") | {"specular_roughness": roughness}
    return weight, {**formulas, **opaque}, {**formulas, **through}


#: Shaders that are read.
SHADERS = (TARGET, *TRANSLATIONS)

#: Inputs without a counterpart in OpenPBR, by shader: the loss, 0 where nothing is lost.
LOST: dict[str, Formulas] = {
    "standard_surface": {
        "specular_rotation": lambda i: 2 * i.specular_rotation % 1 * i.specular_anisotropy,
        "coat_rotation": lambda i: 2 * i.coat_rotation % 1 * i.coat_anisotropy * i.coat,
    },
    "gltf_pbr": {
        "attenuation_color": lambda i: np.full(1, _gltf_medium(i) and _gltf_tinted(i)),
        "anisotropy_rotation": lambda i: (
            np.round(np.sin(i.anisotropy_rotation), 6) * i.anisotropy_strength
        ),
    },
    "UsdPreviewSurface": {"displacement": lambda i: i.displacement},
}

#: Number of units in a metre of inputs that are thicknesses of films.
FILM_UNITS = {
    (TARGET, "thin_film_thickness"): 1e6,
    ("standard_surface", "thin_film_thickness"): 1e9,
    ("gltf_pbr", "iridescence_thickness"): 1e9,
}
