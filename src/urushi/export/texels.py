"""Codes of a texture's texels as shader code: from filtered bytes to a material.

The texture is an array of layers with four bytes each, red, green, blue and alpha, which graphics
hardware filters like a picture. The numbers of a code are linear in them.
"""

from collections.abc import Sequence
from typing import NamedTuple

from urushi.export.expressions import COLOUR, FLOAT, Expression, colour_of, expression, name
from urushi.export.statements import Function, Variable, element


class LinearNumber(NamedTuple):
    """A number of a code as a linear function of a texel's bytes.

    Attributes:
        offset: its value where the bytes are zero.
        factors: byte and factor of each term; bytes are in [0, 1].
    """

    offset: float
    factors: tuple[tuple[int, float], ...] = ()


class Texels(NamedTuple):
    """How the codes of texels are stored.

    Attributes:
        numbers: of each number of a code, its linear function in each channel, one or three.
        layers: layers of the texture.
        to_texture: the affine map (2, 3) from uv to the texture's coordinates.
        filtering: how the user's sampler continues and filters the texture, a sentence.
    """

    numbers: Sequence[Sequence[LinearNumber]]
    layers: int
    to_texture: Sequence[Sequence[float]]
    filtering: str


def texel_function(texels: Texels, prepare: Function) -> Function:
    """The function that unpacks a texel's filtered bytes into a material."""
    stored = Variable("stored", FLOAT, 4 * texels.layers)
    function = Function(
        "texel", (stored,), prepare.kind, "A material of filtered bytes, each in [0, 1]."
    )
    values = name(stored.name, FLOAT)
    codes = function.array("codes", COLOUR, len(texels.numbers))
    for i, channels in enumerate(texels.numbers):
        if len(set(channels)) == 1:
            number = _linear(channels[0], values)
        else:
            number = colour_of(*(_linear(channel, values) for channel in channels))
        function.assign(element(codes, i), number)
    function.returns(prepare(codes))
    return function


def _linear(number: LinearNumber, values: Expression) -> Expression:
    total = expression(number.offset)
    for place, factor in number.factors:
        total = total + element(values, place) * factor
    return total
