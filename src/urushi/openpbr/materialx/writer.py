"""Descriptions of one coat as MaterialX documents of OpenPBR, and back.

The base is a conductor with Schlick's Fresnel term, to which F82 with a white tint is equal (Kutz
et al. 2021), or a Lambertian surface with a specular weight of 0. A coat's colour is the square of
its transmittance at normal incidence (OpenPBR Surface 1.1.1, "Coat").
"""

import os
from collections.abc import Mapping

import numpy as np

from urushi.checks import Widths
from urushi.errors import ParameterError
from urushi.files import atomic_write
from urushi.openpbr.materialx.surface import TARGET
from urushi.openpbr.materialx.xml import Element, write
from urushi.walk import Conductor, Diffuse, Stack
from urushi.walk.bottoms import Value


def save_materialx(stack: Stack, path: str | os.PathLike, name: str = "material") -> None:
    """Write one clear or tinted coat over a metal or a diffuse base as a document of OpenPBR.

    Args:
        stack: one coat with an albedo of 0 or no medium, over a `conductor` of r0 or a `diffuse`.
            GGX widths are equal in all channels, and not larger across the tangent than along it.
        path: the document (.mtlx).
        name: of the material; letters, digits and underscores.

    Raises:
        ParameterError: the stack or the name is another one.
        FileError: the file cannot be written.
    """
    write_parameters(parameters(stack), path, name)


def write_parameters(
    values: Mapping[str, float | bool | tuple[float, float, float]],
    path: str | os.PathLike,
    name: str = "material",
) -> None:
    """Write constant parameters of OpenPBR as a document.

    Args:
        values: by name; colours in linear sRGB.
        path: the document (.mtlx).
        name: of the material; letters, digits and underscores.

    Raises:
        ParameterError: the name is another one.
        FileError: the file cannot be written.
    """
    if not (name.isascii() and name.isidentifier()):
        raise ParameterError(
            f"the material's name is {name!r}; use letters, digits and underscores"
        )
    root = Element("materialx", {"version": "1.39", "colorspace": "lin_rec709"})
    shader = Element(TARGET, {"name": f"{name}_shader", "type": "surfaceshader"})
    for parameter, value in values.items():
        kind, text = _typed(value)
        shader.add(Element("input", {"name": parameter, "type": kind, "value": text}))
    material = Element("surfacematerial", {"name": name, "type": "material"})
    link = {"name": "surfaceshader", "type": "surfaceshader", "nodename": f"{name}_shader"}
    material.add(Element("input", link))
    root.add(shader)
    root.add(material)
    with atomic_write(path) as temporary:
        temporary.write_text('<?xml version="1.0"?>\n' + write(root), encoding="utf-8")


def _typed(value: float | bool | tuple[float, float, float]) -> tuple[str, str]:
    """MaterialX's type and text of a value."""
    if isinstance(value, bool):
        return "boolean", str(value).lower()
    if isinstance(value, tuple):
        return "color3", ", ".join(repr(x) for x in value)
    return "float", repr(value)


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
    """Roughness r and anisotropy a of OpenPBR: alpha_t = r^2 sqrt(2 / (1 + (1 - a)^2)).

    alpha_b = (1 - a) alpha_t, so that (alpha_t^2 + alpha_b^2) / 2 = r^4.
    """
    u, v = (alpha.u, alpha.v) if isinstance(alpha, Widths) else (alpha, alpha)
    if isinstance(u, tuple) or isinstance(v, tuple):
        raise ParameterError(f"{where} has a width for each channel; OpenPBR has one for all")
    if v > u:
        raise ParameterError(f"{where} is larger across the tangent; OpenPBR's is larger along it")
    return float(((u**2 + v**2) / 2) ** 0.25), float(1 - v / u)
