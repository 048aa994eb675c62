"""Materials of documents: the parameters of OpenPBR of a surface shader, and mixtures of shaders.

`open_pbr_surface` is read directly; others by the formulas of `shaders`, or by a node graph of the
document that translates them.
"""

import os
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from urushi.checks import Check
from urushi.errors import FileError, UrushiWarning
from urushi.openpbr_surface.materialx import shaders
from urushi.openpbr_surface.materialx.baking import MAX_RESOLUTION, Texture, Value, bake, changes
from urushi.openpbr_surface.materialx.document import find_material, read_document
from urushi.openpbr_surface.materialx.evaluation import DIRECTIONS, Evaluation
from urushi.openpbr_surface.materialx.graph import Frame, Graph, Node, cycle, has_value
from urushi.openpbr_surface.materialx.images import Images
from urushi.openpbr_surface.parameters import EMISSION, PARAMETERS, Parameter, checked, parameter

#: Rows and columns of a texture that is computed on a grid, unless another number is asked for.
RESOLUTION = 1024

#: The numbers that may be asked for.
RESOLUTIONS = Check("resolution", f"in [1, {MAX_RESOLUTION}]", 1, MAX_RESOLUTION)

#: Inputs of a material that are left out, and their names in warnings.
_LOST_SHADERS = {"displacementshader": "displacement", "backsurfaceshader": "back's shader"}

#: Largest number of shaders in a mixture.
MAX_MIXED = 16

#: Largest amount by which a value may leave its range without a warning or an error: by rounding in
#: a graph, or by the gamut of a colour.
TOLERANCE = 0.01

#: A number, a truth value, a colour in linear sRGB, or a texture.
ParameterValue = float | bool | tuple[float, float, float] | Texture


@dataclass(frozen=True)
class Surface:
    """A material of a document."""

    name: str
    where: str  # the document and the shader's node; begins errors
    # Its parameters that the document gives, by OpenPBR's names. Normals are textures of
    # 0.5 n + 0.5 in the tangent frame.
    values: Mapping[str, ParameterValue]


@dataclass(frozen=True)
class Mix:
    """Two materials that MaterialX's node `mix` mixes: (1 - weight) bg + weight fg.

    weight: a number in (0, 1), or a texture.
    """

    name: str
    weight: float | Texture
    bg: "Surface | Mix"
    fg: "Surface | Mix"


def mixed(
    name: str, weight: Texture, where: str, part: Callable[[str], Surface | Mix]
) -> Surface | Mix:
    """The mixture of the parts "bg" and "fg", or the only one of them that has a weight."""
    if (channels := weight.pixels.shape[-1]) != 1:
        raise FileError(f"{where} has {channels} channels instead of 1")
    weight = weight.map(lambda x: np.clip(x, 0, 1))
    share = weight if weight.constant is None else float(weight.constant[0])
    if share in (0.0, 1.0):
        return part("fg" if share else "bg")
    return Mix(name, share, part("bg"), part("fg"))


def warn(message: str) -> None:
    warnings.warn(message, UrushiWarning, stacklevel=3)


class Reader:
    """Reads the parameters of one shader."""

    def __init__(self, graph: Graph, shader: Node, resolution: int, where: str):
        self._graph, self._shader = graph, shader
        self._resolution, self._where = resolution, where
        self._ends: dict[str, tuple[np.ndarray, np.ndarray]] = {}  # by input

    def material(self, name: str) -> Surface | Mix:
        """The material of a name."""
        tag, given = self._shader.tag, self._given()
        if given is not None:
            return self._surface(name, given)
        self._warn_of_losses(tag)
        formulas, roughness = shaders.TRANSLATIONS[tag], shaders.TRANSMITTED_ROUGHNESS.get(tag)
        if roughness is None or not (
            self._pixels("transmission_weight", formulas).any()
            and self._changes(lambda i: roughness(i) - formulas["specular_roughness"](i))
        ):
            return self._surface(name, formulas)
        parts = [x for x in EMISSION if x in formulas]
        emits = parts and all(self._pixels(x, formulas).any() for x in parts)
        which = "reflected" if emits else "transmitted"
        warn(
            f"{self._where}: OpenPBR has one roughness of light that is reflected and transmitted; "
            f"where the surface transmits, both get that of {which} light"
        )
        if emits:  # a mixture would not
            return self._surface(name, formulas)
        weight, opaque, through = shaders.separated(formulas, roughness)
        return mixed(
            name,
            self._baked("transmission_weight", weight),
            self._where,
            lambda side: self._surface(name, through if side == "fg" else opaque),
        )

    def _surface(self, name: str, formulas: shaders.Formulas) -> Surface:
        found: dict[str, ParameterValue] = {}
        for key, formula in formulas.items():
            entry, baked = parameter(key, self._where), self._baked(key, formula)
            read = self._direction if entry.kind == "vector" else self._final
            if (value := read(entry, baked)) is not None:
                found[key] = value
        return Surface(name, self._shader.where, _bright(found))

    def _given(self) -> shaders.Formulas | None:
        """The parameters that the shader itself, or a graph of the document, gives; else None."""
        shader, frame = self._shader, self._shader.frame
        tag, inputs = shader.tag, shader.element.getInputs()
        if tag == shaders.TARGET:
            for element in inputs:
                parameter(element.getName(), self._where)
            given = [e.getName() for e in inputs if has_value(frame.follow(e, shader.where))]
            return shaders.renamed(" ".join(given))
        definitions = self._graph.root.scope.getMatchingNodeDefs(f"{tag}_to_{shaders.TARGET}")
        inside = definitions and Node(shader.element, frame, definitions[0]).implementation()
        if inside:
            outputs = {x.getName().removesuffix("_out"): x for x in inside.scope.getOutputs()}
            return {
                name: partial(
                    lambda source, i: i.evaluation.value(source, shader.where),
                    inside.follow(output, shader.where),
                )
                for name, output in outputs.items()
                if name in PARAMETERS
            }
        if tag not in shaders.TRANSLATIONS:
            raise FileError(
                f"{self._where} has a shader of kind {tag[:40]}, which is not read; translate it "
                f"to one of {', '.join(shaders.SHADERS)}"
            )
        return None

    def ends(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """The least and the largest value (channels,) of an input on the surface."""
        if name not in self._ends:
            pixels = self._pixels(name, shaders.renamed(name))
            self._ends[name] = pixels.min(axis=(0, 1)), pixels.max(axis=(0, 1))
        return self._ends[name]

    def _value(self, formula: shaders.Formula) -> Value:
        return lambda e: formula(shaders.Inputs(e, self._shader, self.ends))

    def _changes(self, formula: shaders.Formula) -> bool:
        return changes(self._graph, self._value(formula))

    def _baked(self, name: str, formula: shaders.Formula) -> Texture:
        where = f"{self._where}: {name}"
        return bake(self._graph, self._value(formula), self._resolution, where)

    def _pixels(self, name: str, formulas: shaders.Formulas) -> np.ndarray:
        """The values (height, width, channels) of a baked parameter."""
        return self._baked(name, formulas[name]).pixels

    def _warn_of_losses(self, tag: str) -> None:
        """Warn of inputs without a parameter, where they would change something."""
        given = [element.getName() for element in self._shader.element.getInputs()]
        lost = [name for name in given if name not in self._shader.inputs]
        for name, formula in shaders.LOST.get(tag, {}).items():
            if name in given and self._changes(formula):
                lost.append(name)
        if lost:
            warn(f"{self._where}: OpenPBR has no counterpart of {', '.join(lost)[:200]} of {tag}")

    def _direction(self, entry: Parameter, value: Texture) -> Texture | None:
        """A normal map of directions; None if they are the geometry's own."""
        own, where = DIRECTIONS[entry.name.rsplit("_", 1)[-1]], f"{self._where}: {entry.name}"
        if value.is_number:
            number = value.pixels[0, 0]
            length = np.linalg.norm(number)  # 0: editors write directions that are not set so
            if number.shape == (3,) and np.allclose(number, length * own, atol=1e-6):
                return None
            raise FileError(
                f"{where} is a constant direction in space, which is not supported; leave it out, "
                "or give a normal map"
            )
        if own[2] == 0 or value.pixels.shape[-1] != 3:
            raise FileError(f"{where} varies over the surface, which is only supported for normals")
        return value.map(lambda n: 0.5 * n + 0.5)

    def _final(self, entry: Parameter, value: Texture) -> ParameterValue:
        """A value after checks; colours and textures are limited to the parameter's range.

        Numbers are refused outside of it.
        """
        where, have = f"{self._where}: {entry.name}", value.pixels.shape[-1]
        channels = 3 if entry.kind == "color" else 1
        if have != channels:
            raise FileError(f"{where} has {have} channels instead of {channels}")
        if entry.kind == "boolean" and not value.is_number:
            raise FileError(f"{where} must not vary over the surface")
        if (
            not value.is_number
            or (entry.kind == "color" and entry.name != "emission_color")
            or entry.name.startswith("transmission_")  # exporters write Abbe numbers as scales
        ):
            value = value.map(lambda x: self._limited(entry, x))
        if (constant := value.constant) is None:
            return value
        if entry.kind == "color":
            r, g, b = np.maximum(constant, 0.0).tolist()
            return r, g, b
        number = float(constant[0])
        limited = min(max(number, entry.low), entry.high)
        near = abs(limited - number) <= TOLERANCE
        return checked(entry.name, limited if near else number, self._where)

    def _limited(self, entry: Parameter, value: np.ndarray) -> np.ndarray:
        """Values limited to the range of a parameter, with a warning if that changes them much."""
        if max(entry.low - value.min(), value.max() - entry.high) > TOLERANCE:
            space = " in linear sRGB" if entry.kind == "color" else ""
            ends = f"[{entry.low:g}, {entry.high:g}]{space}"
            warn(f"{self._where}: {entry.name} leaves {ends} and is clipped to it")
        return np.clip(value, entry.low, entry.high)


def _bright(values: dict[str, ParameterValue]) -> dict[str, ParameterValue]:
    """The values, with an emission_color of at most 1 and no luminance of black."""
    color = values.get("emission_color")
    if color == (0.0, 0.0, 0.0) and "emission_luminance" in values:
        values["emission_luminance"] = 0.0
    luminance = values.get("emission_luminance", 0.0)
    if isinstance(color, tuple) and max(color) > 1 and isinstance(luminance, float):
        peak = max(color)
        r, g, b = (x / peak for x in color)
        values["emission_color"] = (r, g, b)
        values["emission_luminance"] = luminance * peak
    return values


def read_surface(
    path: str | os.PathLike,
    name: str | None = None,
    resolution: int = RESOLUTION,
    uv_plane: bool = False,
) -> Surface | Mix:
    """Read a material of a document; see `plugins.materialx.load_materialx`."""
    resolution = int(RESOLUTIONS(resolution))
    document = read_document(path)
    material = find_material(document, name)
    name, file = material.getName(), document.getSourceUri()
    where = f"'{file}': '{name[:60]}'"
    graph = Graph(Frame(document, f"'{file}'"), Images(Path(file).parent), uv_plane)
    left = iter(range(MAX_MIXED))  # an item for every shader that is allowed

    def read(shader: Node, outer: tuple[Node, ...] = ()) -> Surface | Mix:
        """The material of a shader, or the mixture of two. outer: mixtures that it is a part of."""
        if shader in outer:
            raise cycle(shader.where)
        if next(left, None) is None:
            raise FileError(
                f"{where} mixes more than {MAX_MIXED} surface shaders; mix the inputs of one "
                "shader instead, or bake the material into images"
            )
        if shader.tag != "mix":
            return Reader(graph, shader, resolution, where).material(name)
        mix = f"{shader.where}: mix"
        weight = bake(graph, lambda e: e.input(shader, "mix"), resolution, mix)
        return mixed(
            name, weight, mix, lambda side: read(_connected(shader, side), (*outer, shader))
        )

    try:
        return read(_shader_of(graph, material, where))
    except RecursionError:
        raise FileError(f"{where} has nodes nested too deeply; simplify it") from None


def _connected(node: Node, name: str) -> Node:
    """The shader to which an input of a node is connected."""
    return _shader(node.source(name), f"{node.where}: its {name}")


def _shader(source: Node | Any | None, where: str) -> Node:
    if not isinstance(source, Node):
        raise FileError(f"{where} is connected to no surface shader in the document")
    return source


def _shader_of(graph: Graph, element: Any, where: str) -> Node:
    """The surface shader of a material, or of a shader's graph."""
    nested = graph.root.node(element.getParent().getName())
    node = ((nested and nested.inside) or graph.root).node(element.getName())
    assert node is not None
    if node.tag != "surfacematerial":
        outputs = node.inside.scope.getOutputs() if node.inside else []
        if not node.inside or not outputs:
            return node
        return _shader(node.inside.follow(outputs[0], node.where), where)
    for name, part in _LOST_SHADERS.items():
        lost = node.source(name)
        if not isinstance(lost, Node):
            continue
        displaced = partial(Evaluation.input, node=lost, name="displacement")
        if lost.tag != "displacement" or changes(graph, displaced):
            warn(f"{where}: its {part} is left out; OpenPBR describes the front's surface")
    return _connected(node, "surfaceshader")
