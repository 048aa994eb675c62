"""MaterialX documents: reading with includes, upgrading, finding a material, and writing one."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from urushi.errors import FileError, ParameterError
from urushi.files import atomic_write
from urushi.openpbr_surface.materialx.definitions import upgrade
from urushi.openpbr_surface.materialx.images import other_case
from urushi.openpbr_surface.materialx.shaders import SHADERS, TARGET
from urushi.openpbr_surface.materialx.xml import MAX_BYTES, MAX_ELEMENTS, Element, parse, write

#: The version of MaterialX that is read; older documents are upgraded.
VERSION = (1, 39)

#: Largest number of included files.
MAX_INCLUDES = 64

_INCLUDES = ("xi:include", "include")


@dataclass(frozen=True)
class Document:
    """A document with its included files.

    Attributes:
        path: the file.
        root: the outermost element, of version 1.39.
    """

    path: Path
    root: Element

    @property
    def where(self) -> str:
        return f"'{self.path}'"


def read_document(path: str | os.PathLike) -> Document:
    """Read a document and the files that it includes.

    Raises:
        FileError: a file is missing, too large or no MaterialX, lies outside of the document's
            folder, or includes itself.
        PlatformError: an old document is to be upgraded and the package is missing.
    """
    file = Path(path)
    reader = _Reader(file)
    root = reader.read(file, ())
    version = _version(root, f"'{file}'")
    if version > VERSION:
        raise FileError(
            f"'{file}' is of MaterialX {version[0]}.{version[1]}; up to "
            f"{VERSION[0]}.{VERSION[1]} can be read; convert it to that version"
        )
    if version < VERSION:
        root = upgrade(write(root), f"'{file}'")
    return Document(file, root)


class _Reader:
    """Reads a file and its includes, with limits on all together."""

    def __init__(self, file: Path):
        self._folder = file.resolve().parent
        self._bytes = 0
        self._elements = 0
        self._includes = 0

    def read(self, file: Path, around: tuple[Path, ...]) -> Element:
        """The outermost element; around: the files that include this one."""
        where = f"'{file}'"
        root = parse(self._content(file), where)
        if root.tag != "materialx":
            raise FileError(
                f"{where} is not a MaterialX document: it begins with <{root.tag[:40]}>"
            )
        self._elements += _count(root)
        if self._elements > MAX_ELEMENTS:
            raise FileError(
                f"{where} and its includes have more than {MAX_ELEMENTS} elements in total; keep "
                "only the material"
            )
        here = (*around, file.resolve())
        children, root.children = root.children, []
        for child in children:
            if child.tag in _INCLUDES:
                for element in self._included(child, file, here):
                    root.add(element)
            else:
                root.add(child)
        return root

    def _included(self, include: Element, file: Path, here: tuple[Path, ...]) -> list[Element]:
        where = f"'{file}'"
        href = (include.get("href") or "").replace("\\", "/")
        self._includes += 1
        if self._includes > MAX_INCLUDES:
            raise FileError(f"{where} includes more than {MAX_INCLUDES} files")
        try:
            target = (self._folder / href).resolve()
        except (OSError, ValueError, RuntimeError) as error:
            raise FileError(f"{where} includes '{href[:80]}', which is not a path") from error
        if not href or not target.is_relative_to(self._folder):
            raise FileError(
                f"{where} includes '{href[:80]}' outside its folder; copy that file into the folder"
            )
        if target in here:
            raise FileError(f"{where} includes '{href[:80]}', which includes it again")
        root = self.read(target, here)
        if _version(root, f"'{target}'") < VERSION:
            root = upgrade(write(root), f"'{target}'")
        for child in root.children:
            for name in ("colorspace", "fileprefix"):
                if name in root.attributes:
                    child.attributes.setdefault(name, root.attributes[name])
        return root.children

    def _content(self, file: Path) -> bytes:
        try:
            if not file.is_file():
                other = other_case(file)
                cure = "check the path" if other is None else f"'{other}' differs in case only"
                raise FileError(f"there is no MaterialX file '{file}'; {cure}")
            with file.open("rb") as stream:
                content = stream.read(MAX_BYTES + 1 - self._bytes)
        except FileError:
            raise
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise FileError(f"cannot read the MaterialX file '{file}': {reason}") from error
        self._bytes += len(content)
        if self._bytes > MAX_BYTES:
            raise FileError(
                f"'{file}' is larger than {MAX_BYTES >> 20} MiB, with its includes; keep only the "
                "material"
            )
        return content


def _count(root: Element) -> int:
    return 1 + sum(_count(child) for child in root.children)


def _version(root: Element, where: str) -> tuple[int, int]:
    text = root.get("version") or f"{VERSION[0]}.{VERSION[1]}"
    major, _, minor = text.partition(".")
    if not (major.isascii() and major.isdigit() and minor.isascii() and minor.isdigit()):
        raise FileError(f"{where} has version '{text[:40]}'; MaterialX versions look like 1.39")
    if len(major) > 4 or len(minor) > 4 or int(major) < 1:
        raise FileError(f"{where} has version '{text[:40]}'; MaterialX versions look like 1.39")
    return int(major), int(minor)


def materials(document: Document) -> list[Element]:
    """The nodes of the materials, those in node graphs included; if none, of surface shaders.

    Raises:
        FileError: there is neither.
    """
    graphs = (x for x in document.root.children if x.tag == "nodegraph" and not x.get("nodedef"))
    scopes = [document.root, *graphs]
    nodes = [child for scope in scopes for child in scope.children]
    found = [node for node in nodes if node.tag == "surfacematerial"]
    found = found or [node for node in document.root.children if _is_shader(node)]
    found = found or [node for node in nodes if _is_shader(node)]
    if not found:
        raise FileError(
            f"{document.where} has no material; it needs a surfacematerial or a node of type "
            "surfaceshader"
        )
    return found


def find_material(document: Document, name: str | None = None) -> Element:
    """The node of a material, or of a surface shader.

    name: of a material, or of a surface shader; None: the document's only one.

    Raises:
        ParameterError: there is none of this name, or several and no name.
        FileError: the document has no material.
    """
    where, choices = document.where, materials(document)
    shaders = [node for node in document.root.children if _is_shader(node)]
    found = choices if name is None else [x for x in (*choices, *shaders) if x.name == name][:1]
    if len(found) != 1:
        names = ", ".join(node.name[:60] for node in choices[:12])
        more = ", ..." if len(choices) > 12 else ""
        problem = "has several materials" if name is None else f"has no material '{name[:60]}'"
        raise ParameterError(f"{where} {problem}; choose one of {names}{more}")
    return found[0]


def _is_shader(node: Element) -> bool:
    """Whether an element is a surface shader; exporters leave out the type of known ones."""
    if node.tag in ("input", "output", "nodegraph", "nodedef"):
        return False
    return node.type == "surfaceshader" or (not node.type and node.tag in SHADERS)


def write_parameters(
    values: Mapping[str, float | bool | tuple[float, float, float]],
    path: str | os.PathLike,
    name: str = "material",
) -> None:
    """Write constant parameters of OpenPBR as a document.

    Args:
        values: by name; colours in linear sRGB.
        path: the document (.mtlx).
        name: of the material; letters, digits and underscores.

    Raises:
        ParameterError: the name is another one.
        FileError: the file cannot be written.
    """
    if not (name.isascii() and name.isidentifier()):
        raise ParameterError(
            f"the material's name is {name!r}; use letters, digits and underscores"
        )
    root = Element("materialx", {"version": "1.39", "colorspace": "lin_rec709"})
    shader = Element(TARGET, {"name": f"{name}_shader", "type": "surfaceshader"})
    for parameter, value in values.items():
        kind, text = _typed(value)
        shader.add(Element("input", {"name": parameter, "type": kind, "value": text}))
    material = Element("surfacematerial", {"name": name, "type": "material"})
    link = {"name": "surfaceshader", "type": "surfaceshader", "nodename": f"{name}_shader"}
    material.add(Element("input", link))
    root.add(shader)
    root.add(material)
    with atomic_write(path) as temporary:
        temporary.write_text('<?xml version="1.0"?>\n' + write(root), encoding="utf-8")


def _typed(value: float | bool | tuple[float, float, float]) -> tuple[str, str]:
    """MaterialX's type and text of a value."""
    if isinstance(value, bool):
        return "boolean", str(value).lower()
    if isinstance(value, tuple):
        return "color3", ", ".join(repr(x) for x in value)
    return "float", repr(value)
