"""Parsing of XML from untrusted files: no document types or entities, and bounded size."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

from urushi.errors import FileError

#: Largest size of a document, of all its included files together [bytes].
MAX_BYTES = 16 << 20

#: Largest number of elements of a document, and of elements inside each other.
MAX_ELEMENTS = 50_000
MAX_DEPTH = 32

#: Largest number of characters of an attribute.
MAX_CHARACTERS = 1 << 16

#: Bytes that are given to the parser at once.
CHUNK = 1 << 16


@dataclass(eq=False)
class Element:
    """An element of a document.

    Attributes:
        tag: its name, a node's category.
        attributes: by name.
        children: the elements inside, in order.
        parent: the element around it.
    """

    tag: str
    attributes: dict[str, str] = field(default_factory=dict)
    children: list["Element"] = field(default_factory=list)
    parent: "Element | None" = None

    @property
    def name(self) -> str:
        return self.attributes.get("name", "")

    @property
    def type(self) -> str:
        return self.attributes.get("type", "")

    def get(self, attribute: str) -> str | None:
        return self.attributes.get(attribute)

    def inherited(self, attribute: str) -> str | None:
        """The attribute of the element or of the nearest one around it that has it."""
        element: Element | None = self
        while element is not None:
            if attribute in element.attributes:
                return element.attributes[attribute]
            element = element.parent
        return None

    def add(self, child: "Element") -> None:
        child.parent = self
        self.children.append(child)

    def inputs(self) -> Iterator["Element"]:
        return (child for child in self.children if child.tag == "input")

    def input(self, name: str) -> "Element | None":
        return next((child for child in self.inputs() if child.name == name), None)


def parse(content: bytes, where: str) -> Element:
    """The outermost element of a document.

    where: begins errors.

    Raises:
        FileError: the content is no XML, has a document type or entities, or is too large.
    """
    return _Parser(where).parse(content)


class _Parser:
    def __init__(self, where: str):
        self._where = where
        self._root: Element | None = None
        self._open: list[Element] = []
        self._count = 0
        self._expat = expat.ParserCreate()
        self._expat.StartElementHandler = self._start
        self._expat.EndElementHandler = self._end
        self._expat.StartDoctypeDeclHandler = self._refuse_doctype
        self._expat.EntityDeclHandler = self._refuse_doctype

    def parse(self, content: bytes) -> Element:
        if len(content) > MAX_BYTES:
            raise FileError(f"{self._where} is larger than {MAX_BYTES >> 20} MiB; split it")
        try:
            for begin in range(0, len(content), CHUNK):
                self._expat.Parse(content[begin : begin + CHUNK], False)
            self._expat.Parse(b"", True)
        except FileError:
            raise
        except (expat.ExpatError, ValueError, LookupError) as error:
            reason = " ".join(str(error).split())
            raise FileError(
                f"{self._where} is not valid XML ({reason}); export it again"
            ) from error
        assert self._root is not None  # expat refuses a document without an element
        return self._root

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._count += 1
        if self._count > MAX_ELEMENTS:
            raise FileError(
                f"{self._where} has more than {MAX_ELEMENTS} elements; keep only the material"
            )
        if len(self._open) >= MAX_DEPTH:
            raise FileError(
                f"{self._where} has elements nested more than {MAX_DEPTH} deep, which no MaterialX "
                "document needs"
            )
        for name, text in attributes.items():
            if len(text) > MAX_CHARACTERS:
                raise FileError(
                    f"{self._where}: the attribute '{name[:40]}' has {len(text)} characters; at "
                    f"most {MAX_CHARACTERS} are read"
                )
        element = Element(tag, attributes)
        if self._open:
            self._open[-1].add(element)
        else:
            self._root = element
        self._open.append(element)

    def _end(self, tag: str) -> None:
        self._open.pop()

    def _refuse_doctype(self, *_: object) -> None:
        raise FileError(
            f"{self._where} has a document type or entities, which MaterialX does not need and "
            "which can expand without limit; remove the DOCTYPE"
        )


def write(element: Element, indent: str = "") -> str:
    """The text of an element and of all inside it."""
    attributes = "".join(f" {name}={quoteattr(text)}" for name, text in element.attributes.items())
    if not element.children:
        return f"{indent}<{element.tag}{attributes} />\n"
    inside = "".join(write(child, indent + "  ") for child in element.children)
    return f"{indent}<{element.tag}{attributes}>\n{inside}{indent}</{element.tag}>\n"
