"""Definitions of nodes and the graphs that implement them, of the document and of the library.

Elements are those of the package `materialx`, which has the library.
"""

from functools import cache
from pathlib import Path
from typing import Any

from urushi.errors import FileError, PlatformError

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


def package() -> Any:
    """The package MaterialX.

    Raises:
        PlatformError: it is not installed.
    """
    try:
        import MaterialX
    except ImportError as error:
        raise PlatformError(
            "MaterialX documents are read by the package materialx, which is missing; install it, "
            "for instance by pip install urushi[materialx]"
        ) from error
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


class Definitions:
    """Definitions of a document, before those of the library."""

    def __init__(self, document: Any):
        self._documents = document, library()

    def find(self, node: Any, category: str, kind: str) -> Any | None:
        """The definition that fits a node's inputs best, for a category and a type; None: none."""
        for document in self._documents:
            fits = [(self._score(d, node, kind), d) for d in document.getMatchingNodeDefs(category)]
            if fits and (best := max(fits, key=lambda fit: fit[0]))[0] >= 0:
                return best[1]
        return None

    def named(self, name: str) -> Any | None:
        return next((d for x in self._documents if (d := x.getNodeDef(name)) is not None), None)

    def graph(self, definition: Any) -> Any | None:
        """The node graph that implements a definition, if any."""
        for document in self._documents:
            for found in document.getMatchingImplementations(definition.getName()):
                if found.getCategory() == "implementation":
                    found = document.getNodeGraph(found.getAttribute("nodegraph"))
                if found is not None:
                    return found
        return None

    def unit(self, name: str, where: str) -> tuple[str, float]:
        """The kind of a unit, such as distance, and its size in metres or degrees.

        Raises:
            FileError: neither the document nor the library defines it.
        """
        known = {
            unit.getName(): (units.getUnitType(), unit.getAttribute("scale"))
            for document in self._documents[::-1]
            for units in document.getUnitDefs()
            for unit in units.getChildren()
        }
        if name not in known:
            names = ", ".join(known)
            raise FileError(f"{where} has a value in '{name[:40]}', an unknown unit; use {names}")
        kind, scale = known[name]
        try:
            return kind, float(scale or 1)
        except ValueError as error:
            raise FileError(f"{where}: the unit '{name[:40]}' has no number as scale") from error

    def inputs(self, definition: Any) -> dict[str, Any]:
        """The inputs of a definition by name, those that it inherits included.

        Raises:
            FileError: definitions inherit from each other in a circle.
        """
        found: dict[str, Any] = {}
        current = definition
        for _ in range(MAX_INHERITANCE):
            for element in current.getInputs():
                found.setdefault(element.getName(), element)
            current = self.named(current.getInheritString())
            if current is None:
                return found
        raise FileError(
            f"the definition '{definition.getName()[:60]}' inherits from itself, or through more "
            f"than {MAX_INHERITANCE} others"
        )

    def _score(self, definition: Any, node: Any, kind: str) -> int:
        """How well a definition fits a node of a type; -1: not at all."""
        if node.getNodeDefString() == definition.getName():
            return 1 << 20
        outputs = [output.getAttribute("type") for output in definition.getOutputs()]
        if kind == "multioutput":
            if len(outputs) < 2:
                return -1
        elif outputs and kind not in ("", *outputs):
            return -1
        inputs = self.inputs(definition)
        score = 1 if definition.getAttribute("isdefaultversion") == "true" else 0
        for element in node.getInputs():
            declared = inputs.get(element.getName())
            if declared is not None:
                same = declared.getAttribute("type") == element.getAttribute("type")
                score += 4 if same else -2
        return max(score, 0)
