"""The library of the package `materialx`: definitions of nodes, and graphs that implement them."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from urushi.errors import FileError
from urushi.platform import require_extra

#: The library's files that are read, relative to its folder.
LIBRARY = (
    "stdlib/stdlib_defs.mtlx",
    "stdlib/stdlib_ng.mtlx",
    "bxdf/usd_preview_surface.mtlx",
    "bxdf/standard_surface.mtlx",
    "bxdf/gltf_pbr.mtlx",
    "bxdf/disney_principled.mtlx",
)


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


def of_node(node: Any) -> Any | None:
    """The definition that fits a node best."""
    with _without_cycles(node):
        return node.getNodeDef("", True)


def inputs(definition: Any) -> dict[str, Any]:
    """The inputs of a definition by name, those that it inherits included; raises as `of_node`."""
    with _without_cycles(definition):
        return {element.getName(): element for element in definition.getActiveInputs()}


@contextmanager
def _without_cycles(element: Any) -> Iterator[None]:
    try:
        yield
    except LookupError as error:
        raise FileError(
            f"the definition of '{element.getName()[:60]}' inherits from itself; remove the cycle"
        ) from error


def unit(document: Any, name: str, where: str) -> tuple[str, float]:
    """The kind of a unit, such as distance, and its size in metres or degrees."""
    known = {
        unit.getName(): (units.getUnitType(), unit.getAttribute("scale"))
        for source in (library(), document)
        for units in source.getUnitDefs()
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
