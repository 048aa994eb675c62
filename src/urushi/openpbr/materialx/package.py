"""The package `materialx`: its libraries' folder, and the upgrade of old documents."""

from importlib.util import find_spec
from pathlib import Path
from typing import Any

from urushi.errors import FileError, PlatformError
from urushi.openpbr.materialx.xml import Element


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
