"""Evaluation of a document's node graphs at points of the surface, on NumPy arrays.

Vectors are in the tangent frame: the normal is (0, 0, 1), the tangent (1, 0, 0).
"""

from dataclasses import dataclass, field

import numpy as np

from urushi.errors import FileError, UrushiError
from urushi.materialx.colour_spaces import to_linear_srgb
from urushi.materialx.definitions import Definitions
from urushi.materialx.images import ADDRESS_MODES, Images, ImageUse, Look, image_values, sample
from urushi.materialx.nodes import CHANNELS, NODES
from urushi.materialx.xml import Element

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


class NeedsPosition(Exception):
    """The texture coordinates are needed where only an image's texels are given."""


@dataclass(eq=False)
class Frame:
    """A node graph that is evaluated for one of its instances, or the document.

    Attributes:
        scope: the graph, or the document.
        instance: the node whose graph it is; None: it stands for itself.
        definition: the definition of that node.
        outer: where the instance is; None: `scope` is the document.
    """

    scope: Element
    instance: Element | None = None
    definition: Element | None = None
    outer: "Frame | None" = None
    nodes: dict[str, Element] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for child in self.scope.children:
            self.nodes.setdefault(child.name, child)


class Graph:
    """The nodes of a document with what is needed to evaluate them."""

    def __init__(self, root: Element, images: Images, where: str):
        """where: begins errors."""
        self.root = Frame(root)
        self.definitions = Definitions(root)
        self.images = images
        self.where = where


class Evaluation:
    """Values of nodes at points.

    Attributes:
        uses: the images that the values depend on.
        uses_position: whether they depend on the texture coordinates elsewhere too.
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
        self.uses_position = False
        self._graph = graph
        self._uv = uv
        self._texels = texels
        self._values: dict[tuple[Frame, Element, str], np.ndarray] = {}
        self._frames: dict[tuple[Frame, Element], Frame] = {}
        self._open: list[tuple[Frame, Element, str]] = []
        self._in_image = 0

    @property
    def size(self) -> int:
        return len(self._values)

    def texture_coordinates(self) -> np.ndarray:
        if self._uv is None:
            raise NeedsPosition
        if not self._in_image:
            self.uses_position = True
        return self._uv

    def input(self, node: Element, name: str, frame: Frame) -> np.ndarray:
        """The value (..., channels) of a node's input; of its definition's default if not given.

        Raises:
            FileError: the graph has a circle, is too large, or has a node that is not supported.
        """
        element = node.input(name)
        if element is not None:
            value = self._connection(element, frame, node)
            if value is not None:
                return value
        definition = self._graph.definitions.find(node)
        return self._default(definition, name, element, node)

    def output(self, node: Element, frame: Frame, output: str = "") -> np.ndarray:
        """The value (..., channels) of a node."""
        key = (frame, node, output)
        if key in self._values:
            return self._values[key]
        where = self._named(node)
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

    def text(self, node: Element, name: str, frame: Frame) -> str:
        """The text of an input of type string or filename, with the prefix of file names."""
        element = node.input(name)
        for _ in range(MAX_CHAIN):
            if element is None:
                break
            if (outside := element.get("interfacename")) is not None:
                if frame.instance is None or frame.outer is None:
                    element = next((i for i in frame.scope.inputs() if i.name == outside), None)
                    frame = frame.outer or frame
                    continue
                declared = self._graph.definitions.inputs(frame.definition or frame.scope)
                element = frame.instance.input(outside) or declared.get(outside)
                frame = frame.outer
                continue
            if (link := element.get("nodename")) is not None:
                source = frame.nodes.get(link)
                element = source.input("value") if source and source.tag == "constant" else None
                continue
            prefix = (element.inherited("fileprefix") or "") if element.type == "filename" else ""
            return prefix + (element.get("value") or "")
        definition = self._graph.definitions.find(node)
        declared = {} if definition is None else self._graph.definitions.inputs(definition)
        return (declared[name].get("value") or "") if name in declared else ""

    def _named(self, node: Element) -> str:
        return f"{self._graph.where}: the node '{node.name[:60]}' ({node.tag[:40]})"

    def _connection(self, element: Element, frame: Frame, node: Element) -> np.ndarray | None:
        """The value of an input or output element; None if it has none."""
        wanted = element.get("output") or ""
        if (outside := element.get("interfacename")) is not None:
            return self._interface(outside, element, frame, node)
        if (link := element.get("nodename")) is not None:
            source = frame.nodes.get(link)
            if source is None or source.tag in ("input", "output"):
                raise FileError(
                    f"{self._named(node)} is connected to '{link[:60]}', which does not exist"
                )
            if source.tag == "nodegraph":
                return self._of_graph(source, wanted, frame)
            return self.output(source, frame, wanted)
        if (link := element.get("nodegraph")) is not None:
            source = frame.nodes.get(link)
            if source is None or source.tag != "nodegraph":
                raise FileError(
                    f"{self._named(node)} is connected to the node graph '{link[:60]}', which "
                    "does not exist"
                )
            return self._of_graph(source, wanted, frame)
        text = element.get("value")
        return None if text is None else self._constant(element, text, node)

    def _interface(self, name: str, element: Element, frame: Frame, node: Element) -> np.ndarray:
        """The value that the instance of a graph, or the graph itself, has for an input."""
        if frame.outer is None:
            raise FileError(
                f"{self._named(node)} reads '{name[:60]}' from a node graph, but is not inside one"
            )
        if frame.instance is not None:
            given = frame.instance.input(name)
            if given is not None:
                value = self._connection(given, frame.outer, frame.instance)
                if value is not None:
                    return value
            return self._default(frame.definition, name, element, frame.instance)
        declared = next((i for i in frame.scope.inputs() if i.name == name), None)
        if declared is not None:
            key = (frame, declared, "")
            if key in self._open or len(self._open) >= MAX_CHAIN:
                raise FileError(f"{self._named(node)} is connected to itself; remove the cycle")
            self._open.append(key)
            value = self._connection(declared, frame.outer, frame.scope)
            self._open.pop()
            if value is not None:
                return value
        return np.zeros(CHANNELS.get(element.type, 1))

    def _of_graph(self, graph: Element, output: str, frame: Frame) -> np.ndarray:
        """The value of an output of a node graph that stands for itself."""
        if (frame, graph) not in self._frames:
            self._frames[frame, graph] = Frame(graph, outer=frame)
        return self._of_frame(self._frames[frame, graph], output, graph)

    def _of_frame(self, inner: Frame, output: str, node: Element) -> np.ndarray:
        outputs = [child for child in inner.scope.children if child.tag == "output"]
        found = [child for child in outputs if output in ("", child.name)]
        if not found:
            raise FileError(f"{self._named(node)} has no output '{output[:60]}'")
        key = (inner, found[0], "")
        if key in self._open or len(self._open) >= MAX_CHAIN:
            raise FileError(f"{self._named(node)} is connected to itself; remove the cycle")
        self._open.append(key)
        value = self._connection(found[0], inner, found[0])
        self._open.pop()
        return np.zeros(CHANNELS.get(found[0].type, 1)) if value is None else value

    def _default(
        self, definition: Element | None, name: str, element: Element | None, node: Element
    ) -> np.ndarray:
        """The default of an input; zero if it has none."""
        declared = {} if definition is None else self._graph.definitions.inputs(definition)
        default = declared.get(name, element)
        if default is None:
            return np.zeros(1)
        if (geometric := default.get("defaultgeomprop")) is not None:
            return self._property(geometric, node)
        text = default.get("value")
        if text is None:
            return np.zeros(CHANNELS.get(default.type, 1))
        return parse_value(text, default.type, self._named(node))

    def _property(self, name: str, node: Element) -> np.ndarray:
        if name.startswith("UV"):
            return self.texture_coordinates()
        if name in _PROPERTIES:
            return np.array(_DIRECTIONS[_PROPERTIES[name]])
        raise FileError(
            f"{self._named(node)} needs the geometric property '{name[:60]}', which is unknown "
            "before rendering; bake the node into an image"
        )

    def _constant(self, element: Element, text: str, node: Element) -> np.ndarray:
        value = parse_value(text, element.type, self._named(node))
        if element.type in ("color3", "color4"):
            space = element.inherited("colorspace") or ""
            return to_linear_srgb(value, space, self._named(node))
        return value

    def _evaluate(self, node: Element, frame: Frame, output: str, where: str) -> np.ndarray:
        if node.tag in _DIRECTIONS:
            return np.array(_DIRECTIONS[node.tag])
        if node.tag == "texcoord" or (
            node.tag in ("geompropvalue", "UsdPrimvarReader") and node.type == "vector2"
        ):
            return self.texture_coordinates()
        if node.tag == "image":
            return self._image(node, frame, where)
        if node.tag in NODES:
            if node.type not in CHANNELS:
                raise FileError(
                    f"{where} has values of type '{node.type[:40]}', which is not supported; bake "
                    "the node into an image"
                )
            try:
                with np.errstate(all="ignore"):
                    value = np.asarray(NODES[node.tag](_Call(self, node, frame, where)), np.float64)
            except (ValueError, IndexError) as error:
                if isinstance(error, UrushiError):
                    raise
                raise FileError(
                    f"{where} has inputs whose numbers of channels do not match its type; check "
                    "them"
                ) from error
            if value.shape[-1] != CHANNELS[node.type]:
                value = self._channels(value, node, where)
            return value
        definition = self._graph.definitions.find(node)
        graph = None if definition is None else self._graph.definitions.graph(definition)
        if graph is None:
            raise FileError(f"{where} is of a kind that is not supported; bake it into an image")
        if (frame, node) not in self._frames:
            self._frames[frame, node] = Frame(graph, node, definition, frame)
        return self._of_frame(self._frames[frame, node], output, node)

    def _channels(self, value: np.ndarray, node: Element, where: str) -> np.ndarray:
        """A number as all channels of a node's type."""
        channels = CHANNELS[node.type]
        if value.shape[-1] != 1:
            raise FileError(
                f"{where} has {value.shape[-1]} channels instead of {channels}; its inputs do "
                "not match its type"
            )
        return np.broadcast_to(value, (*value.shape[:-1], channels))

    def _image(self, node: Element, frame: Frame, where: str) -> np.ndarray:
        channels = CHANNELS.get(node.type)
        if channels is None:
            raise FileError(f"{where} has type '{node.type[:40]}', which images cannot have")
        name = self.text(node, "file", frame)
        space = self._image_space(node, frame) if node.type in ("color3", "color4") else ""
        modes = [self.text(node, f"{axis}addressmode", frame) or "periodic" for axis in "uv"]
        if bad := [mode for mode in modes if mode not in ADDRESS_MODES]:
            raise FileError(
                f"{where}: the address mode '{bad[0][:40]}' is unknown; use one of "
                f"{', '.join(ADDRESS_MODES)}"
            )
        look = Look(modes[0], modes[1], self.text(node, "filtertype", frame) != "closest")
        if self._texels is not None:
            return self._texels
        self._in_image += 1
        uv = self.input(node, "texcoord", frame)
        self._in_image -= 1
        default = self.input(node, "default", frame)
        if default.ndim > 1 or uv.shape[-1] != 2:
            raise FileError(f"{where}: its default must be a constant, and its texcoord a vector2")
        pixels = self._graph.images.read(name, where)
        assert self._uv is not None
        uv = np.broadcast_to(uv, (len(self._uv), 2))
        use = ImageUse(name, space, channels, look, _affine(self._uv, uv))
        if use not in self.uses:
            self.uses.append(use)
        return sample(image_values(pixels, use, where), uv, look, default)

    def _image_space(self, node: Element, frame: Frame) -> str:
        """The colour space of an image's file input, or of the instance's that gives the file."""
        element = node.input("file")
        while element is not None:
            outside = element.get("interfacename")
            if outside is None or frame.outer is None:
                return element.inherited("colorspace") or ""
            if frame.instance is not None:
                element = frame.instance.input(outside)
            else:
                element = next((i for i in frame.scope.inputs() if i.name == outside), None)
            frame = frame.outer
        return ""


class _Call:
    """A node that is evaluated, see `nodes.Call`."""

    def __init__(self, evaluation: Evaluation, node: Element, frame: Frame, where: str):
        self._evaluation, self._node, self._frame = evaluation, node, frame
        self.type = node.type
        self.where = where

    def __getitem__(self, name: str) -> np.ndarray:
        return self._evaluation.input(self._node, name, self._frame)


def parse_value(text: str, kind: str, where: str) -> np.ndarray:
    """The value (channels,) of an attribute.

    Raises:
        FileError: it has another type, or is not finite.
    """
    channels = CHANNELS.get(kind)
    if channels is None:
        raise FileError(f"{where} has an input of type '{kind[:40]}', which is not supported")
    if kind == "boolean" and text in ("true", "false"):
        return np.array([float(text == "true")])
    try:
        value = np.array([float(part) for part in text.split(",")])
    except ValueError:
        value = np.empty(0)
    if value.shape != (channels,) or not np.isfinite(value).all() or np.abs(value).max() > 1e30:
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
