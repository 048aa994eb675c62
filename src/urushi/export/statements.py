"""Statements of shader code: functions and structures, and a builder for their bodies."""

import functools
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from urushi.core.namespace import Components, Namespace
from urushi.export.expressions import (
    COLOUR,
    INT,
    LAYERS,
    PLACE,
    TEXEL,
    TEXTURE,
    Expression,
    Value,
    call,
    colour_of,
    converted,
    expression,
    name,
    select,
)


@dataclass(frozen=True)
class Variable:
    """A field of a structure or an argument of a function."""

    name: str
    kind: str  # as in `expressions`
    count: int | None = None  # the number of elements of an array; None for a single value
    note: str = ""  # its meaning, a comment in the file

    @property
    def value(self) -> Expression:
        """The variable inside its function."""
        return name(self.name, self.kind)


@dataclass(frozen=True)
class Structure:
    """Named values that functions pass to each other; `name` is also their kind."""

    name: str
    fields: tuple[Variable, ...]
    note: str


@dataclass(frozen=True)
class Statement:
    """A line of a body."""

    # "note", "let" (a constant), "declare" (without a value), "assign", "leave" (return at once),
    # "return".
    operation: str
    target: Any = None  # the `Variable` declared or assigned to; the text of a note; a condition
    value: Any = None


@dataclass
class Function:
    """A function, and the builder of its body."""

    name: str  # without prefix
    arguments: tuple[Variable, ...]
    kind: str  # of the result
    note: str  # a comment in the file
    public: bool = False  # whether the user of the file calls it
    body: list[Statement] = field(default_factory=list)

    def note_line(self, text: str) -> None:
        self.body.append(Statement("note", text))

    def let(self, label: str, value: Value) -> Expression:
        """Name a value; constants and names stay as they are."""
        value = expression(value)
        if value.operation in ("constant", "name"):
            return value
        variable = Variable(label, value.kind)
        self.body.append(Statement("let", variable, value))
        return variable.value

    def declare(self, label: str, kind: str, count: int | None = None) -> Expression:
        """Declare a structure, or an array of `count` elements; `assign` gives them values."""
        variable = Variable(label, kind, count)
        self.body.append(Statement("declare", variable))
        return variable.value

    def assign(self, target: Expression, value: Value) -> None:
        """Assign a value to an element or a member."""
        self.body.append(Statement("assign", target, converted(expression(value), target.kind)))

    def leaves(self, condition: Expression, value: Value) -> None:
        """Return a value at once where a condition holds; the rest computes it there, too."""
        self.body.append(Statement("leave", condition, converted(expression(value), self.kind)))

    def returns(self, value: Value) -> None:
        self.body.append(Statement("return", None, converted(expression(value), self.kind)))

    def __call__(self, *values: Value) -> Expression:
        arguments = [
            converted(expression(value), argument.kind)
            for value, argument in zip(values, self.arguments, strict=True)
        ]
        return Expression("invoke", self.kind, arguments, self.name)


#: A number of a code as a linear function of a texel's bytes, which are in [0, 1]: its value where
#: they are zero, and byte and factor of each term.
LinearNumber = tuple[float, tuple[tuple[int, float], ...]]


class Texels(NamedTuple):
    """How the codes of texels are stored in an array texture."""

    numbers: Sequence[Sequence[LinearNumber]]  # of a code, each in one channel or three
    layers: int  # of the texture
    to_texture: Sequence[Sequence[float]]  # affine map (2, 3) from uv to the texture's coordinates
    filtering: str  # how the user's sampler continues and filters the texture, a sentence


@dataclass(frozen=True)
class Program:
    """A file. Each structure and function uses only the ones before it."""

    # The comment at its head, by paragraphs; {f} stands for the function f's name in the file.
    note: Sequence[str]
    structures: Sequence[Structure]
    functions: Sequence[Function]

    @property
    def public(self) -> list[str]:
        """The functions that the user calls."""
        return [function.name for function in self.functions if function.public]

    @property
    def textured(self) -> bool:
        """Whether functions read a texture of `rest`."""
        arguments = (a for function in self.functions for a in function.arguments)
        return any(argument.kind == TEXTURE for argument in arguments)


def element(array: Expression, index: int | Expression) -> Expression:
    """An element of an array, or of an argument or a member that is one."""
    place = index if isinstance(index, Expression) else integer(index)
    return Expression("element", array.kind, (array, place))


def integer(value: int) -> Expression:
    return Expression("integer", INT, detail=value)


def member(structure: Expression, which: Variable) -> Expression:
    return Expression("field", which.kind, (structure,), which.name)


def namespace(body: Function, suffix: str = "") -> Namespace:
    """The functions of formulas for expressions; variables are declared in `body`.

    suffix: of their names.
    """

    def named(label: str, value: Value) -> Expression:
        return body.let(label + suffix, value)

    def normalized(w: Components) -> Components:
        wide = Components(*(named(f"wide_{axis}", c) for axis, c in zip("xyz", w, strict=True)))
        size = named("wide_size", call("sqrt", wide.x * wide.x + wide.y * wide.y + wide.z * wide.z))
        return Components(
            *(named(f"cap_{axis}", c / size) for axis, c in zip("xyz", wide, strict=True))
        )

    labels = ("sqrt", "sqrt", "exp", "log", "log1p", "abs", "min", "max")
    functions: Any = [functools.partial(call, label) for label in labels]
    functions += [select, lambda x: call("max", x, 0.0)]
    functions.append(lambda x: (call("sin", x), call("cos", x)))
    functions += [normalized, functools.partial(call, "clamp")]
    functions.append(lambda x: 0.5 - 0.5 * call("tanh", call("clamp", 0.5 * x, -20.0, 20.0)))
    functions.append(named)
    return Namespace(*functions)


def fetch_functions(texels: Texels, prepare: Function) -> list[Function]:
    """The functions that read a material from a texture: of filtered bytes, and fetch."""
    stored = Variable("stored", TEXEL, texels.layers)
    note = "A material of filtered bytes, each in [0, 1]."
    unpack = Function("texel", (stored,), prepare.kind, note)
    codes = unpack.declare("codes", COLOUR, len(texels.numbers))
    for i, channels in enumerate(texels.numbers):
        numbers = []
        for offset, factors in channels[:1] if len(set(channels)) == 1 else channels:
            number = expression(offset)
            for place, factor in factors:
                byte = element(stored.value, place // 4).component(place % 4)
                number = number + byte * factor
            numbers.append(number)
        unpack.assign(element(codes, i), numbers[0] if len(numbers) == 1 else colour_of(*numbers))
    unpack.returns(prepare(codes))
    arguments = Variable("texels", LAYERS), Variable("uv", PLACE)
    function = Function("fetch", arguments, unpack.kind, "The material at uv.", public=True)
    texture, uv = (argument.value for argument in arguments)
    at = [
        function.let(axis, u * uv.x + v * uv.y + offset)
        for axis, (u, v, offset) in zip("xy", texels.to_texture, strict=True)
    ]
    four = function.declare(stored.name, TEXEL, texels.layers)
    for k in range(texels.layers):
        operands = (texture, *at, integer(k))
        function.assign(element(four, k), Expression("layer", TEXEL, operands))
    function.returns(unpack(four))
    return [unpack, function]
