"""A document's node graphs: definitions of nodes, and the source of every value.

The library of the package `materialx` has the definitions of nodes, and graphs that implement them.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from urushi.errors import FileError, UrushiWarning
from urushi.openpbr_surface.materialx.images import Images
from urushi.openpbr_surface.materialx.nodes import CHANNELS, NODES
from urushi.openpbr_surface.materialx.shaders import SHADERS
from urushi.platform import require_extra

#: The library's files that are read, relative to its folder.
LIBRARY = (
    "stdlib/stdlib_defs.mtlx",
    "stdlib/stdlib_ng.mtlx",
    "bxdf/usd_preview_surface.mtlx",
    "bxdf/standard_surface.mtlx",
    "bxdf/gltf_pbr.mtlx",
    "bxdf/disney_principled.mtlx",
    "bxdf/translation/standard_surface_to_gltf_pbr.mtlx",
    "bxdf/translation/standard_surface_to_usd.mtlx",
)

#: Nodes that `evaluation` evaluates itself, besides `nodes.NODES`.
OWN = ("normal", "tangent", "bitangent", "texcoord", "position", "image", "hextiledimage")


def package() -> Any:
    """The package MaterialX."""
    require_extra("materialx")
    import MaterialX

    return MaterialX


@cache
def library() -> Any:
    """The files of `LIBRARY` as one document."""
    mx = package()
    whole = mx.createDocument()
    for name in LIBRARY:
        part = mx.createDocument()
        mx.readFromXmlFile(part, str(Path(mx.__file__).parent / "libraries" / name))
        whole.importLibrary(part)
    return whole


def _of_definition(element: Any, read: Callable[[Any], Any]) -> Any:
    """What is read from a node or a definition, which must not inherit from itself."""
    try:
        return read(element)
    except LookupError as error:
        raise FileError(
            f"the definition of '{element.getName()[:60]}' inherits from itself; remove the cycle"
        ) from error


def _declared_inputs(definition: Any | None) -> dict[str, Any]:
    """The inputs of a definition by name, with inherited ones; none of None."""
    given = definition and _of_definition(definition, lambda x: x.getActiveInputs())
    return {element.getName(): element for element in given or ()}


class Node:
    """A node or node graph in its frame."""

    def __init__(self, element: Any, frame: "Frame"):
        self.element = element  # of the package
        self.frame = frame
        self.tag: str = element.getCategory()
        self.type: str = element.getAttribute("type")
        #: Begins errors about the node.
        self.where = f"{frame.where}: the node '{element.getName()[:60]}' ({self.tag[:40]})"

    @cached_property
    def _definition(self) -> Any | None:
        """The definition that fits best."""
        return _of_definition(self.element, lambda x: x.getNodeDef("", True))

    @cached_property
    def inputs(self) -> dict[str, Any]:
        """The inputs of the definition by name; empty if there is none."""
        return _declared_inputs(self._definition)

    @property
    def reads_uv(self) -> bool:
        """Whether the node has texture coordinates by their name."""
        return self.tag in ("geompropvalue", "UsdPrimvarReader") and self.type == "vector2"

    @cached_property
    def inside(self) -> "Frame | None":
        """The graph that gives the node its value; None if it is elementary or unknown."""
        if self.tag == "nodegraph":
            return Frame(self.element, self.frame.where, self.frame)
        self._warn_of_losses()
        elementary = self.type in CHANNELS if self.tag in NODES else self.tag in (*OWN, *SHADERS)
        return None if elementary or self.reads_uv else self.implemented(self._definition)

    def implemented(self, definition: Any | None) -> "Frame | None":
        """The graph of a definition, with this node's inputs; None if there is no graph."""
        graph = None if definition is None else definition.getImplementation()
        if graph is None or graph.getCategory() != "nodegraph":
            return None
        return Frame(graph, self.frame.where, self.frame, self, definition)

    def _warn_of_losses(self) -> None:
        """Warn of what the node asks for and MaterialX leaves out; shaders have their own."""
        known = {} if self.tag in SHADERS else self.inputs
        given = (x.getName() for x in self.element.getInputs()) if known else ()
        lost = [f"the unknown input {name}" for name in given if name not in known]
        if self.tag == "blur":
            lost = ["blurring"]
        if lost:
            warnings.warn(
                f"{self.where}: {', '.join(lost)[:200]} is left out, as by MaterialX",
                UrushiWarning,
                stacklevel=3,
            )

    def source(self, name: str) -> "Source | None":
        """The source of an input; None if neither it nor a default is given."""
        element = self.element.getInput(name)
        found = None if element is None else self.frame.follow(element, self.where)
        if (found is None or not found.is_given) and name in self.inputs:
            return Source(self.inputs[name])
        return found


@dataclass(frozen=True, eq=False)
class Source:
    """Where a value comes from: a node, or an input or output that has the value itself."""

    element: Any
    node: Node | None = None

    @property
    def is_given(self) -> bool:
        """Whether there is a value."""
        return self.node is not None or any(
            self.element.getAttribute(x) for x in ("value", "defaultgeomprop")
        )


class Frame:
    """A node graph that is evaluated for one of its instances, or the document."""

    def __init__(
        self,
        scope: Any,
        where: str,
        outer: "Frame | None" = None,
        instance: Node | None = None,
        definition: Any = None,
    ):
        """Take a graph, or a document, of the package.

        where: begins errors. outer: where the graph is, or its instance; None: it is the document.
        instance, definition: the node whose graph it is; None: the graph stands for itself.
        """
        self.scope, self.where = scope, where
        self._outer, self._instance, self._definition = outer, instance, definition
        self._root: Frame = self if outer is None else outer._root
        self._nodes: dict[str, Node] = {}

    def node(self, name: str) -> Node | None:
        """The node or node graph of a name."""
        mx, found = package(), self.scope.getChild(name)
        if name not in self._nodes and isinstance(found, mx.Node | mx.NodeGraph):
            self._nodes[name] = Node(found, self)
        return self._nodes.get(name)

    def follow(self, element: Any, where: str) -> Source:
        """The source of an input or output, followed through interfaces and graphs.

        where: begins errors, the node that reads it.
        """
        interface, name, graph, output = (
            element.getAttribute(x) for x in ("interfacename", "nodename", "nodegraph", "output")
        )
        if interface:
            return self._interface(interface, where) or Source(element)
        link, inner = name or graph, self._root
        if link:
            node = self.node(link) or (self._root.node(link) if graph else None)  # as MaterialX
            if node is None:
                raise FileError(f"{where} is connected to '{link[:60]}', which does not exist")
            if node.inside is None:
                return Source(node.element, node)
            inner = node.inside
        elif not output:
            return Source(self._geometric(element))
        outputs = inner.scope.getOutputs()
        found = next((x for x in outputs if output in ("", x.getName())), None)
        if found is None:
            raise FileError(
                f"{where} is connected to the output '{output[:60]}' of "
                f"'{(link or 'the document')[:60]}', which does not exist"
            )
        return inner.follow(found, where)

    def _geometric(self, element: Any) -> Any:
        """The geometric property that MaterialX takes for an unconnected input, or the input."""
        owner = element.getParent()
        node = self.node(owner.getName()) if isinstance(owner, package().Node) else None
        declared = None if node is None else node.inputs.get(element.getName())
        is_geometric = declared is not None and declared.getAttribute("defaultgeomprop")
        return declared if is_geometric else element

    def _interface(self, name: str, where: str) -> Source | None:
        """The source of the value of an interface of this graph."""
        outer, instance, definition = self._outer, self._instance, self._definition
        if instance is None:
            declared = self.scope.getInput(name)
            if declared is not None:
                return (outer or self).follow(declared, where)
            if outer is None:
                raise FileError(
                    f"{where} reads '{name[:60]}' from a node graph, but is not inside one"
                )
            definition = self.scope.getNodeDef()
        elif (given := instance.element.getInput(name)) is not None:
            assert outer is not None
            source = outer.follow(given, instance.where)
            if source.is_given:
                return source
        default = _declared_inputs(definition).get(name)
        return None if default is None else Source(default)


@dataclass(eq=False)
class Graph:
    """The nodes of a document, with the images that they read."""

    root: Frame
    images: Images
    uv_plane: bool = False  # whether positions in space are (u, v, 0); else they are refused
