"""Evaluation of a document's node graphs at points of the surface, on NumPy arrays.

Vectors are in the tangent frame: the normal is (0, 0, 1), the tangent (1, 0, 0).
"""

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from urushi.errors import FileError, UrushiError
from urushi.openpbr_surface.materialx import definitions
from urushi.openpbr_surface.materialx.colour_spaces import to_linear_srgb
from urushi.openpbr_surface.materialx.images import (
    ADDRESS_MODES,
    Images,
    ImageUse,
    Look,
    hextiles,
    image_values,
    sample,
)
from urushi.openpbr_surface.materialx.nodes import BAKE, CHANNELS, NODES, Call
from urushi.openpbr_surface.materialx.shaders import FILM_UNITS, SHADERS

#: Largest number of nodes that are evaluated for one parameter, those inside of others included.
MAX_NODES = 2048

#: Largest number of nodes that are connected in a row.
MAX_CHAIN = 80

#: Directions of the surface, by the names of nodes and of geometric properties.
_DIRECTIONS = {
    "normal": (0.0, 0.0, 1.0),
    "tangent": (1.0, 0.0, 0.0),
    "bitangent": (0.0, 1.0, 0.0),
}
_PROPERTIES = {"Nworld": "normal", "Nobject": "normal", "Tworld": "tangent", "Tobject": "tangent"}
_PROPERTIES |= {"Bworld": "bitangent", "Bobject": "bitangent"}

#: Nodes that are evaluated here, besides those of `nodes.NODES`.
_OWN = (*_DIRECTIONS, "texcoord", "position", "image", "hextiledimage")

#: A number at the beginning of a text, as C++ reads it.
_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)")

#: Texts of truth values.
_TRUTHS = {"true": 1.0, "false": 0.0, "1": 1.0, "0": 0.0}


class NeedsPosition(Exception):
    """The texture coordinates are needed where only an image's texels are given."""


@dataclass(eq=False)
class Frame:
    """A node graph that is evaluated for one of its instances, or the document.

    Attributes:
        scope: the graph, or the document.
        outer: where the graph is, or its instance; None: `scope` is the document.
        instance: the node whose graph it is; None: it stands for itself.
        definition: of the instance.
    """

    scope: Any
    outer: "Frame | None" = None
    instance: Any = None
    definition: Any = None

    def node(self, name: str) -> Any | None:
        """The node or node graph of a name."""
        mx, found = definitions.package(), self.scope.getChild(name)
        return found if isinstance(found, mx.Node | mx.NodeGraph) else None


@dataclass(frozen=True, eq=False)
class Source:
    """Where a value comes from: a node, or an input or output that has the value itself.

    Attributes:
        element: the node, input or output.
        frame: where it is.
        output: the node's output, "" for the first.
    """

    element: Any
    frame: Frame
    output: str = ""

    @property
    def is_node(self) -> bool:
        return self.element.getCategory() not in ("input", "output")

    @property
    def is_given(self) -> bool:
        """Whether there is a value."""
        return self.is_node or any(
            self.element.getAttribute(x) for x in ("value", "defaultgeomprop")
        )


class Graph:
    """The nodes of a document with what is needed to evaluate them."""

    def __init__(self, root: Any, images: Images, where: str, uv_plane: bool = False):
        """Take a document.

        Args:
            root: the document of the package.
            images: reads its images.
            uv_plane: whether positions in space are (u, v, 0); else they are refused.
        """
        self.root = Frame(root)
        root.setDataLibrary(definitions.library())
        self.images = images
        self.where = where
        self.uv_plane = uv_plane
        self._frames: dict[tuple[Frame, str], Frame | None] = {}
        self._inputs: dict[tuple[Frame, str], dict[str, Any]] = {}

    def named(self, node: Any) -> str:
        """Begins errors about a node."""
        return f"{self.where}: the node '{node.getName()[:60]}' ({node.getCategory()[:40]})"

    def inputs(self, node: Any, frame: Frame) -> dict[str, Any]:
        """The inputs of a node's definition by name; empty if there is none."""
        key = frame, node.getNamePath()
        if key not in self._inputs:
            definition = definitions.of_node(node)
            found = {} if definition is None else definitions.inputs(definition)
            self._inputs[key] = found
        return self._inputs[key]

    def source(self, node: Any, name: str, frame: Frame) -> Source | None:
        """The source of a node's input; None if neither it nor a default is given."""
        element = node.getInput(name)
        found = None if element is None else self.follow(element, frame, node)
        if found is None or not found.is_given:
            declared = self.inputs(node, frame).get(name)
            return found if declared is None else Source(declared, frame)
        return found

    def follow(self, element: Any, frame: Frame, node: Any) -> Source:
        """The source of an input or output of a node, followed through interfaces and graphs."""
        for _ in range(MAX_CHAIN):
            if outside := element.getAttribute("interfacename"):
                declared = self._declared(outside, frame, node)
                if declared is None:
                    return Source(element, frame)
                element, frame = declared
                continue
            graph, output = (element.getAttribute(x) for x in ("nodegraph", "output"))
            link = element.getAttribute("nodename") or graph
            if not link and not output:
                return Source(element, frame)
            if link:
                target = frame.node(link)
                if target is None and graph:
                    frame = self.root  # as MaterialX looks for graphs
                    target = frame.node(link)
                if target is None:
                    raise FileError(
                        f"{self.named(node)} is connected to '{link[:60]}', which does not exist"
                    )
                inner = self.inside(target, frame)
                if inner is None:
                    return Source(target, frame, output)
            else:  # an output of the document
                inner = self.root
            outputs = inner.scope.getOutputs()
            found = next((child for child in outputs if output in ("", child.getName())), None)
            if found is None:
                raise FileError(
                    f"{self.named(node)} is connected to the output '{output[:60]}' of "
                    f"'{(link or 'the document')[:60]}', which does not exist"
                )
            element, frame = found, inner
        raise FileError(
            f"{self.named(node)} is connected to itself or through more than {MAX_CHAIN} graphs; "
            "remove the cycle"
        )

    def inside(self, node: Any, frame: Frame) -> Frame | None:
        """The graph that gives a node its value; None if the node is elementary or unknown."""
        key = frame, node.getNamePath()
        if key not in self._frames:
            if node.getCategory() == "nodegraph":
                self._frames[key] = Frame(node, frame)
            elif _is_elementary(node):
                self._frames[key] = None
            else:
                self._frames[key] = self._implementation(node, frame, definitions.of_node(node))
        return self._frames[key]

    def translation(self, shader: Any, frame: Frame, category: str) -> Frame | None:
        """The graph of a document for nodes of another category with a shader's inputs, if any."""
        found = self.root.scope.getMatchingNodeDefs(category)
        return self._implementation(shader, frame, found[0] if found else None)

    def _implementation(self, node: Any, frame: Frame, definition: Any) -> Frame | None:
        graph = None if definition is None else definition.getImplementation()
        if graph is None or graph.getCategory() != "nodegraph":
            return None
        return Frame(graph, frame, node, definition)

    def _declared(self, name: str, frame: Frame, node: Any) -> tuple[Any, Frame] | None:
        """The input that gives an interface of a graph its value, and the input's frame."""
        if frame.instance is not None:
            assert frame.outer is not None
            given = frame.instance.getInput(name)
            if given is not None and self.follow(given, frame.outer, frame.instance).is_given:
                return given, frame.outer
            default = definitions.inputs(frame.definition).get(name)
            return None if default is None else (default, frame)
        declared = frame.scope.getInput(name)
        if declared is None and (definition := frame.scope.getNodeDef()) is not None:
            declared = definitions.inputs(definition).get(name)
        if declared is None and frame.outer is None:
            raise FileError(
                f"{self.named(node)} reads '{name[:60]}' from a node graph, but is not inside one"
            )
        return None if declared is None else (declared, frame.outer or frame)


def _is_elementary(node: Any) -> bool:
    """Whether a node is evaluated here, or a surface shader that is translated."""
    tag = node.getCategory()
    if tag in NODES:
        return node.getAttribute("type") in CHANNELS
    return tag in _OWN or tag in SHADERS or _reads_uv(node)


def _reads_uv(node: Any) -> bool:
    readers = ("geompropvalue", "UsdPrimvarReader")
    return node.getCategory() in readers and node.getAttribute("type") == "vector2"


class Evaluation:
    """Values of nodes at points.

    Attributes:
        uses: the images that the values depend on.
        size: number of nodes evaluated.
    """

    def __init__(self, graph: Graph, uv: np.ndarray | None, texels: np.ndarray | None = None):
        """Evaluate at some points.

        Args:
            graph: the nodes.
            uv: (N, 2), MaterialX's, from the lower left corner; None: `texels` are given.
            texels: values (N, channels) of the only image.
        """
        self.uses: list[ImageUse] = []
        self._graph = graph
        self._uv = uv
        self._texels = texels
        self._values: dict[tuple[Frame, str, str], np.ndarray] = {}
        self._open: list[tuple[Frame, str, str]] = []
        self._metre = 1.0  # number of units of length in one

    @property
    def size(self) -> int:
        return len(self._values)

    def texture_coordinates(self) -> np.ndarray:
        if self._uv is None:
            raise NeedsPosition
        return self._uv

    def input(self, node: Any, name: str, frame: Frame) -> np.ndarray:
        """The value (..., channels) of a node's input; of its definition's default if not given."""
        self._metre = FILM_UNITS.get((node.getCategory(), name), self._metre)
        source = self._graph.source(node, name, frame)
        return np.zeros(1) if source is None else self.value(source, node)

    def value(self, source: Source, node: Any) -> np.ndarray:
        """The value (..., channels) of a source, which a node reads."""
        element, where = source.element, self._graph.named(node)
        if source.is_node:
            return self.output(element, source.frame, source.output)
        text, kind = element.getAttribute("value"), element.getAttribute("type")
        if not text:
            geometric = element.getAttribute("defaultgeomprop")
            zeros = np.zeros(CHANNELS.get(kind, 1))
            return self._property(geometric, where) if geometric else zeros
        value = parse_value(text, kind, where)
        if unit := element.getAttribute("unit"):
            value = value * self._unit(unit, where)
        if kind in ("color3", "color4"):
            value = to_linear_srgb(value, element.getActiveColorSpace(), where)
        return value

    def _unit(self, name: str, where: str) -> float:
        """The factor from a unit to degrees, or to the units of length of the parameter."""
        kind, scale = definitions.unit(self._graph.root.scope, name, where)
        return scale * self._metre if kind == "distance" else scale

    def output(self, node: Any, frame: Frame, output: str = "") -> np.ndarray:
        """The value (..., channels) of a node."""
        key = frame, node.getNamePath(), output
        if key in self._values:
            return self._values[key]
        where = self._graph.named(node)
        if key in self._open:
            raise FileError(f"{where} is connected to itself; remove the cycle")
        if len(self._open) >= MAX_CHAIN:
            raise FileError(f"{where} is the end of a chain of more than {MAX_CHAIN} nodes")
        if self.size >= MAX_NODES:
            raise FileError(f"{where} is one of more than {MAX_NODES} nodes of a single parameter")
        self._open.append(key)
        value = self._evaluate(node, frame, output, where)
        self._open.pop()
        self._values[key] = value
        return value

    def text(self, node: Any, name: str, frame: Frame) -> str:
        """The text of an input of type string or filename, with the prefix of file names."""
        source = self._text_source(node, name, frame)
        if source is None:
            return ""
        element = source.element
        is_file = element.getAttribute("type") == "filename"
        return (element.getActiveFilePrefix() if is_file else "") + element.getAttribute("value")

    def _text_source(self, node: Any, name: str, frame: Frame) -> Source | None:
        """The input that has a text."""
        source = self._graph.source(node, name, frame)
        for _ in range(MAX_CHAIN):
            if source is None or not source.is_node:
                return source
            name = {"constant": "value", "dot": "in"}.get(source.element.getCategory(), "")
            source = self._graph.source(source.element, name, source.frame)
        return None

    def _property(self, name: str, where: str) -> np.ndarray:
        if name.startswith("UV"):
            return self.texture_coordinates()
        if name in ("Pobject", "Pworld"):
            return self._position(where)
        if name in _PROPERTIES:
            return np.array(_DIRECTIONS[_PROPERTIES[name]])
        raise FileError(
            f"{where} needs the geometric property '{name[:60]}', which is unknown "
            f"before rendering; {BAKE}"
        )

    def _position(self, where: str) -> np.ndarray:
        if not self._graph.uv_plane:
            raise FileError(
                f"{where} needs positions in space, which are unknown before rendering; set "
                f"uv_plane to take (u, v, 0), or {BAKE}"
            )
        uv = self.texture_coordinates()
        return np.concatenate([uv, np.zeros((len(uv), 1))], axis=-1)

    def _evaluate(self, node: Any, frame: Frame, output: str, where: str) -> np.ndarray:
        tag, kind = node.getCategory(), node.getAttribute("type")
        if tag in _DIRECTIONS:
            return np.array(_DIRECTIONS[tag])
        if tag == "texcoord" or _reads_uv(node):
            return self.texture_coordinates()
        if tag == "position":
            return self._position(where)
        if tag in ("image", "hextiledimage"):
            return self._image(node, frame, where)
        if tag not in NODES or kind not in CHANNELS:
            raise FileError(
                f"{where} of type '{kind[:40]}' is of a kind that is not supported; {BAKE}"
            )
        try:
            with np.errstate(all="ignore"):
                value = np.asarray(NODES[tag](self._call(node, frame, where)), np.float64)
        except (ValueError, IndexError) as error:
            if isinstance(error, UrushiError):
                raise
            raise FileError(
                f"{where} has inputs whose numbers of channels do not match its type; check them"
            ) from error
        channels = CHANNELS[kind]
        if value.shape[-1] not in (1, channels):  # a number stands for all channels
            raise FileError(
                f"{where} has {value.shape[-1]} channels instead of {channels}; its inputs do "
                "not match its type"
            )
        return np.broadcast_to(value, (*value.shape[:-1], channels))

    def _call(self, node: Any, frame: Frame, where: str) -> Call:
        tag, kind = node.getCategory(), node.getAttribute("type")
        return Call(tag, kind, where, lambda name: self.input(node, name, frame))

    def _image(self, node: Any, frame: Frame, where: str) -> np.ndarray:
        kind = node.getAttribute("type")
        channels = CHANNELS.get(kind)
        if channels is None:
            raise FileError(f"{where} has type '{kind[:40]}', which images cannot have")
        name = self.text(node, "file", frame)
        space = ""
        if kind in ("color3", "color4"):
            file = self._text_source(node, "file", frame)
            space = "" if file is None else file.element.getActiveColorSpace()
        modes = [self.text(node, f"{axis}addressmode", frame) or "periodic" for axis in "uv"]
        if bad := [mode for mode in modes if mode not in ADDRESS_MODES]:
            raise FileError(
                f"{where}: the address mode '{bad[0][:40]}' is unknown; use one of "
                f"{', '.join(ADDRESS_MODES)}"
            )
        look = Look(modes[0], modes[1], self.text(node, "filtertype", frame) != "closest")
        if self._texels is not None:
            return self._texels
        uv = self.input(node, "texcoord", frame)
        default = self.input(node, "default", frame)
        if default.ndim > 1 or uv.shape[-1] != 2:
            raise FileError(f"{where}: its default must be a constant, and its texcoord a vector2")
        pixels = self._graph.images.read(name, where)
        assert self._uv is not None
        uv = np.broadcast_to(uv, (len(self._uv), 2))
        tiled = node.getCategory() == "hextiledimage"
        matrix = None if tiled else _affine(self._uv, uv)
        use = ImageUse(name, space, channels, look, matrix)
        if use not in self.uses:
            self.uses.append(use)
        values = image_values(pixels, use, where)
        if tiled:
            return hextiles(values, uv, self._call(node, frame, where))
        return sample(values, uv, look, default)


def parse_value(text: str, kind: str, where: str) -> np.ndarray:
    """The value (channels,) of an attribute, read as MaterialX does.

    Numbers are separated by commas or spaces. What follows a number is left out, as in 0.5f; one
    number is the first of several.
    """
    channels = CHANNELS.get(kind)
    if channels is None:
        raise FileError(f"{where} has an input of type '{kind[:40]}', which is not supported")
    if kind == "boolean":
        value = np.array([_TRUTHS[x] for x in (text.strip().lower(),) if x in _TRUTHS])
    else:
        parts = [_NUMBER.match(part) for part in re.split(r"[,\s]+", text) if part]
        parts = parts[:1] if channels == 1 else parts
        value = np.array([float(part[1]) for part in parts if part is not None])
        value = np.trunc(value) if kind == "integer" else value
        value = np.where(np.isfinite(value), np.clip(value, -1e30, 1e30), value)  # FLT_MAX: none
        value = value if None not in parts else np.empty(0)
    if value.shape != (channels,) or not np.isfinite(value).all():
        raise FileError(f"{where} has the value '{text[:60]}', which is not of type {kind}")
    return value


def _affine(uv: np.ndarray, image_uv: np.ndarray) -> tuple[tuple[float, ...], ...] | None:
    """The affine map between two sets of points, of which the first are (0, 0), (1, 0), (0, 1)."""
    origin = image_uv[0]
    columns = np.stack([image_uv[1] - origin, image_uv[2] - origin, origin], axis=1)
    expected = uv @ columns[:, :2].T + origin
    if not np.allclose(expected, image_uv, rtol=1e-6, atol=1e-6):
        return None
    return tuple(tuple(float(round(x, 9)) for x in row) for row in columns)
