"""ln f of the rest in textures, and how shader code evaluates it.

A shader reads one texture. It holds ln f of one material (`own_texture`), or the mean and the
functions of the basis, for all codes (`basis_texture`). Hardware filters three coordinates of
`core.table`, or two in OSL. They are the axes of the texture in the opposite order. The last of
them, along x, is repeated in blocks: for the numbers of a node that do not fit into one texel, and
for the nodes in the coordinates that are left, between which the shader interpolates by itself.
Coordinates are between the centres of texels, so that no filter mixes blocks.
"""

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from urushi.core.table import MAX_LOG, MIN_LOG, SHAPES, Knots, coordinates
from urushi.export.expressions import TEXEL, Expression, call, colour_of, vector
from urushi.export.statements import Function, namespace
from urushi.nets.basis import Basis


class TextureForm(NamedTuple):
    """What a language's textures are."""

    axes: int = 3  # coordinates that hardware filters
    numbers: int = 4  # of a texel


class RestTable(NamedTuple):
    """The nodes of a table and the numbers at each of them."""

    widths: int  # GGX widths of the material: of three coordinates, or of four
    numbers: int = 3  # ln f of each channel, or the functions of a basis
    knots: Knots = ()

    @property
    def shape(self) -> Sequence[int]:
        return SHAPES[self.widths]


def texture_shape(table: RestTable, form: TextureForm) -> tuple[int, ...]:
    """The numbers of texels along the axes of a texture, x last."""
    *outer, inner = table.shape[: form.axes]
    blocks = _texels(table.numbers, form) * math.prod(table.shape[form.axes :])
    return *outer, inner * blocks


def own_texture(table: np.ndarray, form: TextureForm) -> np.ndarray:
    """The texture of ln f of one material, a table (..., C) of one channel or three.

    Returns:
        float16 (depth, height, width, numbers), without a depth for two axes.
    """
    return _stacked(np.broadcast_to(table, (*table.shape[:-1], 3)), form)


def basis_texture(basis: Basis, form: TextureForm) -> np.ndarray:
    """The texture of a basis: at each node b, then U_1 to U_(K-1); U_0 is one. As `own_texture`."""
    rows = np.delete(basis.rows, 1, axis=1)
    return _stacked(rows.reshape(*SHAPES[basis.widths], -1), form)


def _stacked(numbers: np.ndarray, form: TextureForm) -> np.ndarray:
    """The texture of a table of numbers (..., N)."""
    axes, size = form
    blocks = _texels(numbers.shape[-1], form)
    padding = [(0, 0)] * (numbers.ndim - 1) + [(0, blocks * size - numbers.shape[-1])]
    nodes = np.pad(numbers.astype(np.float16), padding)
    nodes = nodes.reshape(*nodes.shape[:-1], blocks, size)
    last = nodes.ndim - 2  # the axis of the texels of a node
    order = [*range(axes - 1), last, *range(axes, last), axes - 1, last + 1]
    return nodes.transpose(order).reshape(*nodes.shape[: axes - 1], -1, size)


def _texels(numbers: int, form: TextureForm) -> int:
    """The number of texels that hold the numbers of a node."""
    return -(-numbers // form.numbers)


def own_rest(body: Function, values: Sequence[Expression]) -> Expression:
    """f [1/sr] of a colour's logarithms, the numbers of `looked_up`."""
    return body.let("rest", call("exp", colour_of(*values[:3])))


def basis_rest(
    body: Function, code: Sequence[Expression], functions: Sequence[Expression]
) -> Expression:
    """f [1/sr] of a code (K,) of colours, see `nets.basis.decode`.

    functions: b, and U_1 to U_(K-1).
    """
    total = code[0] + functions[0]
    for number, function in zip(code[1:], functions[1:], strict=True):
        total = total + number * function
    return body.let("rest", call("exp", call("clamp", total, MIN_LOG, MAX_LOG)))


def looked_up(
    body: Function,
    table: RestTable,
    form: TextureForm,
    texture: Expression,
    wi: Expression,
    wo: Expression,
) -> list[Expression]:
    """The numbers of a table for a pair of directions, linear between the nodes."""
    body.note_line("The table's coordinates, from the first node to the last.")
    both, apart = body.let("both", wi + wo), body.let("apart", wi - wo)
    xp = namespace(body)
    found = coordinates(both, apart, table.widths, xp, table.knots)
    at = [
        body.let(f"node{i}", call("clamp", place, 0.0, 1.0) * (count - 1.0))
        for i, (place, count) in enumerate(zip(found, table.shape, strict=True))
    ]
    filtered = [
        (place + 0.5) * (1.0 / count) for place, count in zip(at, table.shape, strict=True)
    ][: form.axes - 1]
    blocks = _texels(table.numbers, form)
    inner = table.shape[form.axes - 1]
    others = table.shape[form.axes :]
    width = inner * blocks * math.prod(others)
    low, shares = [], []
    for i, count in enumerate(others, start=form.axes):
        low.append(body.let(f"low{i}", call("min", call("floor", at[i]), count - 2.0)))
        shares.append(body.let(f"share{i}", at[i] - low[-1]))
    body.note_line("Texels, each of which holds some of the numbers.")
    first = at[form.axes - 1] + 0.5
    step = inner
    for place, count in zip(reversed(low), reversed(others), strict=True):
        first, step = first + place * float(step), step * count
    first = body.let("first", first)

    def texel(start: int) -> Expression:
        along = (first + float(start)) * (1.0 / width)
        return Expression("texel", TEXEL, (texture, _position(along, filtered)))

    numbers = []
    for block in range(blocks):
        corners = [texel(inner * int(offset)) for offset in _corner_offsets(others, block)]
        for share in reversed(shares):
            corners = [
                a + (b - a) * share for a, b in zip(corners[::2], corners[1::2], strict=True)
            ]
        value = body.let(f"texel{block}", corners[0])
        numbers += [value.component(i) for i in range(form.numbers)]
    return numbers[: table.numbers]


def _corner_offsets(others: Sequence[int], block: int) -> list[int]:
    """Blocks from the first to those of the corners of a cell, the last coordinate fastest."""
    start = block * math.prod(others)
    return [
        start + sum(c * math.prod(others[i + 1 :]) for i, c in enumerate(corner))
        for corner in itertools.product((0, 1), repeat=len(others))
    ]


def _position(along: Expression, filtered: Sequence[Expression]) -> Expression:
    """A place in a texture: x, then the other coordinates, from the last to the first."""
    return vector(*[along, *reversed(filtered), 0.0][:3])
