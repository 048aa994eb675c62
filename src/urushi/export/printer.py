"""The base of all printers: the structure of a file, and expressions and statements as in C."""

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import ClassVar

import numpy as np

from urushi.export.expressions import BOOL, COLOUR, FLOAT, INT, TEXEL, TEXTURE, VECTOR, Expression
from urushi.export.rest import TextureForm
from urushi.export.statements import (
    Function,
    Program,
    Statement,
    Structure,
    Texels,
    Variable,
)

#: Columns of a line of the printed file.
WIDTH = 100

_PRECEDENCE = {">": 1, ">=": 1, "+": 2, "-": 2, "*": 3, "/": 3}
_UNARY, PRIMARY = 4, 5


class Printer:
    """A language. Subclasses say what differs from C."""

    title: ClassVar[str]  # the language's name in prose
    usage: ClassVar[str]  # sentences at the head of the file on how to include it
    comment: ClassVar[str] = "//"  # begins a comment
    kinds: ClassVar[Mapping[str, str]]  # the language's names of the kinds of values
    calls: ClassVar[Mapping[str, str]] = {}  # names of functions that differ from `expressions`
    components: ClassVar[Sequence[str]] = (".x", ".y", ".z", ".w")  # of a vector, colour or texel
    rgb: ClassVar[str] = ".rgb"  # the first three of a texel
    field_end: ClassVar[str] = ";"  # ends a field of a structure
    structure_end: ClassVar[str] = "};"
    end: ClassVar[str] = ";"  # ends a statement
    two: ClassVar[str] = "vec2"  # the name of two floats
    fetch_head: ClassVar[str]  # the first line of a function that reads a texture
    level: ClassVar[str] = ", float level"  # further argument of a function for a given level
    place: ClassVar[str] = "vec2 place"  # declares the texture's coordinates
    sample: ClassVar[str]  # declares four bytes, by the footprint
    sample_level: ClassVar[str]  # and of a given level
    form: ClassVar[TextureForm] = TextureForm()
    texture: ClassVar[str]  # the argument that is a texture of `form`
    texel: ClassVar[str]  # and its filtered texel at a place

    def __init__(self, prefix: str):
        """prefix: begins the names of all functions, structures and tables."""
        self.prefix = prefix

    def printed(self, program: Program) -> str:
        lines = [*self.head(program), ""]
        for structure in program.structures:
            lines += [*self.structure(structure), ""]
        for function in program.functions:
            lines += [*self.function(function), ""]
        if program.texels:
            lines += self.lookup(program.texels, program.functions[-1])
        return "\n".join(lines).rstrip("\n") + "\n"

    def head(self, program: Program) -> list[str]:
        """The comment at the head of the file."""
        names = {label: self.function_name(label) for label in program.public}
        lines: list[str] = []
        for paragraph in (*program.note, self.usage):
            lines += [*self.comments(paragraph.format(**names)), self.comment]
        return lines[:-1]

    def comments(self, text: str) -> list[str]:
        return [f"{self.comment} {line}" for line in textwrap.wrap(text, WIDTH - 10)]

    # Names

    def function_name(self, label: str) -> str:
        return f"{self.prefix}_{label}"

    def structure_name(self, label: str) -> str:
        return self.prefix.replace("_", " ").title().replace(" ", "") + label

    def kind(self, kind: str) -> str:
        return self.kinds.get(kind) or self.structure_name(kind)

    # Declarations

    def declared(self, variable: Variable) -> str:
        """A type and a name, as in C."""
        if variable.kind == TEXTURE:
            return self.texture.format(name=variable.name)
        count = "" if variable.count is None else f"[{variable.count}]"
        return f"{self.kind(variable.kind)} {variable.name}{count}"

    def structure(self, structure: Structure) -> list[str]:
        lines = self.comments(structure.note)
        lines.append(f"struct {self.structure_name(structure.name)} {{")
        for variable in structure.fields:
            note = f"  {self.comment} {variable.note}" if variable.note else ""
            lines.append(f"    {self.declared(variable)}{self.field_end}{note}")
        return [*lines, self.structure_end]

    def function(self, function: Function) -> list[str]:
        head = [*self.comments(function.note), self.signature(function)]
        return [*head, *self.body(function.body, "    "), "}"]

    def signature(self, function: Function) -> str:
        arguments = ", ".join(map(self.declared, function.arguments))
        return f"{self.kind(function.kind)} {self.function_name(function.name)}({arguments}) {{"

    def lookup(self, texels: Texels, function: Function) -> list[str]:
        """The functions that read a texture: with the level of the footprint, and a given one."""
        kind, name = self.kind(function.kind), self.function_name(function.name)
        place = "uv"
        if not np.array_equal(texels.to_texture, np.eye(2, 3)):
            rows = (map(self.number, row) for row in texels.to_texture)
            texts = (f"{u} * uv.x + {v} * uv.y + {offset}" for u, v, offset in rows)
            place = f"{self.two}({', '.join(texts)})"
        forms = (
            ("fetch", "", self.sample, "The material at uv; the footprint chooses the level."),
            ("fetch_level", self.level, self.sample_level, "The material at uv, of a given level."),
        )
        lines: list[str] = []
        for label, level, sample, note in forms:
            label = self.function_name(label)
            lines += [
                *self.comments(note),
                self.fetch_head.format(kind=kind, label=label, level=level),
                f"    {self.empty(Variable('stored', FLOAT, 4 * texels.layers))}",
                f"    {self.place} = {place};",
                f"    {self.loop_head('layer', texels.layers)}",
                f"        {sample};",
                *(f"        stored[4 * layer + {i}] = four.{c};" for i, c in enumerate("xyzw")),
                "    }",
                f"    return {name}(stored);",
                "}",
                "",
            ]
        return lines

    # Statements

    def body(self, statements: Iterable[Statement], indent: str) -> list[str]:
        lines: list[str] = []
        for statement in statements:
            lines += self.wrapped(indent + self.statement(statement))
        return lines

    def statement(self, statement: Statement) -> str:
        """A statement in one line."""
        target, value = statement.target, statement.value
        match statement.operation:
            case "note":
                return f"{self.comment} {target}"
            case "let":
                return self.let(target, self.text(value))
            case "array" | "structure":
                return self.empty(target)
            case "assign":
                return f"{self.text(target)} = {self.text(value)}{self.end}"
        return f"return {self.text(value)}{self.end}"

    def loop_head(self, counter: str, count: int) -> str:
        return f"for (int {counter} = 0; {counter} < {count}; ++{counter}) {{"

    def wrapped(self, line: str) -> list[str]:
        """A line of code, broken at spaces if it is too long; comments stay as they are."""
        stripped = line.lstrip()
        if len(line) <= WIDTH or stripped.startswith(self.comment):
            return [line]
        return self.split(stripped, " " * (len(line) - len(stripped)))

    def split(self, code: str, indent: str) -> list[str]:
        """A line of code, without its indent, as several."""
        return broken(code, indent, indent + "    ")

    def let(self, variable: Variable, value: str) -> str:
        return f"{self.declared(variable)} = {value};"

    def empty(self, variable: Variable) -> str:
        """An array or a structure without values."""
        return f"{self.declared(variable)};"

    # Expressions

    def text(self, value: Expression) -> str:
        return self._precise(value)[0]

    def _precise(self, value: Expression) -> tuple[str, int]:
        """An expression and how tightly its last operation binds."""
        arguments, detail = value.arguments, value.detail
        if level := _PRECEDENCE.get(value.operation):
            return self._binary(value.operation, level, *arguments), level
        texts = [self.text(argument) for argument in arguments]
        match value.operation:
            case "constant" if value.kind == COLOUR:
                text = self.composed(COLOUR, [self.number(float(x)) for x in detail])
            case "constant":
                text = self.number(float(detail))
                if text.startswith("-"):
                    return text, _UNARY
            case "name" | "integer":
                text = str(detail)
            case "call":
                text = f"{self.calls.get(detail, detail)}({', '.join(texts)})"
            case "texel":
                text = self.texel.format(*texts)
            case "invoke":
                text = f"{self.function_name(detail)}({', '.join(texts)})"
            case "select":
                text = self.selected(*texts)
            case "component":
                text = self._primary(arguments[0]) + self.components[detail]
            case "colour":
                text = self._primary(arguments[0]) + self.rgb
            case "field":
                text = f"{self._primary(arguments[0])}.{detail}"
            case "element":
                text = f"{self._primary(arguments[0])}[{texts[1]}]"
            case "vector" | "channels":
                text = self.composed(value.kind, texts)
            case _:
                text = self.splat(texts[0])
        return text, PRIMARY

    def _primary(self, value: Expression) -> str:
        text, binding = self._precise(value)
        return text if binding == PRIMARY else f"({text})"

    def _binary(self, sign: str, level: int, a: Expression, b: Expression) -> str:
        if sign == "+" and b.kind == FLOAT and b.constant is not None and b.constant < 0:
            sign, b = "-", Expression("constant", FLOAT, detail=-b.constant)
        left, left_level = self._precise(a)
        right, right_level = self._precise(b)
        if left_level < level:
            left = f"({left})"
        # a + (b + c) keeps its parentheses: it is rounded otherwise than (a + b) + c.
        if right_level <= level or right.startswith("-"):
            right = f"({right})"
        return f"{left} {sign} {right}"

    def number(self, value: float) -> str:
        """The shortest decimal number that reads back as the same float32."""
        single = np.float32(value)
        if single == 0.0 or 1e-4 <= abs(single) < 1e7:
            return np.format_float_positional(single, unique=True, trim="0")
        return np.format_float_scientific(single, unique=True, trim="0", exp_digits=1)

    def composed(self, kind: str, parts: Sequence[str]) -> str:
        """A colour or a vector of three floats."""
        return f"{self.kinds[kind]}({', '.join(parts)})"

    def splat(self, value: str) -> str:
        return f"{self.kinds[COLOUR]}({value})"

    def selected(self, condition: str, yes: str, no: str) -> str:
        return f"({condition} ? {yes} : {no})"


def kinds(
    three: str, four: str, number: str = "float", whole: str = "int", truth: str = "bool"
) -> dict:
    """The kinds of a language by its names of 3 floats, 4, a float, an integer and a bool."""
    return {FLOAT: number, COLOUR: three, VECTOR: three, TEXEL: four, BOOL: truth, INT: whole}


def broken(text: str, first: str, further: str) -> list[str]:
    """Lines of a text, broken at spaces, with the indents of the first and the further ones."""
    return textwrap.wrap(
        text,
        WIDTH,
        initial_indent=first,
        subsequent_indent=further,
        break_long_words=False,
        break_on_hyphens=False,
    )
