"""Evaluation of a document's node graphs at points of the surface, on NumPy arrays.

Vectors are in the tangent frame: the normal is (0, 0, 1), the tangent (1, 0, 0).
"""

import re
from functools import partial
from typing import Any

import numpy as np

from urushi.errors import FileError
from urushi.openpbr_surface.materialx.colour_spaces import to_linear_srgb
from urushi.openpbr_surface.materialx.graph import MAX_CHAIN, Graph, Node, cycle
from urushi.openpbr_surface.materialx.images import ADDRESS_MODES, ImageUse, hextiles, sample
from urushi.openpbr_surface.materialx.nodes import BAKE, CHANNELS, NODES
from urushi.openpbr_surface.materialx.shaders import FILM_UNITS

#: Number of points at which a graph is evaluated first, to find the images that it depends on.
PROBES = 64

#: Texture coordinates of the first of them, by which affine maps are found.
CORNERS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])

#: Largest number of nodes that are evaluated for one parameter, with the nodes inside of others.
MAX_NODES = 2048

#: Directions of the surface, by the names of nodes and of geometric properties.
DIRECTIONS = {
    name: np.eye(3)[axis]
    for axis, word in enumerate(("tangent", "bitangent", "normal"))
    for name in (word, f"{word[0].upper()}world", f"{word[0].upper()}object")
}

#: A number at the beginning of a text, as C++ reads it.
_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)")

#: Texts of truth values.
_TRUTHS = {"true": 1.0, "false": 0.0, "1": 1.0, "0": 0.0}


class NeedsPosition(Exception):
    """The texture coordinates are needed where only an image's texels are given."""


class Evaluation:
    """Values of nodes at points."""

    def __init__(self, graph: Graph, uv: np.ndarray | None, texels: np.ndarray | None = None):
        """Evaluate at some points.

        uv: (N, 2), MaterialX's, from the lower left corner; None: `texels` are given.
        texels: values (N, channels) of the only image.
        """
        self.uses: list[ImageUse] = []  # the images that the values depend on
        self._graph = graph
        self._uv = uv
        self._texels = texels
        self._values: dict[Node, np.ndarray] = {}
        self._open: list[Node] = []
        self._metre = 1.0  # number of units of length in one

    @property
    def size(self) -> int:
        """Number of nodes evaluated."""
        return len(self._values)

    def _texture_coordinates(self, channels: int = 2) -> np.ndarray:
        """Texture coordinates (N, 2), or with a third of 0 (N, 3)."""
        if self._uv is None:
            raise NeedsPosition
        return np.pad(self._uv, ((0, 0), (0, channels - 2)))

    def input(self, node: Node, name: str) -> np.ndarray:
        """The value (..., channels) of a node's input; of its definition's default if not given."""
        self._metre = FILM_UNITS.get((node.tag, name), self._metre)
        source = node.source(name)
        return np.zeros(1) if source is None else self.value(source, node.where)

    def value(self, source: Node | Any, where: str) -> np.ndarray:
        """The value (..., channels) of a source (`graph.Frame.follow`).

        where: begins errors, the node that reads it.
        """
        if isinstance(source, Node):
            return self._of_node(source)
        text, kind = source.getAttribute("value"), source.getAttribute("type")
        if not text:
            geometric = source.getAttribute("defaultgeomprop")
            zeros = np.zeros(CHANNELS.get(kind, 1))
            return self._property(geometric, where) if geometric else zeros
        value = parse_value(text, kind, where)
        if unit := source.getAttribute("unit"):
            if unit not in (known := self._graph.units):
                names = ", ".join(known)
                raise FileError(
                    f"{where} has a value in '{unit[:40]}', an unknown unit; use {names}"
                )
            is_length, scale = known[unit]
            value = value * (scale * (self._metre if is_length else 1))
        if kind in ("color3", "color4"):
            value = to_linear_srgb(value, source.getActiveColorSpace(), where)
        return value

    def _of_node(self, node: Node) -> np.ndarray:
        """The value (..., channels) of a node."""
        if node in self._values:
            return self._values[node]
        if node in self._open:
            raise cycle(node.where)
        if len(self._open) >= MAX_CHAIN:
            raise FileError(f"{node.where} is the end of a chain of more than {MAX_CHAIN} nodes")
        if self.size >= MAX_NODES:
            raise FileError(
                f"{node.where} is one of more than {MAX_NODES} nodes of a single parameter"
            )
        self._open.append(node)
        try:
            value = np.asarray(self._evaluated(node), np.float64)
            value = np.broadcast_to(value, (*value.shape[:-1], CHANNELS[node.type]))
        except (TypeError, ValueError, LookupError) as error:
            raise FileError(
                f"{node.where} has inputs whose numbers of channels do not match its type "
                f"{node.type[:40]}; check them"
            ) from error
        self._open.pop()
        self._values[node] = value
        return value

    def _property(self, name: str, where: str) -> np.ndarray:
        """A geometric property, or what a node of this name gives."""
        if name in DIRECTIONS:
            return DIRECTIONS[name]
        if name.startswith("UV"):
            return self._texture_coordinates()
        if name not in ("position", "Pobject", "Pworld"):
            raise FileError(
                f"{where} needs the geometric property '{name[:60]}', which is unknown "
                f"before rendering; {BAKE}"
            )
        if not self._graph.uv_plane:
            raise FileError(
                f"{where} needs positions in space, which are unknown before rendering; set "
                f"uv_plane to take (u, v, 0), or {BAKE}"
            )
        return self._texture_coordinates(3)

    def _evaluated(self, node: Node) -> np.ndarray:
        tag, kind, where = node.tag, node.type, node.where
        if not kind:
            raise FileError(f"{where} has no type; give it one, such as color3")
        if kind in CHANNELS:
            if tag in ("normal", "tangent", "bitangent", "position"):
                return self._property(tag, where)
            if tag == "texcoord" or (tag == "geompropvalue" and kind == "vector2"):
                return self._texture_coordinates(3 if kind == "vector3" else 2)
            if tag in ("image", "hextiledimage"):
                return self._image(node)
            inputs = node.inputs.items()
            names = [name for name, x in inputs if x.getAttribute("type") != "string"]
            if names and tag in NODES:
                return NODES[tag](node, *(self.input(node, name) for name in names))
        raise FileError(f"{where} of type '{kind[:40]}' is of a kind that is not supported; {BAKE}")

    def _image(self, node: Node) -> np.ndarray:
        kind, where = node.type, node.where
        channels = CHANNELS[kind]
        file, space = node.text("file")
        if not file:
            return self.input(node, "default")
        modes = tuple(node.text(f"{axis}addressmode")[0] or "periodic" for axis in "uv")
        if bad := [mode for mode in modes if mode not in ADDRESS_MODES]:
            raise FileError(
                f"{where}: the address mode '{bad[0][:40]}' is unknown; use one of "
                f"{', '.join(ADDRESS_MODES)}"
            )
        if self._uv is None:
            assert self._texels is not None
            return self._texels
        uv, default = self.input(node, "texcoord"), self.input(node, "default")
        if default.ndim > 1 or uv.shape[-1] != 2:
            raise FileError(f"{where}: its default must be a constant, and its texcoord a vector2")
        image = self._graph.images.read(file, where)
        uv = (np.broadcast_to(uv, self._uv.shape) - image.corner) / image.tiles
        use = ImageUse(
            file,
            space if kind in ("color3", "color4") else "",
            channels,
            modes,
            blend=node.text("filtertype")[0] != "closest",
            matrix=_affine(self._uv[:PROBES], uv[:PROBES]) if node.tag == "image" else None,
        )
        if use not in self.uses:
            self.uses.append(use)
        values = self._graph.images.values(use, where)
        if node.tag == "hextiledimage":
            return hextiles(values, uv, partial(self.input, node))
        return sample(values, uv, use.modes, use.blend, default)


def parse_value(text: str, kind: str, where: str) -> np.ndarray:
    """The value (channels,) of an attribute, read as MaterialX does.

    Numbers are separated by commas or spaces. Text after a number is ignored, as in 0.5f; one
    number is the first of several.
    """
    channels = CHANNELS.get(kind)
    if channels is None:
        raise FileError(f"{where} has an input of type '{kind[:40]}', which is not supported")
    if kind == "boolean":
        numbers = [_TRUTHS.get(text.strip().lower(), np.nan)]
    else:
        parts = [_NUMBER.match(part) for part in re.split(r"[,\s]+", text) if part]
        numbers = [np.nan if part is None else float(part[1]) for part in parts]
    value = np.array(numbers[:1] if channels == 1 else numbers)
    if value.shape != (channels,) or not np.isfinite(value).all():
        raise FileError(f"{where} has the value '{text[:60]}', which is not of type {kind}")
    return np.clip(np.trunc(value) if kind == "integer" else value, -1e30, 1e30)  # FLT_MAX: none


def _affine(uv: np.ndarray, image_uv: np.ndarray) -> tuple[tuple[float, ...], ...] | None:
    """The affine map between two sets of points; None if uv does not begin with `CORNERS`."""
    if not np.array_equal(uv[:3], CORNERS):
        return None
    origin = image_uv[0]
    columns = np.stack([image_uv[1] - origin, image_uv[2] - origin, origin], axis=1)
    expected = uv @ columns[:, :2].T + origin
    if not np.allclose(expected, image_uv, rtol=1e-6, atol=1e-6):
        return None
    return tuple(tuple(float(round(x, 9)) for x in row) for row in columns)
