"""Checks of an XML file from an untrusted source, before the package `materialx` reads it."""

from xml.parsers import expat

from urushi.errors import FileError

#: Largest size of a document, of all its included files together [bytes].
MAX_BYTES = 16 << 20

#: Largest number of elements of a document, and of elements inside each other.
MAX_ELEMENTS = 50_000
MAX_DEPTH = 32

#: Bytes that are given to the parser at once.
CHUNK = 1 << 16


class Outline:
    """What a file consists of.

    Attributes:
        version: the attribute of the outermost element, if it has one.
        includes: the included files, in order.
        elements: number of elements.
    """

    def __init__(self, content: bytes, where: str):
        """Parse a file without keeping its elements."""
        self.version: str | None = None
        self.includes: list[str] = []
        self.elements = self._depth = 0
        self._where = where
        parser = expat.ParserCreate()
        parser.StartElementHandler, parser.EndElementHandler = self._start, self._end
        parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = self._refuse
        try:
            for begin in range(0, len(content), CHUNK):
                parser.Parse(content[begin : begin + CHUNK], False)
            parser.Parse(b"", True)
        except (expat.ExpatError, ValueError, LookupError) as error:
            if isinstance(error, FileError):
                raise
            reason = " ".join(str(error).split())
            raise FileError(f"{where} is not valid XML ({reason}); export it again") from error

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        if self._depth == 0:
            if tag != "materialx":
                raise FileError(
                    f"{self._where} is not a MaterialX document: it begins with <{tag[:40]}>"
                )
            self.version = attributes.get("version")
        elif tag in ("xi:include", "include"):
            self.includes.append(attributes.get("href", ""))
        elif not attributes.get("name"):  # thousands of them take the package minutes to name
            raise FileError(f"{self._where} has an element <{tag[:40]}> without a name; name it")
        self.elements += 1
        self._depth += 1
        if self.elements > MAX_ELEMENTS:
            raise FileError(
                f"{self._where} has more than {MAX_ELEMENTS} elements; keep only the material"
            )
        if self._depth > MAX_DEPTH:
            raise FileError(
                f"{self._where} has elements nested more than {MAX_DEPTH} deep, which no MaterialX "
                "document needs"
            )

    def _end(self, tag: str) -> None:
        self._depth -= 1

    def _refuse(self, *_: object) -> None:
        raise FileError(
            f"{self._where} has a document type or entities, which MaterialX does not need and "
            "which can expand without limit; remove the DOCTYPE"
        )
