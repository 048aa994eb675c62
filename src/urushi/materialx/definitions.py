"""Definitions of nodes and the graphs that implement them, of the document and of the library."""

from functools import cache

from urushi.errors import FileError
from urushi.materialx.package import libraries
from urushi.materialx.xml import Element, parse

#: The library's files that are read, relative to its folder.
LIBRARY = (
    "stdlib/stdlib_defs.mtlx",
    "stdlib/stdlib_ng.mtlx",
    "bxdf/usd_preview_surface.mtlx",
    "bxdf/standard_surface.mtlx",
    "bxdf/gltf_pbr.mtlx",
    "bxdf/translation/standard_surface_to_open_pbr.mtlx",
)

#: Largest number of definitions that inherit from each other.
MAX_INHERITANCE = 8


class Definitions:
    """Definitions of a document, before those of the library."""

    def __init__(self, root: Element):
        self._own = _Index([root])

    def find(self, node: Element) -> Element | None:
        """The definition of a node that fits its type and the types of its inputs, if any."""
        for index in (self._own, _library()):
            best, most = None, -1
            for definition in index.by_node.get(node.tag, ()):
                score = self._score(definition, node)
                if score > most:
                    best, most = definition, score
            if best is not None:
                return best
        return None

    def named(self, name: str) -> Element | None:
        """The definition of a name."""
        return self._own.by_name.get(name) or _library().by_name.get(name)

    def graph(self, definition: Element) -> Element | None:
        """The node graph that implements a definition, if any."""
        name = definition.name
        return self._own.graphs.get(name) or _library().graphs.get(name)

    def inputs(self, definition: Element) -> dict[str, Element]:
        """The inputs of a definition by name, those that it inherits included.

        Raises:
            FileError: definitions inherit from each other in a circle.
        """
        found: dict[str, Element] = {}
        current: Element | None = definition
        for _ in range(MAX_INHERITANCE):
            if current is None:
                return found
            for element in current.inputs():
                found.setdefault(element.name, element)
            parent = current.get("inherit")
            current = None if parent is None else self.named(parent)
        raise FileError(
            f"the definition '{definition.name[:60]}' inherits from itself, or through more than "
            f"{MAX_INHERITANCE} others"
        )

    def _score(self, definition: Element, node: Element) -> int:
        """How well a definition fits a node; -1: not at all."""
        if (wanted := node.get("nodedef")) is not None and wanted == definition.name:
            return 1 << 20
        outputs = [child for child in definition.children if child.tag == "output"]
        if node.type == "multioutput":
            if len(outputs) < 2:
                return -1
        elif outputs and node.type not in [output.type for output in outputs]:
            return -1
        inputs = self.inputs(definition)
        score = 1 if definition.get("isdefaultversion") == "true" else 0
        for element in node.inputs():
            declared = inputs.get(element.name)
            if declared is not None:
                score += 4 if declared.type == element.type else -2
        return max(score, 0)


class _Index:
    """The definitions and graphs of some documents."""

    def __init__(self, roots: list[Element]):
        self.by_node: dict[str, list[Element]] = {}
        self.by_name: dict[str, Element] = {}
        self.graphs: dict[str, Element] = {}
        named: dict[str, Element] = {}
        implementations = []
        for root in roots:
            for element in root.children:
                if element.tag == "nodedef":
                    self.by_node.setdefault(element.get("node") or "", []).append(element)
                    self.by_name[element.name] = element
                elif element.tag == "nodegraph":
                    named[element.name] = element
                    if (definition := element.get("nodedef")) is not None:
                        self.graphs[definition] = element
                elif element.tag == "implementation" and element.get("nodegraph") is not None:
                    implementations.append(element)
        for element in implementations:
            graph = named.get(element.get("nodegraph") or "")
            if graph is not None:
                self.graphs.setdefault(element.get("nodedef") or "", graph)


@cache
def _library() -> _Index:
    folder = libraries()
    roots = []
    for name in LIBRARY:
        path = folder / name
        if path.is_file():
            roots.append(parse(path.read_bytes(), f"'{path}'"))
    return _Index(roots)
