"""The base of all printers: the structure of a file, and expressions and statements as in C."""

import textwrap
from collections.abc import Iterable, Mapping, Sequence
from typing import ClassVar

import numpy as np

from urushi.export.expressions import (
    BOOL,
    COLOUR,
    FLOAT,
    INT,
    LAYERS,
    PLACE,
    TEXEL,
    TEXTURE,
    VECTOR,
    Expression,
)
from urushi.export.rest import TextureForm
from urushi.export.statements import Function, Program, Statement, Structure, Variable

#: Columns of a line of the printed file.
WIDTH = 100

_PRECEDENCE = {">": 1, ">=": 1, "+": 2, "-": 2, "*": 3, "/": 3}
_UNARY, PRIMARY = 4, 5


class Printer:
    """A language. Subclasses say what differs from C."""

    title: ClassVar[str]  # the language's name in prose
    usage: ClassVar[str]  # sentences at the head of the file on how to include it
    comment: ClassVar[str] = "//"  # begins a comment
    kinds: ClassVar[Mapping[str, str]] = {}  # the language's names of the kinds of values
    calls: ClassVar[Mapping[str, str]] = {}  # names of functions that differ from `expressions`
    components: ClassVar[Sequence[str]] = (".x", ".y", ".z", ".w")  # of a vector, colour or texel
    rgb: ClassVar[str] = ".rgb"  # the first three of a texel
    structure_end: ClassVar[str] = "};"
    end: ClassVar[str] = ";"  # ends a statement
    # How declarations are written: of variables and arrays, and of textures by their kinds (without
    # "layers", the language reads none); the head of a function, a field of a structure, a constant
    # and a variable without a value. How operations of `expressions` are, by their operands:
    # "select", "splat", "texel" and "layer".
    forms: ClassVar[dict[str, str]] = {
        "variable": "{kind} {name}",
        "array": "{kind} {name}[{count}]",
        "function": "{kind} {name}({arguments}) {{",
        "field": "{};",
        "let": "{declared} = {value};",
        "empty": "{};",
        "select": "({} ? {} : {})",
    }
    form: ClassVar[TextureForm] = TextureForm()  # of textures

    def __init__(self, prefix: str):
        """prefix: begins the names of all functions, structures and tables."""
        self.prefix = prefix

    def printed(self, program: Program) -> str:
        lines = [*self.head(program), ""]
        for structure in program.structures:
            lines += [*self.structure(structure), ""]
        for function in program.functions:
            lines += [*self.function(function), ""]
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
        """A type and a name."""
        if variable.kind in (TEXTURE, LAYERS):
            return self.forms[variable.kind].format(variable.name)
        form = self.forms["variable" if variable.count is None else "array"]
        kind = self.kind(variable.kind)
        return form.format(kind=kind, name=variable.name, count=variable.count)

    def structure(self, structure: Structure) -> list[str]:
        lines = self.comments(structure.note)
        lines.append(f"struct {self.structure_name(structure.name)} {{")
        for variable in structure.fields:
            note = f"  {self.comment} {variable.note}" if variable.note else ""
            lines.append(f"    {self.forms['field'].format(self.declared(variable))}{note}")
        return [*lines, self.structure_end]

    def function(self, function: Function) -> list[str]:
        head = [*self.comments(function.note), self.signature(function)]
        return [*head, *self.body(function.body), "}"]

    def signature(self, function: Function) -> str:
        arguments = ", ".join(map(self.declared, function.arguments))
        kind, name = self.kind(function.kind), self.function_name(function.name)
        return self.forms["function"].format(kind=kind, name=name, arguments=arguments)

    # Statements

    def body(self, statements: Iterable[Statement]) -> list[str]:
        return [line for x in statements for line in self.wrapped(f"    {self.statement(x)}")]

    def statement(self, statement: Statement) -> str:
        """A statement in one line."""
        target, value = statement.target, statement.value
        match statement.operation:
            case "note":
                return f"{self.comment} {target}"
            case "let":
                return self.let(target, self.text(value))
            case "declare":
                return self.empty(target)
            case "assign":
                return f"{self.text(target)} = {self.text(value)}{self.end}"
            case "leave":
                return f"if ({self.text(target)}) {{ return {self.text(value)}{self.end} }}"
        return f"return {self.text(value)}{self.end}"

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
        declared = self.declared(variable)
        return self.forms["let"].format(declared=declared, name=variable.name, value=value)

    def empty(self, variable: Variable) -> str:
        """An array or a structure without values."""
        return self.forms["empty"].format(self.declared(variable))

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
            case "invoke":
                text = f"{self.function_name(detail)}({', '.join(texts)})"
            case "component":
                text = self._primary(arguments[0]) + self.components[detail]
            case "colour":
                text = self._primary(arguments[0]) + self.rgb
            case "field":
                text = f"{self._primary(arguments[0])}.{detail}"
            case "element":
                text = f"{self._primary(arguments[0])}[{texts[1]}]"
            case "vector":
                text = self.composed(value.kind, texts)
            case _:
                text = self.forms[value.operation].format(*texts)
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


def kinds(
    two: str, three: str, four: str, number: str = "float", whole: str = "int", truth: str = "bool"
) -> dict:
    """The kinds of a language by its names of two to four floats, a float, an int and a bool."""
    several = {PLACE: two, COLOUR: three, VECTOR: three, TEXEL: four}
    return {FLOAT: number, **several, BOOL: truth, INT: whole}


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
