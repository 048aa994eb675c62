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

#: Arithmetic and functions that are computed here where all operands are constants.
_FOLDED: dict[str, Callable[..., np.ndarray]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "sqrt": np.sqrt,
    "log": np.log,
    "exp": np.exp,
    "tanh": np.tanh,
    "abs": np.abs,
    "min": np.minimum,
    "max": np.maximum,
    "clamp": np.clip,
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
        b = expression(other)
        if equals(self, 0.0):
            return b
        return self if equals(b, 0.0) else _arithmetic("+", self, b)

    def __radd__(self, other: Value) -> "Expression":
        return expression(other) + self

    def __sub__(self, other: Value) -> "Expression":
        b = expression(other)
        return self if equals(b, 0.0) else _arithmetic("-", self, b)

    def __rsub__(self, other: Value) -> "Expression":
        return expression(other) - self

    def __neg__(self) -> "Expression":
        return -1.0 * self

    def __mul__(self, other: Value) -> "Expression":
        b = expression(other)
        if equals(self, 0.0) or equals(b, 0.0):
            return expression(0.0)
        if equals(self, 1.0):
            return b
        return self if equals(b, 1.0) else _arithmetic("*", self, b)

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

    x = property(lambda self: self.component(0))
    y = property(lambda self: self.component(1))
    z = property(lambda self: self.component(2))

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


def equals(value: Expression, number: float) -> bool:
    """Whether a value is a constant, and this number in all channels."""
    return value.constant is not None and bool((value.constant == number).all())


def _folded(operation: str, operands: Sequence[Expression]) -> Expression | None:
    """An operation on constants as a constant; None where it is left to the shader."""
    constants = [operand.constant for operand in operands]
    if operation not in _FOLDED or any(value is None for value in constants):
        return None
    value = _FOLDED[operation](*constants)
    return colour(value) if value.ndim else expression(float(value))


def _wider(*values: Expression) -> str:
    """The kind of a function of floats, and of colours or texels."""
    return next((v.kind for v in values if v.kind in (COLOUR, TEXEL)), values[0].kind)


def _arithmetic(sign: str, a: Expression, b: Expression) -> Expression:
    return _folded(sign, (a, b)) or Expression(sign, _wider(a, b), (a, b))


def call(function: str, *values: Value) -> Expression:
    """A function of the languages, element by element: sqrt, log, exp, tanh, abs, min, max, …"""
    arguments = [expression(value) for value in values]
    kind = _wider(*arguments)
    return _folded(function, arguments) or Expression(
        "call", kind, [converted(a, kind) for a in arguments], function
    )


def select(condition: Expression, yes: Value, no: Value) -> Expression:
    """One of two values by a condition on floats."""
    yes, no = expression(yes), expression(no)
    a, b = (argument.constant for argument in condition.arguments)
    if a is not None and b is not None:
        return yes if a > b or (condition.operation == ">=" and a == b) else no
    kind = _wider(yes, no)
    return Expression("select", kind, (condition, converted(yes, kind), converted(no, kind)))


def vector(x: Value, y: Value, z: Value) -> Expression:
    return Expression("vector", VECTOR, [expression(value) for value in (x, y, z)])


def colour_of(red: Expression, green: Expression, blue: Expression) -> Expression:
    return Expression("vector", COLOUR, (red, green, blue))


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
