"""Expressions of shader code: numbers, colours and vectors, with constant folding.

A colour has one number for each channel, red, green and blue. A value that is the same in all
channels is a float. Arithmetic with constants is evaluated here, in double precision. So one
description of a formula serves both where the numbers of a material are known and where they are
arguments; terms that vanish for known numbers generate no code.
"""

from collections.abc import Callable, Sequence
from typing import Union

import numpy as np

FLOAT, COLOUR, VECTOR, BOOL, INT = "float", "colour", "vector", "bool", "int"

#: The kinds of a texture and of an array of 2D textures, with their samplers where languages
#: separate them, of their texels, and of a place in 2D.
TEXTURE, LAYERS, TEXEL, PLACE = "texture", "layers", "texel", "place"

#: An operand of arithmetic: an expression or a Python number.
Value = Union["Expression", float]

#: Functions that constants pass through as they are computed here.
_ON_CONSTANTS: dict[str, Callable[..., np.ndarray]] = {
    "sqrt": np.sqrt,
    "log": np.log,
    "exp": np.exp,
    "tanh": np.tanh,
    "abs": np.abs,
    "min": np.minimum,
    "max": np.maximum,
    "clamp": np.clip,
}

#: Arithmetic of constants.
_SIGNS: dict[str, Callable[..., np.ndarray]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
}


class Expression:
    """A node of an expression.

    Attributes:
        operation: "constant", "name", an arithmetic sign, "call", "select", "component", "field",
            "element", "texel" (filtered, of a texture at a vector), "layer" (the same, of layers
            at x, y and a number), "colour" (of a texel), or a conversion.
        arguments: its operands.
        kind: the type of the value: one of the kinds above, or the name of a structure.
        detail: a further operand: the number of a constant, the name of a variable, a
            function or a field, the place of a component.
    """

    __slots__ = ("arguments", "detail", "kind", "operation")

    def __init__(self, operation: str, kind: str, arguments: Sequence = (), detail=None):
        self.operation, self.kind, self.detail = operation, kind, detail
        self.arguments: tuple[Expression, ...] = tuple(arguments)

    @property
    def constant(self) -> np.ndarray | None:
        """The number () or colour (3,) of a constant, float64; None for anything else."""
        return self.detail if self.operation == "constant" else None

    def __add__(self, other: Value) -> "Expression":
        a, b = self, expression(other)
        if is_zero(a):
            return b
        return a if is_zero(b) else _arithmetic("+", a, b)

    def __radd__(self, other: Value) -> "Expression":
        return expression(other) + self

    def __sub__(self, other: Value) -> "Expression":
        b = expression(other)
        return self if is_zero(b) else _arithmetic("-", self, b)

    def __rsub__(self, other: Value) -> "Expression":
        return expression(other) - self

    def __neg__(self) -> "Expression":
        return -1.0 * self

    def __mul__(self, other: Value) -> "Expression":
        a, b = self, expression(other)
        if is_zero(a) or is_zero(b):
            return expression(0.0)
        if _is_one(a):
            return b
        return a if _is_one(b) else _arithmetic("*", a, b)

    def __rmul__(self, other: Value) -> "Expression":
        return expression(other) * self

    def __truediv__(self, other: Value) -> "Expression":
        return _arithmetic("/", self, expression(other))

    def __rtruediv__(self, other: Value) -> "Expression":
        return expression(other) / self

    def __gt__(self, other: Value) -> "Expression":
        return Expression(">", BOOL, (self, expression(other)))

    def __lt__(self, other: Value) -> "Expression":
        return expression(other) > self

    def __ge__(self, other: Value) -> "Expression":
        return Expression(">=", BOOL, (self, expression(other)))

    def component(self, place: int) -> "Expression":
        """A number of a vector, a colour or a texel."""
        return Expression("component", FLOAT, (self,), place)

    @property
    def x(self) -> "Expression":
        return self.component(0)

    @property
    def y(self) -> "Expression":
        return self.component(1)

    @property
    def z(self) -> "Expression":
        return self.component(2)

    @property
    def colour(self) -> "Expression":
        """The first three numbers of a texel."""
        return Expression("colour", COLOUR, (self,))


def expression(value: Value) -> Expression:
    if isinstance(value, Expression):
        return value
    return Expression("constant", FLOAT, detail=np.asarray(value, np.float64))


def colour(values: Sequence[float] | np.ndarray) -> Expression:
    """The constant of numbers, one for each channel; a float if they are equal."""
    numbers = np.asarray(values, np.float64)
    if (numbers == numbers[0]).all():
        return expression(float(numbers[0]))
    return Expression("constant", COLOUR, detail=numbers)


def name(text: str, kind: str) -> Expression:
    return Expression("name", kind, detail=text)


def is_zero(value: Expression) -> bool:
    return value.constant is not None and not value.constant.any()


def _is_one(value: Expression) -> bool:
    return value.constant is not None and bool((value.constant == 1.0).all())


def _wider(*values: Expression) -> str:
    """The kind of a function of floats, and of colours or texels."""
    return next((v.kind for v in values if v.kind in (COLOUR, TEXEL)), values[0].kind)


def _folded(value: np.ndarray) -> Expression:
    return colour(value) if value.ndim else expression(float(value))


def _arithmetic(sign: str, a: Expression, b: Expression) -> Expression:
    x, y = a.constant, b.constant
    if x is not None and y is not None and a.kind != INT:
        return _folded(_SIGNS[sign](x, y))
    return Expression(sign, _wider(a, b), (a, b))


def call(function: str, *values: Value) -> Expression:
    """A function of the languages, element by element: sqrt, log, exp, tanh, abs, min, max, …"""
    arguments = [expression(value) for value in values]
    constants = [argument.constant for argument in arguments]
    if function in _ON_CONSTANTS and all(value is not None for value in constants):
        return _folded(_ON_CONSTANTS[function](*constants))
    kind = _wider(*arguments)
    return Expression("call", kind, [converted(a, kind) for a in arguments], function)


def select(condition: Expression, yes: Value, no: Value) -> Expression:
    """One of two values by a condition on floats."""
    yes, no = expression(yes), expression(no)
    a, b = (argument.constant for argument in condition.arguments)
    if a is not None and b is not None:
        return yes if (a > b if condition.operation == ">" else a >= b) else no
    kind = _wider(yes, no)
    return Expression("select", kind, (condition, converted(yes, kind), converted(no, kind)))


def vector(x: Value, y: Value, z: Value) -> Expression:
    return Expression("vector", VECTOR, [expression(value) for value in (x, y, z)])


def colour_of(red: Expression, green: Expression, blue: Expression) -> Expression:
    return Expression("channels", COLOUR, (red, green, blue))


def converted(value: Expression, kind: str) -> Expression:
    """A float as a colour where `kind` is one; else the value itself."""
    if kind != COLOUR or value.kind != FLOAT:
        return value
    if value.constant is not None:
        return Expression("constant", COLOUR, detail=np.full(3, float(value.constant)))
    return Expression("splat", COLOUR, (value,))


def dot(weights: Sequence[Value], values: Sequence[Value]) -> Expression:
    """The sum of products, from the first to the last."""
    total = expression(0.0)
    for weight, value in zip(weights, values, strict=True):
        total = total + expression(value) * expression(weight)
    return total
