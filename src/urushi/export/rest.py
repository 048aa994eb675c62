"""ln f of the rest in textures, and how shader code evaluates it.

A shader reads one texture. It holds ln f of one material (`own_texture`), or the mean and the
functions of the basis, for all codes (`basis_texture`). Hardware filters three coordinates of
`core.table`, or two in OSL. They are the axes of the texture in the opposite order. The last of
them, along x, is repeated in blocks: for the numbers of a node that do not fit into one texel, and
for the nodes in the coordinates that are left, between which the shader interpolates by itself.
Coordinates are between the centres of texels, so that no filter mixes blocks.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from urushi.core.table import MAX_LOG, MIN_LOG, SHAPES, Knots, coordinates, corner_steps
from urushi.errors import ParameterError
from urushi.export.expressions import TEXEL, Expression, Value, call, vector
from urushi.export.statements import Function, namespace
from urushi.nets.basis import Basis
from urushi.nets.linear import LinearNetworks
from urushi.nets.weights import Model


class TextureForm(NamedTuple):
    """What a language's textures are."""

    axes: int = 3  # coordinates that hardware filters
    numbers: int = 4  # of a texel


class RestTable(NamedTuple):
    """The nodes of a table and the numbers at each of them."""

    widths: int  # GGX widths of the material: of three coordinates, or of four
    numbers: int = 3  # ln f of each channel, or the functions of a basis
    knots: Knots = ()
    beside_lobe: bool = True  # whether f is the lobe and the table, or the table alone

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


def basis_of(model: Model) -> Basis:
    """The basis of networks."""
    if not isinstance(model.networks, LinearNetworks):
        raise ParameterError(f"the networks {model.fingerprint} have no basis; export a material")
    return model.networks.basis


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


def rest_f(
    body: Function,
    table: RestTable,
    form: TextureForm,
    texture: Expression,
    code: Sequence[Expression] | None,
    wi: Expression,
    wo: Expression,
) -> Expression:
    """f [1/sr] of the rest.

    code: colours (K,), factors of the functions of a basis; None: the table is ln f.
    """
    texels = looked_up(body, table, form, texture, wi, wo)
    if code is None:
        return body.let("rest", call("exp", texels[0].colour))
    numbers = [texel.component(i) for texel in texels for i in range(form.numbers)]
    logarithm = code[0] + numbers[0]  # the gain, and b
    for number, function in zip(code[1:], numbers[1:], strict=False):
        logarithm = logarithm + number * function
    return body.let("rest", call("exp", call("clamp", logarithm, MIN_LOG, MAX_LOG)))


def looked_up(
    body: Function,
    table: RestTable,
    form: TextureForm,
    texture: Expression,
    wi: Expression,
    wo: Expression,
) -> list[Expression]:
    """The texels of a table for a pair of directions, linear between the nodes."""
    body.note_line("The table's coordinates, from the first node to the last.")
    both, apart = body.let("both", wi + wo), body.let("apart", wi - wo)
    found = coordinates(both, apart, table.widths, namespace(body), table.knots)
    at = [
        body.let(f"node{i}", call("clamp", place, 0.0, 1.0) * (count - 1.0))
        for i, (place, count) in enumerate(zip(found, table.shape, strict=True))
    ]
    inner, others = table.shape[form.axes - 1], table.shape[form.axes :]
    blocks, width = math.prod(others), texture_shape(table, form)[-1]
    outer = [
        body.let(f"place{i}", (at[i] + 0.5) * (1.0 / table.shape[i])) for i in range(form.axes - 1)
    ]
    first, shares = at[form.axes - 1] + 0.5, []
    for i, count in enumerate(others, start=form.axes):
        low = body.let(f"low{i}", call("min", call("floor", at[i]), count - 2.0))
        shares.append(body.let(f"share{i}", at[i] - low))
        first = first + low * float(inner * math.prod(table.shape[i + 1 :]))
    first = body.let("first", first)

    def texel(label: str, block: int) -> Expression:
        along = (first + float(inner * block)) * (1.0 / width)
        across: list[Value] = [*reversed(outer), 0.0]
        place = body.let(f"{label}_place", vector(along, *across[:2]))
        return body.let(label, Expression("texel", TEXEL, (texture, place)))

    texels = []
    for k in range(_texels(table.numbers, form)):
        steps = corner_steps(others)
        corners = [texel(f"texel{k}_{i}", k * blocks + step) for i, step in enumerate(steps)]
        for share in reversed(shares):
            pairs = zip(corners[::2], corners[1::2], strict=True)
            corners = [low + (high - low) * share for low, high in pairs]
        texels.append(body.let(f"texel{k}", corners[0]))
    return texels
