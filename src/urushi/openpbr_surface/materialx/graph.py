"""A document's node graphs: definitions of nodes, and the source of every value.

The library of the package `materialx` has the definitions of nodes, and graphs that implement them.
"""

import warnings
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from urushi.errors import FileError, UrushiWarning
from urushi.openpbr_surface.materialx.images import Images
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


@cache
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
        mx.readFromXmlFile(whole, str(Path(mx.__file__).parent / "libraries" / name))
    return whole


def _definition(element: Any) -> Any | None:
    """The definition that a node names, as in MaterialX, or else the one that fits best."""
    found = element.getNodeDef("", True)
    if found is None and element.getNodeDefString():  # it names one that is missing
        element.removeAttribute("nodedef")
        found = element.getNodeDef("", True)
    return found


class Node:
    """A node or node graph in its frame."""

    def __init__(self, element: Any, frame: "Frame", definition: Any | None = None):
        """Take a node of the package. definition: None: the one that fits best."""
        self.element, self.frame = element, frame
        self.tag: str = element.getCategory()
        self.type: str = element.getAttribute("type")
        #: Begins errors about the node.
        self.where = f"{frame.where}: the node '{element.getName()[:60]}' ({self.tag[:40]})"
        if self.tag == "nodegraph":
            self._definition = element.getNodeDef()
        elif found := definition or _definition(element):
            self._definition, self.tag = found, found.getNodeString()
        else:
            self._definition = None

    @cached_property
    def inputs(self) -> dict[str, Any]:
        """The inputs of the definition by name, with inherited ones; empty if there is none.

        Those of another type's definition if its own has none: they have the same names.
        """
        definition = self._definition
        if definition is None:
            definition = next(iter(self.element.getDocument().getMatchingNodeDefs(self.tag)), None)
        given = () if definition is None else definition.getActiveInputs()
        return {element.getName(): element for element in given}

    @cached_property
    def inside(self) -> "Frame | None":
        """The graph that gives the node its value; None if there is none, or it is a shader."""
        if self.tag == "nodegraph":
            return Frame(self.element, self.frame.where, self)
        self._warn_of_losses()
        return None if self.tag in SHADERS else self.implementation()

    def implementation(self) -> "Frame | None":
        """The graph of the definition, if it has one."""
        graph = None if self._definition is None else self._definition.getImplementation()
        if graph is None or graph.getCategory() != "nodegraph":
            return None
        outer = self.frame.instance
        while outer is not None:
            if outer.tag == self.tag and outer._definition == self._definition:
                raise FileError(f"{self.where} is used by its own definition; remove the cycle")
            outer = outer.frame.instance
        return Frame(graph, self.frame.where, self)

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

    def source(self, name: str) -> "Node | Any | None":
        """What gives an input its value (`Frame.follow`); None if no default is given, either."""
        element = self.element.getInput(name)
        found = None if element is None else self.frame.follow(element, self.where)
        if found is None or not has_value(found):
            return self.inputs.get(name, found)
        return found

    def text(self, name: str) -> tuple[str, str]:
        """An input of type string, or filename with its prefix and tokens, and its colour space.

        Both are "" if there is none.
        """
        source, passed = self.source(name), [self]
        while isinstance(source, Node):
            if source in passed:
                raise cycle(source.where)
            passed.append(source)
            source = source.source({"constant": "value", "dot": "in"}.get(source.tag, ""))
        if source is None:
            return "", ""
        return source.getResolvedValueString(), source.getActiveColorSpace()


def has_value(source: Node | Any) -> bool:
    """Whether a source (`Frame.follow`) gives a value."""
    attributes = "value", "defaultgeomprop"
    return isinstance(source, Node) or any(source.getAttribute(x) for x in attributes)


def cycle(where: str) -> FileError:
    """The error of a node, named by `where`, whose value depends on itself."""
    return FileError(f"{where} is connected to itself; remove the cycle")


class Frame:
    """A node graph that is evaluated for one of its instances, or the document."""

    def __init__(self, scope: Any, where: str, instance: Node | None = None):
        """Take a graph, or a document, of the package.

        where: begins errors.
        instance: the node whose graph it is, or the graph's own node; None: it is the document.
        """
        self.scope, self.where, self.instance = scope, where, instance
        self._root: Frame = self if instance is None else instance.frame._root
        self._nodes: dict[str, Node] = {}
        self._followed: list[str] = []  # inputs and outputs that are being followed

    def node(self, name: str) -> Node | None:
        """The node or node graph of a name."""
        mx, found = package(), self.scope.getChild(name)
        if name not in self._nodes and isinstance(found, mx.Node | mx.NodeGraph):
            self._nodes[name] = Node(found, self)
        return self._nodes.get(name)

    def follow(self, element: Any, where: str) -> Node | Any:
        """What gives an input or output its value, through interfaces and graphs.

        It is a node, or an input or output of the package that has the value itself.

        where: begins errors, the node that reads it.
        """
        path = element.getNamePath()
        if path in self._followed:
            raise FileError(
                f"{where} is connected to '{path[:60]}', which is connected to itself; remove the "
                "cycle"
            )
        self._followed.append(path)
        try:
            return self._next(element, where)
        finally:
            self._followed.pop()

    def _next(self, element: Any, where: str) -> Node | Any:
        """`follow`, which keeps a list of what it follows."""
        interface, name, graph, output = (
            element.getAttribute(x) for x in ("interfacename", "nodename", "nodegraph", "output")
        )
        if interface:
            if self.instance is not None:
                return self.instance.source(interface) or element
            declared = self.scope.getInput(interface)
            if declared is None:
                raise FileError(
                    f"{where} reads '{interface[:60]}' from a node graph, but is not inside one"
                )
            return self.follow(declared, where)
        link, inner = name or graph, self._root
        if link:
            node = self.node(link) or (self._root.node(link) if graph else None)  # as MaterialX
            if node is None:
                raise FileError(f"{where} is connected to '{link[:60]}', which does not exist")
            if node.inside is None:
                return node
            inner = node.inside
        elif not output:  # the geometric property that MaterialX takes for it, or the input
            owner = element.getParent()
            reader = self.node(owner.getName()) if isinstance(owner, package().Node) else None
            declared = None if reader is None else reader.inputs.get(element.getName())
            is_geometric = declared is not None and declared.getAttribute("defaultgeomprop")
            return declared if is_geometric else element
        outputs = inner.scope.getOutputs()
        found = next((x for x in outputs if output in ("", x.getName())), None)
        if found is None:
            raise FileError(
                f"{where} is connected to the output '{output[:60]}' of "
                f"'{(link or 'the document')[:60]}', which does not exist"
            )
        return inner.follow(found, where)


@dataclass(eq=False)
class Graph:
    """The nodes of a document, with the images that they read."""

    root: Frame
    images: Images
    uv_plane: bool = False  # whether positions in space are (u, v, 0); else they are refused

    def __post_init__(self) -> None:
        self.root.scope.setDataLibrary(library())

    @cached_property
    def units(self) -> dict[str, tuple[bool, float]]:
        """Units of the library and of the document: whether they are of length, and the factor.

        The factor is to metres, degrees, or what a unit without a scale measures.
        """
        return {
            unit.getName(): (units.getUnitType() == "distance", self._scale(unit))
            for source in (library(), self.root.scope)
            for units in source.getUnitDefs()
            for unit in units.getChildren()
        }

    def _scale(self, unit: Any) -> float:
        try:
            return float(unit.getAttribute("scale") or 1)
        except ValueError as error:
            raise FileError(
                f"{self.root.where}: the unit '{unit.getName()[:40]}' has no number as scale"
            ) from error
