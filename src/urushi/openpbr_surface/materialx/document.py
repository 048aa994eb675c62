"""MaterialX documents: reading with includes, finding a material, and writing one."""

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from html import unescape
from pathlib import Path
from typing import Any

from urushi.errors import FileError, ParameterError
from urushi.files import as_path, atomic_write
from urushi.openpbr_surface.materialx.graph import package
from urushi.openpbr_surface.materialx.images import path_cure
from urushi.openpbr_surface.materialx.shaders import SHADERS, TARGET

#: The version of MaterialX that is read; older documents are upgraded.
VERSION = (1, 39)

#: Largest number of included files.
MAX_INCLUDES = 64

#: Largest size of a document, of all its included files together [bytes].
MAX_BYTES = 16 << 20

#: Largest number of elements of a document.
MAX_ELEMENTS = 50_000

#: A comment, or a tag with its attributes; either may lack its end.
_MARKUP = re.compile(r"""<!--.*?(?:-->|\Z)|<(?:[^"'<>]|"[^"]*"?|'[^']*'?)*+>?""", re.DOTALL)

#: An attribute of a tag: its name, and its text in quotes.
_ATTRIBUTE = re.compile(r"""([\w:]+)\s*=\s*("[^"]*"|'[^']*')""")


@dataclass(frozen=True)
class Document:
    """A document with its included files."""

    path: Path
    root: Any  # the document of the package, of version 1.39

    @property
    def where(self) -> str:
        return f"'{self.path}'"


def read_document(path: str | os.PathLike) -> Document:
    """Read a document and the files that it includes."""
    file = as_path(path)
    return Document(file, _Reader(file).read(file, ()))


class _Reader:
    """Reads a file and its includes, with limits on all together."""

    def __init__(self, file: Path):
        self._folder = file.resolve().parent
        self._bytes = 0
        self._elements = 0
        self._includes = 0

    def read(self, file: Path, around: tuple[Path, ...]) -> Any:
        """The package's document; around: the files that include this one."""
        where = f"'{file}'"
        text, includes = self._tags(self._content(file), where)
        mx = package()
        root, options = mx.createDocument(), mx.XmlReadOptions()
        options.readXIncludeFunction = None
        try:
            mx.readFromXmlString(root, text, mx.FileSearchPath(), options)
        except (mx.Exception, mx.ExceptionParseError, RuntimeError, LookupError) as error:
            reason = " ".join(str(error).split())[:200]
            raise FileError(
                f"{where} is refused by the package materialx ({reason}); export it again"
            ) from error
        _check_version(root.getVersionString(), where)
        for node in root.traverseTree():  # exporters leave out the type of known shaders
            if node.getCategory() in SHADERS and not node.getAttribute("type"):
                node.setAttribute("type", "surfaceshader")
        here = (*around, file.resolve())
        for href in includes:
            root.importLibrary(self._included(href, where, here))
        return root

    def _tags(self, text: str, where: str) -> tuple[str, list[str]]:
        """The tags of a file, with spaces in place of all else, and the files that it includes.

        The package would take minutes to name thousands of texts, or of elements without a name.
        """
        pieces: list[str] = []
        includes, end = [], 0
        for match in _MARKUP.finditer(text):
            tag = match[0]
            if tag.startswith(("<!", "<?")):
                continue
            kind = re.split(r"[\s/>]", tag[1:], maxsplit=1)[0]
            if not pieces and kind != "materialx":
                raise FileError(
                    f"{where} is not a MaterialX document: it begins with <{kind[:40]}>"
                )
            pieces += [" " * (match.start() - end), tag]
            end = match.end()
            if tag.startswith("</"):
                continue
            self._elements += 1
            if self._elements > MAX_ELEMENTS:
                raise FileError(
                    f"{where} has more than {MAX_ELEMENTS} elements, with its includes; keep only "
                    "the material"
                )
            given = {key: unescape(value[1:-1]) for key, value in _ATTRIBUTE.findall(tag)}
            if kind in ("xi:include", "include"):
                includes.append(given.get("href", ""))
            elif kind != "materialx" and not given.get("name"):
                raise FileError(f"{where} has an element <{kind[:40]}> without a name; name it")
        return "".join(pieces), includes

    def _included(self, href: str, where: str, here: tuple[Path, ...]) -> Any:
        self._includes += 1
        if self._includes > MAX_INCLUDES:
            raise FileError(f"{where} includes more than {MAX_INCLUDES} files")
        try:
            target = (self._folder / href.replace("\\", "/")).resolve()
        except (OSError, ValueError, RuntimeError) as error:
            raise FileError(f"{where} includes '{href[:80]}', which is not a path") from error
        if not href or not target.is_relative_to(self._folder):
            raise FileError(
                f"{where} includes '{href[:80]}' outside its folder; copy that file into the folder"
            )
        if target in here:
            raise FileError(f"{where} includes '{href[:80]}', which includes it again")
        return self.read(target, here)

    def _content(self, file: Path) -> str:
        try:
            if not file.is_file():
                raise FileError(f"there is no MaterialX file '{file}'; {path_cure(file)}")
            with file.open("rb") as stream:
                content = stream.read(MAX_BYTES + 1 - self._bytes)
            self._bytes += len(content)
            if self._bytes > MAX_BYTES:
                raise FileError(
                    f"'{file}' is larger than {MAX_BYTES >> 20} MiB, with its includes; keep only "
                    "the material"
                )
            return content.decode()
        except FileError:
            raise
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise FileError(f"cannot read the MaterialX file '{file}': {reason}") from error


def _check_version(text: str, where: str) -> None:
    """Refuse a version that is none, or newer than `VERSION`."""
    newest = f"{VERSION[0]}.{VERSION[1]}"
    major, _, minor = text.partition(".")
    if not all(x.isascii() and x.isdigit() and len(x) <= 4 for x in (major, minor)):
        raise FileError(f"{where} has version '{major[:40]}'; MaterialX versions look like 1.39")
    if (int(major), int(minor)) > VERSION:
        raise FileError(
            f"{where} is of MaterialX {major}.{minor}; up to {newest} can be read; convert it to "
            "that version"
        )


def materials(document: Document) -> list[Any]:
    """The nodes of materials, also inside of node graphs; if none, of surface shaders."""
    root = document.root
    graphs = (graph for graph in root.getNodeGraphs() if not graph.getNodeDefString())
    nodes = [node for scope in (root, *graphs) for node in scope.getNodes()]
    found = [node for node in nodes if node.getCategory() == "surfacematerial"]
    found = found or [node for node in root.getNodes() if _is_shader(node)]
    found = found or [node for node in nodes if _is_shader(node)]
    if not found:
        raise FileError(
            f"{document.where} has no material; it needs a surfacematerial or a node of type "
            "surfaceshader"
        )
    return found


def find_material(document: Document, name: str | None = None) -> Any:
    """The node of a material, or of a surface shader.

    name: of a material, or of a surface shader; None: the document's only one.
    """
    where, choices = document.where, materials(document)
    shaders = [node for node in document.root.getNodes() if _is_shader(node)]
    found = (
        choices if name is None else [x for x in (*choices, *shaders) if x.getName() == name][:1]
    )
    if len(found) != 1:
        names = ", ".join(node.getName()[:60] for node in choices[:12])
        more = ", ..." if len(choices) > 12 else ""
        problem = "has several materials" if name is None else f"has no material '{name[:60]}'"
        raise ParameterError(f"{where} {problem}; choose one of {names}{more}")
    return found[0]


def _is_shader(node: Any) -> bool:
    return node.getAttribute("type") == "surfaceshader"


def write_parameters(
    values: Mapping[str, float | bool | tuple[float, float, float]],
    path: str | os.PathLike,
    name: str = "material",
) -> None:
    """Write constant parameters of OpenPBR as a document; see `description.save_materialx`.

    values: by name; colours in linear sRGB.
    """
    if not (name.isascii() and name.isidentifier()):
        raise ParameterError(
            f"the material's name is {name!r}; use letters, digits and underscores"
        )
    inputs = "".join(
        '    <input name="{}" type="{}" value="{}" />\n'.format(parameter, *_typed(value))
        for parameter, value in values.items()
    )
    text = f"""<?xml version="1.0"?>
<materialx version="1.39" colorspace="lin_rec709">
  <{TARGET} name="{name}_shader" type="surfaceshader">
{inputs}  </{TARGET}>
  <surfacematerial name="{name}" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="{name}_shader" />
  </surfacematerial>
</materialx>
"""
    with atomic_write(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def _typed(value: float | bool | tuple[float, float, float]) -> tuple[str, str]:
    """MaterialX's type and text of a value."""
    if isinstance(value, bool):
        return "boolean", str(value).lower()
    if isinstance(value, tuple):
        return "color3", ", ".join(repr(x) for x in value)
    return "float", repr(value)
