"""What all printers share: the structure of a file, and expressions and statements as in C."""

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import ClassVar

import numpy as np

from urushi.export.expressions import BOOL, COLOUR, FLOAT, INT, VECTOR, Expression
from urushi.export.statements import (
    Function,
    Lookup,
    Program,
    Statement,
    Structure,
    Table,
    Variable,
)

#: Columns of a line of the printed file.
WIDTH = 100

_PRECEDENCE = {">": 1, ">=": 1, "+": 2, "-": 2, "*": 3, "/": 3}
_UNARY, PRIMARY = 4, 5


class Printer:
    """A language. Subclasses say what differs from C.

    Attributes:
        title: the language's name in prose.
        usage: sentences at the head of the file on how to include it.
        comment: begins a comment.
        kinds: the languages' names of the kinds of values.
        calls: names of functions that differ from those of `expressions`.
        components: how a vector's and a colour's components are written.
    """

    title: ClassVar[str]
    usage: ClassVar[str]
    comment: ClassVar[str] = "//"
    kinds: ClassVar[Mapping[str, str]]
    calls: ClassVar[Mapping[str, str]] = {}
    components: ClassVar[Sequence[str]] = (".x", ".y", ".z")

    def __init__(self, prefix: str):
        """prefix: begins the names of all functions, structures and tables."""
        self.prefix = prefix

    def printed(self, program: Program) -> str:
        lines = [*self.head(program), ""]
        for structure in program.structures:
            lines += [*self.structure(structure), ""]
        for function in program.functions:
            for table in self.outer_tables(function):
                lines += [*self.table(table), ""]
            lines += [*self.function(function), ""]
        if program.lookup:
            lines += self.lookup(program.lookup)
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

    def table_name(self, label: str) -> str:
        return f"{self.prefix}_{label}"

    def kind(self, kind: str) -> str:
        return self.kinds.get(kind) or self.structure_name(kind)

    # Declarations

    def declared(self, variable: Variable) -> str:
        """A type and a name, as in C."""
        count = "" if variable.count is None else f"[{variable.count}]"
        return f"{self.kind(variable.kind)} {variable.name}{count}"

    #: What ends a field of a structure, and the line that ends the structure.
    field_end: ClassVar[str] = ";"
    structure_end: ClassVar[str] = "};"

    def structure(self, structure: Structure) -> list[str]:
        lines = self.comments(structure.note)
        lines.append(f"struct {self.structure_name(structure.name)} {{")
        for variable in structure.fields:
            note = f"  {self.comment} {variable.note}" if variable.note else ""
            lines.append(f"    {self.declared(variable)}{self.field_end}{note}")
        return [*lines, self.structure_end]

    def outer_tables(self, function: Function) -> Sequence[Table]:
        """The tables of a function that stand before it."""
        return function.tables

    def table(self, table: Table) -> list[str]:
        raise NotImplementedError

    def numbers(self, values: np.ndarray, indent: str = "    ") -> list[str]:
        text = ", ".join(self.number(float(value)) for value in values)
        return textwrap.wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent)

    def function(self, function: Function) -> list[str]:
        lines = self.comments(function.note)
        return [*lines, self.signature(function), *self.body(function.body, "    "), "}"]

    def signature(self, function: Function) -> str:
        arguments = ", ".join(map(self.declared, function.arguments))
        return f"{self.kind(function.kind)} {self.function_name(function.name)}({arguments}) {{"

    def lookup(self, lookup: Lookup) -> list[str]:
        """The functions that read a texture: with the level of the footprint, and a given one."""
        lines: list[str] = []
        for label, extra, note in (
            ("fetch", None, "The material at uv; the footprint chooses the level."),
            ("fetch_level", "level", "The material at uv, of a given level."),
        ):
            lines += self.comments(note)
            lines += self.fetch(lookup, self.function_name(label), extra)
            lines.append("")
        return lines

    def fetch(self, lookup: Lookup, label: str, level: str | None) -> list[str]:
        """A function `label` that reads a texture; level: the name of an argument, or None."""
        head, declared, sample = self.fetched(lookup, label, level)
        name = self.function_name(lookup.function.name)
        loop = self.loop_head("layer", lookup.layers)
        bytes_ = Variable("stored", FLOAT, 4 * lookup.layers)
        return [
            head,
            f"    {self.empty(bytes_)}",
            f"    {declared} = {self.placed(lookup)};",
            f"    {loop}",
            f"        {sample};",
            *(f"        stored[4 * layer + {i}] = four.{c};" for i, c in enumerate("xyzw")),
            "    }",
            f"    return {name}(stored);",
            "}",
        ]

    def fetched(self, lookup: Lookup, label: str, level: str | None) -> tuple[str, str, str]:
        """The first line of `fetch`, the declaration of `place`, and that of `four` bytes."""
        raise NotImplementedError

    #: The name of two floats.
    two: ClassVar[str] = "vec2"

    def placed(self, lookup: Lookup) -> str:
        """The texture's coordinates of uv."""
        rows = []
        for row in lookup.to_texture:
            u, v, offset = (self.number(value) for value in row)
            rows.append(f"{u} * uv.x + {v} * uv.y + {offset}")
        plain = np.array_equal(lookup.to_texture, np.eye(2, 3))
        return "uv" if plain else f"{self.two}({', '.join(rows)})"

    # Statements

    def body(self, statements: Iterable[Statement], indent: str) -> list[str]:
        lines: list[str] = []
        for statement in statements:
            if statement.operation == "loop":
                lines.append(indent + self.loop_head(str(statement.target), statement.count))
                lines += self.body(statement.body, indent + "    ")
                lines += [indent + line for line in self.loop_end]
            else:
                lines += self.wrapped(indent + self.statement(statement))
        return lines

    def statement(self, statement: Statement) -> str:
        """A statement, except a loop, in one line."""
        operation, target, value = statement.operation, statement.target, statement.value
        if operation == "note":
            return f"{self.comment} {target}"
        if operation == "let":
            return self.let(target, self.text(value))  # type: ignore[arg-type]
        if operation in ("array", "structure"):
            return self.empty(target)  # type: ignore[arg-type]
        if operation == "assign":
            return f"{self.text(target)} = {self.text(value)}{self.end}"  # type: ignore[arg-type]
        return f"return {self.text(value)}{self.end}"  # type: ignore[arg-type]

    #: What ends a statement, and the lines that end a loop.
    end: ClassVar[str] = ";"
    loop_end: ClassVar[Sequence[str]] = ("}",)

    def loop_head(self, counter: str, count: int) -> str:
        return f"for (int {counter} = 0; {counter} < {count}; ++{counter}) {{"

    def wrapped(self, line: str) -> list[str]:
        """A line of code, broken at spaces if it is too long; comments stay as they are."""
        stripped = line.lstrip()
        if len(line) <= WIDTH or stripped.startswith(self.comment):
            return [line]
        indent = " " * (len(line) - len(stripped))
        return broken(stripped, indent, indent + "    ")

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
        operation, arguments, detail = value.operation, value.arguments, value.detail
        if operation == "constant":
            if value.kind == COLOUR:
                return self.colour([float(x) for x in detail]), PRIMARY
            number = self.number(float(detail))
            return number, _UNARY if number.startswith("-") else PRIMARY
        if operation in _PRECEDENCE:
            return self._binary(operation, *arguments), _PRECEDENCE[operation]
        texts = [self.text(argument) for argument in arguments]
        if operation in ("name", "integer"):
            return str(detail), PRIMARY
        if operation == "table":
            return self.table_name(detail), PRIMARY
        if operation == "call":
            return f"{self.calls.get(detail, detail)}({', '.join(texts)})", PRIMARY
        if operation == "invoke":
            return f"{self.function_name(detail)}({', '.join(texts)})", PRIMARY
        if operation == "select":
            return self.selected(*texts), PRIMARY
        if operation == "component":
            return f"{self._primary(arguments[0])}{self.components[detail]}", PRIMARY
        if operation == "field":
            return f"{self._primary(arguments[0])}.{detail}", PRIMARY
        if operation == "element":
            return f"{self._primary(arguments[0])}[{texts[1]}]", PRIMARY
        if operation == "vector":
            return self.vector(texts), PRIMARY
        if operation == "channels":
            return self.channels(texts), PRIMARY
        return self.splat(texts[0]), PRIMARY

    def _primary(self, value: Expression) -> str:
        text, binding = self._precise(value)
        return text if binding == PRIMARY else f"({text})"

    def _binary(self, sign: str, a: Expression, b: Expression) -> str:
        level = _PRECEDENCE[sign]
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

    def colour(self, values: Sequence[float]) -> str:
        return f"{self.kinds[COLOUR]}({', '.join(map(self.number, values))})"

    def vector(self, components: Sequence[str]) -> str:
        return f"{self.kinds[VECTOR]}({', '.join(components)})"

    def channels(self, values: Sequence[str]) -> str:
        return f"{self.kinds[COLOUR]}({', '.join(values)})"

    def splat(self, value: str) -> str:
        return f"{self.kinds[COLOUR]}({value})"

    def selected(self, condition: str, yes: str, no: str) -> str:
        return f"({condition} ? {yes} : {no})"


def c_kinds(three: str, boolean: str = "bool") -> dict[str, str]:
    """The kinds of a language whose three floats are called `three`."""
    return {FLOAT: "float", COLOUR: three, VECTOR: three, BOOL: boolean, INT: "int"}


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
