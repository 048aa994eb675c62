"""A document's node graphs: definitions of nodes, and the source of every value.

The library of the package `materialx` has the definitions of nodes, and graphs that implement them.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
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

#: Largest number of nodes that are connected in a row.
MAX_CHAIN = 80

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


def _without_cycles(element: Any, read: Callable[[Any], Any]) -> Any:
    """What is read from a node or a definition, which must not inherit from itself."""
    try:
        return read(element)
    except LookupError as error:
        raise FileError(
            f"the definition of '{element.getName()[:60]}' inherits from itself; remove the cycle"
        ) from error


def definition_of(node: Any) -> Any | None:
    """The definition that fits a node best."""
    return _without_cycles(node, lambda x: x.getNodeDef("", True))


def declared_inputs(definition: Any | None) -> dict[str, Any]:
    """The inputs of a definition by name, with inherited ones; none of None."""
    given = definition and _without_cycles(definition, lambda x: x.getActiveInputs())
    return {element.getName(): element for element in given or ()}


@dataclass(eq=False)
class Frame:
    """A node graph that is evaluated for one of its instances, or the document."""

    scope: Any  # the graph, or the document
    outer: "Frame | None" = None  # where the graph is, or its instance; None: it is the document
    instance: Any = None  # the node whose graph it is; None: it stands for itself
    definition: Any = None  # of the instance

    def node(self, name: str) -> Any | None:
        """The node or node graph of a name."""
        mx, found = package(), self.scope.getChild(name)
        return found if isinstance(found, mx.Node | mx.NodeGraph) else None


@dataclass(frozen=True, eq=False)
class Source:
    """Where a value comes from: a node, or an input or output that has the value itself."""

    element: Any  # the node, input or output
    frame: Frame  # where it is
    output: str = ""  # the node's output, "" for the first

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
    """The nodes of a document, with the definitions and images that evaluation needs."""

    def __init__(self, root: Any, images: Images, where: str, uv_plane: bool = False):
        """Take a document of the package.

        uv_plane: whether positions in space are (u, v, 0); else they are refused.
        """
        self.root = Frame(root)
        root.setDataLibrary(library())
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
            self._inputs[key] = declared_inputs(definition_of(node))
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
                return Source(self._geometric(element, frame), frame)
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
                self._frames[key] = self._implementation(node, frame, definition_of(node))
            self._warn_of_losses(node, frame)
        return self._frames[key]

    def _warn_of_losses(self, node: Any, frame: Frame) -> None:
        """Warn of what a node asks for and MaterialX leaves out; shaders have their own warning."""
        tag = node.getCategory()
        known = {} if tag == "nodegraph" or tag in SHADERS else self.inputs(node, frame)
        unknown = [x.getName() for x in node.getInputs() if x.getName() not in known]
        lost = (
            ["blurring"] if tag == "blur" else [f"the unknown input {x}" for x in unknown if known]
        )
        if lost:
            warnings.warn(
                f"{self.named(node)}: {', '.join(lost)[:200]} is left out, as by MaterialX",
                UrushiWarning,
                stacklevel=3,
            )

    def _geometric(self, element: Any, frame: Frame) -> Any:
        """The geometric property that MaterialX takes for an unconnected input, or the input."""
        node = element.getParent()
        known = self.inputs(node, frame) if isinstance(node, package().Node) else {}
        declared = known.get(element.getName())
        is_geometric = declared is not None and declared.getAttribute("defaultgeomprop")
        return declared if is_geometric else element

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
            default = declared_inputs(frame.definition).get(name)
            return None if default is None else (default, frame)
        declared = frame.scope.getInput(name)
        if declared is None and frame.outer is None:
            raise FileError(
                f"{self.named(node)} reads '{name[:60]}' from a node graph, but is not inside one"
            )
        if declared is None:
            declared = declared_inputs(frame.scope.getNodeDef()).get(name)
        return None if declared is None else (declared, frame.outer or frame)


def _is_elementary(node: Any) -> bool:
    """Whether a node is evaluated here, or a surface shader that is translated."""
    tag = node.getCategory()
    if tag in NODES:
        return node.getAttribute("type") in CHANNELS
    return tag in OWN or tag in SHADERS or reads_uv(node)


def reads_uv(node: Any) -> bool:
    readers = ("geompropvalue", "UsdPrimvarReader")
    return node.getCategory() in readers and node.getAttribute("type") == "vector2"
