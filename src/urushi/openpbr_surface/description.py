"""Materials of OpenPBR in Python: `urushi.openpbr`, and a `Stack` as a material of OpenPBR.

A stack's base is a conductor with Schlick's Fresnel term, to which F82 with a white tint is equal
(Kutz et al. 2021), or a Lambertian surface with a specular weight of 0. A coat's colour is the
square of its transmittance at normal incidence (OpenPBR Surface 1.1.1, 3.4).
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import Widths
from urushi.errors import ParameterError, PlatformError
from urushi.material.source import Source, as_source
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.bottoms import bsdf_source
from urushi.openpbr_surface.formulas import base_index, subsurface_albedo, translucent_medium
from urushi.openpbr_surface.materialx.conversions import roughness_of
from urushi.openpbr_surface.materialx.document import write_parameters
from urushi.openpbr_surface.parameters import EMISSION, checked, complete, parameter
from urushi.openpbr_surface.plugins.emission import NAMES as EMISSION_INPUTS
from urushi.walk import Conductor, Diffuse, Stack
from urushi.walk.bottoms import Value

#: Parts of the base whose parameters describe the medium inside of a body.
MEDIA = ("transmission", "subsurface")

#: Least subsurface_radius, a mean free path.
LEAST_RADIUS = 1e-4

#: Largest absolute value of a medium's g; at 1, light is not scattered.
MOST_G = 0.99


@dataclass(frozen=True)
class OpenPBR:
    """A material of OpenPBR Surface 1.1.1, as `openpbr` makes it.

    Attributes:
        parameters: the given ones by name: floats, truth values, colours as tuples of three
            numbers, and textures as Mitsuba's dictionaries or objects.
        options: of the plugin `openpbr`, such as `reference`.
    """

    parameters: Mapping[str, Any]
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def textures(self) -> list[str]:
        """The names of the parameters that are textures."""
        given = self.parameters.items()
        return [name for name, x in given if not isinstance(x, float | bool | tuple)]

    @property
    def emits(self) -> bool:
        """Whether there is emitted light."""
        return self.parameters.get("emission_luminance", 0.0) != 0.0

    def description(self) -> dict[str, Any]:
        """The BSDF for `mi.load_dict`, of the plugin `openpbr`; it does not emit, nor has it a
        medium: the plugin refuses a material with one, unless "interior" is true."""
        values = {name: x for name, x in self._values().items() if name not in EMISSION}
        return {"type": "openpbr", **values, **self.options}

    def emitter(self) -> dict[str, Any] | None:
        """The emitted light for `mi.load_dict`, of the plugin `openpbr_emission`; None: none."""
        if not self.emits:
            return None
        values = {name: x for name, x in self._values().items() if name in EMISSION_INPUTS}
        return {"type": "openpbr_emission", **values}

    def on(self, shape: Mapping[str, Any]) -> dict[str, Any]:
        """A shape of this material, with its emitted light and the medium inside (`interior`).

        shape: a dictionary for `mi.load_dict`, such as {"type": "sphere"}, without BSDF and
            emitter.
        """
        emitter = self.emitter()
        light = {} if emitter is None else {"emitter": emitter}
        bsdf, medium = self.description(), self.interior()
        if medium is None:
            return {**shape, "bsdf": bsdf, **light}
        return {**shape, "bsdf": bsdf | {"interior": True}, **light, "interior": medium}

    def interior(self) -> dict[str, Any] | None:
        """The medium inside of a body, for integrators such as `volpath`; None: it is clear.

        Lengths are the scene's. If transmission_weight and subsurface_weight both have a share, the
        medium is the mean of both. A weight that is a texture counts as 1.

        Raises:
            ParameterError: a parameter of the medium is a texture.

        Source: OpenPBR Surface 1.1.1, 3.2.3 and 3.2.4.
        """
        weights = [self.parameters.get(f"{name}_weight", 0.0) for name in MEDIA]
        clear, share = (x if isinstance(x, float) else 1.0 for x in weights)
        if isinstance(weights[0], float):  # a texture may leave all of it
            share *= 1 - clear
        deep = clear and self.parameters.get("transmission_depth", 0.0) != 0.0
        if self.parameters.get("geometry_thin_walled") or not (deep or share):
            return None
        needed = [f"{name}_" for name, used in zip(MEDIA, (deep, share), strict=True) if used]
        textures = [x for x in self.textures if x.startswith(tuple(needed))]
        _check_constant([x for x in textures if not x.endswith("_weight")], "the medium of a body")
        given = self.parameters.items()
        values = complete({name: x for name, x in given if name not in self.textures})
        if mi.variant() is not None and mi.is_spectral:  # the formulas, wavelength by wavelength
            values |= {x: spectrum.at_nodes(y) for x, y in values.items() if np.ndim(y)}
        extinction = scattering = np.zeros_like(values["transmission_color"])
        forward = 0.0
        if deep:
            names = "color", "depth", "scatter"
            found = translucent_medium(*(values[f"transmission_{name}"] for name in names))
            extinction, scattering = (clear * x / (clear + share) for x in found)
            forward = values["transmission_scatter_anisotropy"] * scattering.mean()
        if share:
            radius = values["subsurface_radius"] * values["subsurface_radius_scale"]
            g = _limited_g(values["subsurface_scatter_anisotropy"])
            index = base_index(values["specular_ior"], 1.0, 0.0, values["specular_weight"])
            dense = share / (clear + share) / np.maximum(radius, LEAST_RADIUS)
            albedo = subsurface_albedo(values["subsurface_color"], g, index)
            extinction, scattering = extinction + dense, scattering + albedo * dense
            forward += g * (albedo * dense).mean()
        if not extinction.any():
            return None
        g = _limited_g(forward / max(scattering.mean(), 1e-12))
        return {
            "type": "homogeneous",
            "sigma_t": _color(extinction / extinction.max()),
            "scale": float(extinction.max()),
            "albedo": _color(scattering / np.maximum(extinction, 1e-12)),
            "phase": {"type": "hg", "g": g},
        }

    def _values(self) -> dict[str, Any]:
        """The parameters as `mi.load_dict` takes them."""
        return {
            name: {"type": "rgb", "value": list(value)} if isinstance(value, tuple) else value
            for name, value in self.parameters.items()
        }

    def bsdf(self) -> "mi.BSDF":
        """The BSDF in the current variant.

        Raises:
            PlatformError: no variant is set.
        """
        if mi.variant() is None:
            raise PlatformError(
                "openpbr: no Mitsuba variant is set; set one first, for instance by "
                "mi.set_variant('llvm_ad_rgb')"
            )
        return mi.load_dict(self.description())

    def f(self, wi: np.ndarray, wo: np.ndarray, walks: int = 1) -> np.ndarray:
        """The BRDF at the middle of uv.

        Args:
            wi, wo: (N, 3) unit vectors above the horizon, z the normal and x the tangent.
            walks: number of evaluations that are averaged; only `reference` has noise.

        Returns:
            (N, C) [1/sr], without cosine; C is the variant's number of channels.

        Raises:
            PlatformError: no variant is set.
        """
        wi, wo = (np.asarray(w, np.float32) for w in (wi, wo))
        return probing.mean_values(self.bsdf(), wi, wo, walks).astype(np.float32)

    def save(self, path: str | os.PathLike, name: str = "material") -> None:
        """Write the material as a MaterialX document, which `load_materialx` reads.

        Args:
            path: the document (.mtlx).
            name: of the material; letters, digits and underscores.

        Raises:
            ParameterError: a parameter is a texture, or the name has other characters.
            FileError: the file cannot be written.
        """
        _check_constant(self.textures, "a saved material")
        write_parameters(self.parameters, path, name)


def openpbr(
    *,
    reference: bool = False,
    energy_compensation: bool = True,
    unsupported: str = "error",
    **parameters: Any,
) -> OpenPBR:
    """Describe a material of OpenPBR Surface 1.1.1.

    Args:
        reference: whether the coat is computed by random walks instead of tables or codes.
        energy_compensation: whether the energy that rough interfaces lose is compensated.
        unsupported: "error", or "ignore" to leave out unsupported features, with a warning.
        parameters: of the specification, by name. Numbers and colours (three numbers, linear sRGB)
            in their ranges; or textures, as Mitsuba's dictionaries or objects. Those that are left
            out have the defaults of the specification.

    Returns:
        A description without Mitsuba objects. `f` evaluates it, `urushi.encode` encodes it, `save`
        writes it, and `description` returns its BSDF for a scene.

    Raises:
        ParameterError: a name does not exist, or a value is out of range or of a wrong kind.

    Source: Andersson et al., OpenPBR Surface 1.1.1, Academy Software Foundation.
    """
    options = {
        "reference": bool(reference),
        "energy_compensation": bool(energy_compensation),
        "unsupported": unsupported,
    }
    if parameters.get("type") == "openpbr":  # as `urushi.load_materialx` gives them
        parameters = {name: value for name, value in parameters.items() if name != "type"}
    return OpenPBR({name: _value(name, value) for name, value in parameters.items()}, options)


def _check_constant(textures: list[str], what: str) -> None:
    """Refuse parameters that are textures."""
    for name in textures:
        raise ParameterError(
            f"openpbr: {name} is a texture, but {what} is the same everywhere; give a number or a "
            "colour"
        )


def _limited_g(g: float) -> float:
    """A Henyey-Greenstein g that media take."""
    return float(np.clip(g, -MOST_G, MOST_G))


def _color(value: np.ndarray) -> dict[str, Any]:
    """A colour (3,), or a spectrum of `spectrum.at_nodes`, for `mi.load_dict`."""
    if len(value) > len(spectrum.RGB):
        return spectrum.from_nodes(value)
    return {"type": "rgb", "value": value.tolist()}


def _value(name: str, value: Any) -> Any:
    """A parameter as it is kept."""
    entry = parameter(name)
    if isinstance(value, Mapping) and value.get("type") == "rgb":
        value = value.get("value")
    of_mitsuba = type(value).__module__.startswith("mitsuba") and not dr.is_array_v(value)
    if isinstance(value, Mapping) or of_mitsuba:
        if entry.kind == "boolean":
            raise ParameterError(f"openpbr: {name} cannot be a texture; give true or false")
        return value
    constant = checked(name, value)
    return tuple(constant.tolist()) if isinstance(constant, np.ndarray) else constant


@as_source.register
def _(source: OpenPBR) -> Source:
    _check_constant(source.textures, "an encoded material")
    return bsdf_source(source.bsdf())


def save_materialx(stack: Stack, path: str | os.PathLike, name: str = "material") -> None:
    """Write one clear or tinted coat over a metal or a diffuse base as a document of OpenPBR.

    Args:
        stack: one coat with an albedo of 0 or no medium, over a `conductor` of r0 or a `diffuse`.
            GGX widths are equal in all channels, and not larger across the tangent than along it.
        path: the document (.mtlx).
        name: of the material; letters, digits and underscores.

    Raises:
        ParameterError: the stack is not of this kind, or the name has other characters.
        FileError: the file cannot be written.
    """
    write_parameters(parameters(stack), path, name)


def parameters(stack: Stack) -> dict[str, float | tuple[float, float, float]]:
    """The parameters of OpenPBR that describe a stack, see `save_materialx`.

    Raises:
        ParameterError: OpenPBR cannot describe it.
    """
    if not isinstance(stack, Stack) or len(stack.coats) != 1:
        raise ParameterError("OpenPBR has one coat; give a Stack of one coat over its base")
    coat, bottom = stack.coats[0], stack.bottom
    absorbs = np.asarray(coat.sigma_t) > 0
    if (absorbs & (np.asarray(coat.albedo) > 0)).any():
        raise ParameterError("OpenPBR's coat does not scatter; make its albedo 0")
    if np.ndim(coat.eta):
        raise ParameterError("OpenPBR's coat_ior is one number; give one eta for all channels")
    if isinstance(bottom, Conductor) and bottom.r0 is not None:
        width, anisotropy = _roughness(bottom.alpha, "the conductor's alpha")
        base: dict[str, float | tuple[float, float, float]] = {
            "base_color": _rgb(bottom.r0),
            "base_metalness": 1.0,
            "specular_roughness": width,
            "specular_roughness_anisotropy": anisotropy,
        }
    elif isinstance(bottom, Diffuse):
        base = {"base_color": _rgb(bottom.reflectance), "specular_weight": 0.0}
    else:
        raise ParameterError(
            "only a conductor of r0 or a diffuse surface can be written as OpenPBR's base; give "
            "one of them"
        )
    width, anisotropy = _roughness(coat.alpha, "the coat's alpha")
    return base | {
        "coat_weight": 1.0,
        "coat_color": _rgb(np.exp(-2 * np.asarray(coat.sigma_t))),
        "coat_roughness": width,
        "coat_roughness_anisotropy": anisotropy,
        "coat_ior": float(np.asarray(coat.eta)),
    }


def _rgb(value: object) -> tuple[float, float, float]:
    r, g, b = (float(x) for x in np.broadcast_to(np.asarray(value, np.float64), 3))
    return r, g, b


def _roughness(alpha: Value | Widths, where: str) -> tuple[float, float]:
    """Roughness and anisotropy of OpenPBR, see `formulas.widths`."""
    u, v = (alpha.u, alpha.v) if isinstance(alpha, Widths) else (alpha, alpha)
    if isinstance(u, tuple) or isinstance(v, tuple):
        raise ParameterError(f"{where} has a width for each channel; OpenPBR has one for all")
    if v > u:
        raise ParameterError(f"{where} is larger across the tangent; OpenPBR's is larger along it")
    return float(roughness_of(np.asarray(u), np.asarray(v))), float(1 - v / u)
