"""Definitions of nodes and the graphs that implement them, of the document and of the library.

The package `materialx` has the library, and upgrades old documents.
"""

import re
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from urushi.errors import FileError, PlatformError
from urushi.openpbr_surface.materialx.xml import Element, parse

#: The library's files that are read, relative to its folder.
LIBRARY = (
    "stdlib/stdlib_defs.mtlx",
    "stdlib/stdlib_ng.mtlx",
    "bxdf/usd_preview_surface.mtlx",
    "bxdf/standard_surface.mtlx",
    "bxdf/gltf_pbr.mtlx",
    "bxdf/disney_principled.mtlx",
)

#: Largest number of definitions that inherit from each other.
MAX_INHERITANCE = 8


class Definitions:
    """Definitions of a document, before those of the library."""

    def __init__(self, root: Element):
        self._own = _Index([root])
        self._found: dict[Element, Element | None] = {}

    def find(self, node: Element) -> Element | None:
        """The definition of a node that fits its type and the types of its inputs, if any."""
        if node not in self._found:
            self._found[node] = self._best(node)
        return self._found[node]

    def _best(self, node: Element) -> Element | None:
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
        return self._own.by_name.get(name) or _library().by_name.get(name)

    def graph(self, definition: Element) -> Element | None:
        """The node graph that implements a definition, if any."""
        name = definition.name
        return self._own.graphs.get(name) or _library().graphs.get(name)

    def unit(self, name: str, where: str) -> tuple[str, float]:
        """The kind of a unit, such as distance, and its size in metres or degrees.

        Raises:
            FileError: neither the document nor the library defines it.
        """
        for index in (self._own, _library()):
            if name in index.units:
                return index.units[name]
        known = ", ".join(_library().units)
        raise FileError(f"{where} has a value in '{name[:40]}', an unknown unit; use {known}")

    def inputs_of(self, node: Element) -> dict[str, Element]:
        """The inputs of a node's definition by name; empty if there is none."""
        definition = self.find(node)
        return {} if definition is None else self.inputs(definition)

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
        elif outputs and node.type not in ("", *(output.type for output in outputs)):
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
        self.units: dict[str, tuple[str, float]] = {}
        named: dict[str, Element] = {}
        implementations = []
        for root in roots:
            for element in root.children:
                if element.tag == "nodedef":
                    self.by_node.setdefault(element.get("node") or "", []).append(element)
                    self.by_name[element.name] = element
                elif element.tag == "unitdef":
                    for unit in element.children:
                        size = re.fullmatch(r"[0-9.]{1,20}", unit.get("scale") or "1")
                        kind = element.get("unittype") or ""
                        self.units[unit.name] = (kind, float(size[0]) if size else 1.0)
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


def libraries() -> Path:
    """The folder of the package's libraries.

    Raises:
        PlatformError: the package is not installed.
    """
    spec = find_spec("MaterialX")
    if spec is None or spec.origin is None:
        raise PlatformError(
            "the package materialx, whose library defines the nodes of this document, is missing; "
            "install it, for instance by pip install urushi[materialx]"
        )
    return Path(spec.origin).parent / "libraries"


def upgrade(text: str, where: str) -> Element:
    """A document of an old version, in the package's version.

    Raises:
        FileError: the package refuses the document.
        PlatformError: the package is not installed.
    """
    libraries()
    import MaterialX

    document = MaterialX.createDocument()
    try:
        MaterialX.readFromXmlString(document, text)
    except (MaterialX.Exception, RuntimeError, ValueError, IndexError) as error:
        reason = " ".join(str(error).split())[:200]
        raise FileError(
            f"{where} cannot be upgraded to MaterialX 1.39 ({reason}); convert it to that version"
        ) from error
    return _element(document)


def _element(source: Any) -> Element:
    """An element of the package as one of ours."""
    found = Element(source.getCategory())
    if source.getParent() is not None:
        found.attributes["name"] = source.getName()
    for name in source.getAttributeNames():
        found.attributes[name] = source.getAttribute(name)
    for child in source.getChildren():
        found.add(_element(child))
    return found
