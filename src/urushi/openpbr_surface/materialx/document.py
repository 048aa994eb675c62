"""MaterialX documents: reading with includes, finding a material, and writing one."""

import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from urushi.errors import FileError, ParameterError
from urushi.files import as_path, atomic_write
from urushi.openpbr_surface.materialx.graph import package
from urushi.openpbr_surface.materialx.images import path_cure
from urushi.openpbr_surface.materialx.shaders import SHADERS, TARGET

#: Largest number of included files.
MAX_INCLUDES = 64

#: Largest size of a document, of all its included files together [bytes].
MAX_BYTES = 16 << 20

#: Largest number of elements of a document.
MAX_ELEMENTS = 50_000

#: A comment, a tag with its attributes, either of which may lack its end, or the text between.
_PIECE = re.compile(r"""<!--.*?(?:-->|\Z)|<(?:[^"'<>]|"[^"]*"?|'[^']*'?)*+>?|[^<]+""", re.DOTALL)

#: An attribute of a tag: its name, a quotation mark, and its text.
_ATTRIBUTE = re.compile(r"""([\w:]+)\s*=\s*(["'])(.*?)\2""", re.DOTALL)


def read_document(path: str | os.PathLike) -> Any:
    """Read a document, upgraded to the package's version, with the files that it includes."""
    file, mx = as_path(path), package()
    root, options = mx.createDocument(), mx.XmlReadOptions()
    reader = _Reader(file)
    options.readXIncludeFunction = reader.include
    reader.read(root, file, options)
    root.setSourceUri(str(file))
    return root


class _Reader:
    """Reads a file and its includes, with limits on all together."""

    def __init__(self, file: Path):
        self._folder = Path(os.path.realpath(file)).parent
        self._open: list[Path] = []  # the file that is read, after those that include it
        self._bytes = self._elements = self._includes = 0

    def read(self, root: Any, file: Path, options: Any) -> None:
        """Read a file into a document of the package."""
        where, mx, text = f"'{file}'", package(), self._content(file)
        self._open.append(file)
        if not re.search(r"<materialx[\s/>]", text):
            raise FileError(f"{where} is not a MaterialX document: it has no element <materialx>")
        # The package would take minutes to name thousands of texts.
        tags = _PIECE.sub(lambda piece: self._tag(piece[0], where), text)
        try:
            mx.readFromXmlString(root, tags, mx.FileSearchPath(), options)
            version = root.getVersionIntegers()
        except (mx.Exception, mx.ExceptionParseError, RuntimeError, LookupError) as error:
            reason = " ".join(str(error).split())[:200]
            raise FileError(
                f"{where} is refused by the package materialx ({reason}); export it again"
            ) from error
        given, newest = root.getVersionString()[:40], mx.getVersionIntegers()[:2]
        if version == (0, 0):
            raise FileError(f"{where} has version '{given}'; MaterialX versions look like 1.39")
        if version > newest:
            raise FileError(
                f"{where} is of MaterialX {given}; up to {newest[0]}.{newest[1]} can be read; "
                "convert it to that version"
            )
        for node in root.traverseTree():
            if node.hasInheritanceCycle():
                raise FileError(
                    f"{where}: '{node.getName()[:60]}' inherits from itself; remove the cycle"
                )
            # Exporters leave out the type of known shaders.
            if node.getCategory() in SHADERS and not node.getAttribute("type"):
                node.setAttribute("type", "surfaceshader")
        self._open.pop()

    def include(self, root: Any, path: Any, _: Any, options: Any) -> None:
        """Read an included file, as the package asks for it; circles are refused by the package.

        As in MaterialX, its path is relative to the file that includes it, or else to the document.
        """
        href, where = path.asString(), f"'{self._open[-1]}'"
        self._includes += 1
        if self._includes > MAX_INCLUDES:
            raise FileError(f"{where} includes more than {MAX_INCLUDES} files")
        folders = Path(os.path.realpath(self._open[-1])).parent, self._folder
        near, target = (Path(os.path.realpath(folder / href)) for folder in folders)
        target = near if near.is_file() else target
        if not target.is_relative_to(self._folder):
            raise FileError(
                f"{where} includes '{href[:80]}' outside its folder; copy that file into the folder"
            )
        self.read(root, target, options)

    def _tag(self, piece: str, where: str) -> str:
        """A tag after checks, or spaces in place of a text, a comment or a declaration."""
        if not piece.startswith("<") or piece.startswith(("<!", "<?")):
            return " " * len(piece)
        if piece.startswith("</"):
            return piece
        self._elements += 1
        if self._elements > MAX_ELEMENTS:
            raise FileError(
                f"{where} has more than {MAX_ELEMENTS} elements, with its includes; keep only "
                "the material"
            )
        kind = re.split(r"[\s/>]", piece[1:], maxsplit=1)[0]
        named = any(name == "name" and value for name, _, value in _ATTRIBUTE.findall(piece))
        if not named and kind not in ("materialx", "xi:include"):
            raise FileError(f"{where} has an element <{kind[:40]}> without a name; name it")
        return piece

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


def materials(root: Any) -> tuple[list[Any], list[Any]]:
    """The nodes of a document's materials, also in node graphs, and the shaders beside them.

    Shaders are materials if the document has no other.
    """
    graphs = (graph for graph in root.getNodeGraphs() if not graph.getNodeDefString())
    nodes = [node for scope in (root, *graphs) for node in scope.getNodes()]
    every = [node for node in nodes if node.getAttribute("type") == "surfaceshader"]
    shaders = [node for node in every if node.getParent() == root]
    named = [node for node in nodes if node.getCategory() == "surfacematerial"]
    return named or shaders or every, shaders


def find_material(root: Any, name: str | None = None) -> Any:
    """The node of a document's material or of a surface shader (`materials`).

    name: None: the document's only material, or its only shader if it has no material.
    """
    where, (choices, shaders) = f"'{root.getSourceUri()}'", materials(root)
    if not choices:
        raise FileError(
            f"{where} has no material; it needs a surfacematerial or a node of type surfaceshader"
        )
    found = (
        choices if name is None else [x for x in (*choices, *shaders) if x.getName() == name][:1]
    )
    if len(found) != 1:
        names = ", ".join(node.getName()[:60] for node in choices[:12])
        more = ", ..." if len(choices) > 12 else ""
        problem = "has several materials" if name is None else f"has no material '{name[:60]}'"
        raise ParameterError(f"{where} {problem}; choose one of {names}{more}")
    return found[0]


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
    kinds = {bool: "boolean", tuple: "color3"}
    inputs = "".join(
        f'    <input name="{parameter}" type="{kinds.get(type(value), "float")}" '
        f'value="{str(value).lower().strip("()")}" />\n'
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
