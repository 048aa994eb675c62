"""Surface shaders of MaterialX as parameters of OpenPBR.

`open_pbr_surface` is read directly; another shader by the node graph that translates it, of the
library or of the document.
"""

import os
import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from urushi.errors import FileError, UrushiWarning
from urushi.materialx.baking import Texture, Value, bake
from urushi.materialx.document import find_surface, read_document
from urushi.materialx.graph import Graph
from urushi.materialx.images import Decode, Images
from urushi.materialx.xml import Element
from urushi.openpbr_surface.parameters import PARAMETERS, Parameter, checked, parameter

#: The shader whose inputs are the parameters.
TARGET = "open_pbr_surface"

#: Rows and columns of a texture that is computed on a grid, unless another number is asked for.
RESOLUTION = 1024

#: Largest amount by which a colour may leave [0, 1] without a warning.
GAMUT_TOLERANCE = 0.01

#: Inputs of other shaders that are directions, and the parameters that they become.
_DIRECTIONS = {
    "normal": "geometry_normal",
    "coat_normal": "geometry_coat_normal",
    "clearcoat_normal": "geometry_coat_normal",
    "tangent": "geometry_tangent",
    "coat_tangent": "geometry_coat_tangent",
}

#: The geometry's own directions in the tangent frame.
_OWN = {"normal": (0.0, 0.0, 1.0), "tangent": (1.0, 0.0, 0.0)}

#: A number, a truth value, a colour in linear sRGB, or a texture.
ParameterValue = float | bool | tuple[float, float, float] | Texture


@dataclass(frozen=True)
class Surface:
    """A material of a document.

    Attributes:
        name: the material's.
        values: its parameters that the document gives, by OpenPBR's names. Normals are textures of
            0.5 n + 0.5 in the tangent frame.
    """

    name: str
    values: Mapping[str, ParameterValue]


def read_surface(
    path: str | os.PathLike, decode: Decode, name: str | None = None, resolution: int = RESOLUTION
) -> Surface:
    """Read a material of a document.

    Args:
        path: the document.
        decode: reads an image.
        name: of the material; None: the only one.
        resolution: rows and columns of textures that have to be computed on a grid.

    Raises:
        FileError: the document or an image cannot be read, or has something unsupported.
        ParameterError: there is no such material, or a parameter is out of its range.
        PlatformError: the package materialx is needed and missing.
    """
    document = read_document(path)
    name, shader = find_surface(document, name)
    where = f"{document.where}: '{name[:60]}'"
    graph = Graph(document.root, Images(document.path.parent, decode), document.where)
    try:
        values = _Reader(graph, shader, resolution, where).values()
    except RecursionError:
        raise FileError(f"{where} has nodes nested too deeply; simplify it") from None
    return Surface(name, values)


class _Reader:
    """Reads the parameters of one shader."""

    def __init__(self, graph: Graph, shader: Element, resolution: int, where: str):
        self._graph, self._shader = graph, shader
        self._resolution, self._where = resolution, where

    def values(self) -> dict[str, ParameterValue]:
        read = self._direct() if self._shader.tag == TARGET else self._translated()
        found: dict[str, ParameterValue] = {}
        for name, value in read.items():
            entry = parameter(name, self._where)
            baked = bake(self._graph, value, self._resolution, f"{self._where}: {name}")
            if entry.kind != "vector":
                found[name] = self._final(entry, baked)
            elif (normals := self._direction(entry, baked)) is not None:
                found[name] = normals
        return _bright(found)

    def _direct(self) -> dict[str, Value]:
        """The values of the inputs that the shader has."""
        for element in self._shader.inputs():
            parameter(element.name, self._where)
        return {e.name: self._input(self._shader, e.name) for e in self._shader.inputs()}

    def _input(self, node: Element, name: str) -> Value:
        return lambda evaluation: evaluation.input(node, name, self._graph.root)

    def _output(self, node: Element, name: str) -> Value:
        return lambda evaluation: evaluation.output(node, self._graph.root, name)

    def _translated(self) -> dict[str, Value]:
        """The values of the outputs of the graph that translates the shader."""
        tag = self._shader.tag
        node = Element(f"{tag}_to_{TARGET}", {"name": self._shader.name, "type": "multioutput"})
        node.parent = self._shader.parent
        definition = self._graph.definitions.find(node)
        if definition is None:
            raise FileError(
                f"{self._where} is a {tag[:40]}, which MaterialX does not translate to {TARGET}; "
                f"only {TARGET} and standard_surface are read"
            )
        node.children = self._shader.children
        known = self._graph.definitions.inputs(definition)
        found: dict[str, Value] = {}
        left_out = []
        for element in node.inputs():
            if element.name in _DIRECTIONS:
                found[_DIRECTIONS[element.name]] = self._input(node, element.name)
            elif element.name not in known:
                left_out.append(element.name[:60])
        if left_out:
            warnings.warn(
                f"{self._where}: MaterialX's translation of {tag[:40]} ignores "
                f"{', '.join(left_out)}",
                UrushiWarning,
                stacklevel=2,
            )
        for output in definition.children:
            name = output.name.removesuffix("_out")
            if output.tag == "output" and name in PARAMETERS:
                found[name] = self._output(node, output.name)
        return found

    def _direction(self, entry: Parameter, value: np.ndarray | Texture) -> Texture | None:
        """A normal map of directions; None if they are the geometry's own."""
        own = np.array(_OWN[entry.name.rsplit("_", 1)[-1]])
        if isinstance(value, np.ndarray):
            if value.shape == (3,) and np.allclose(value, own, atol=1e-6):
                return None
            raise FileError(
                f"{self._where}: {entry.name} is a constant direction in space, which is not "
                "supported; leave it out, or give a normal map"
            )
        if own[2] == 0 or value.pixels.shape[-1] != 3:
            raise FileError(
                f"{self._where}: {entry.name} varies over the surface, which is only supported for "
                "normals"
            )
        return value.map(lambda n: 0.5 * n + 0.5)

    def _final(self, entry: Parameter, value: np.ndarray | Texture) -> ParameterValue:
        """A value after checks; colours are limited to the parameter's range."""
        where = self._where
        if isinstance(value, Texture):
            if not entry.can_be_textured:
                raise FileError(f"{where}: {entry.name} must not vary over the surface")
            pixels = value.pixels
            if pixels.shape[-1] != (3 if entry.kind == "color" else 1):
                raise FileError(f"{where}: {entry.name} has {pixels.shape[-1]} channels")
            return value.map(lambda x: self._limited(entry, x).astype(np.float32))
        if entry.kind == "color":
            if value.shape != (3,):
                raise FileError(
                    f"{where}: {entry.name} has {value.shape[-1]} channels instead of 3"
                )
            if entry.name != "emission_color":
                value = self._limited(entry, value)
            r, g, b = (float(x) for x in np.broadcast_to(np.maximum(value, 0.0), 3))
            return r, g, b
        if value.shape != (1,):
            raise FileError(f"{where}: {entry.name} has {value.shape[-1]} channels instead of 1")
        number = float(value[0])
        return checked(entry.name, number, where)

    def _limited(self, entry: Parameter, value: np.ndarray) -> np.ndarray:
        """Values limited to the range of a parameter, with a warning if that changes them much."""
        low = -np.inf if entry.low is None else entry.low
        high = np.inf if entry.high is None else entry.high
        limited = np.clip(value, low, high)
        if np.abs(limited - value).max(initial=0) > GAMUT_TOLERANCE:
            warnings.warn(
                f"{self._where}: {entry.name} leaves [{low:g}, {high:g}] in linear sRGB and is "
                "clipped to it",
                UrushiWarning,
                stacklevel=2,
            )
        return limited


def _bright(values: dict[str, ParameterValue]) -> dict[str, ParameterValue]:
    """The values, with an emission_color of at most 1: the luminance takes the rest."""
    color = values.get("emission_color")
    luminance = values.get("emission_luminance", 0.0)
    if isinstance(color, tuple) and max(color) > 1 and isinstance(luminance, float):
        peak = max(color)
        r, g, b = (x / peak for x in color)
        values["emission_color"] = (r, g, b)
        values["emission_luminance"] = luminance * peak
    return values
