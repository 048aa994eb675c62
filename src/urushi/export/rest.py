"""ln f of the rest in textures, and how shader code evaluates it.

A shader reads one texture. At each node of `core.table` it holds ln f of one material
(`own_texture`), or the mean and the functions of the basis, for all codes (`basis_texture`).
Hardware filters the table's three coordinates, or two in OSL, which are the axes of the texture in
the opposite order. The last of them, along x, is repeated in blocks: for what does not fit into the
texel of a node, and in OSL for the nodes in the coordinate w, between which the code interpolates
by itself. Places are between the centres of texels, so that no filter mixes blocks.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from urushi.core.stretched import stretched
from urushi.core.table import MAX_LOG, MIN_LOG, SHAPE, coordinates, corner_steps
from urushi.export.expressions import TEXEL, Expression, Value, call, vector
from urushi.export.statements import Function, namespace
from urushi.nets.weights import Model


class TextureForm(NamedTuple):
    """What a language's textures are."""

    axes: int = 3  # coordinates that hardware filters
    numbers: int = 4  # of a texel


class Rest(NamedTuple):
    """A rest in a texture."""

    texels: int  # of a node
    stretch: Expression | None = None  # with two GGX widths: s of `core.stretched`
    code: Sequence[Expression] = ()  # (K,) colours, for a basis; otherwise the texture is ln f
    factors: Sequence[int] = ()  # (K,) of b and the functions but the first; 0: none


def texture_shape(texels: int, form: TextureForm) -> tuple[int, ...]:
    """The numbers of texels along the axes of a texture, x last."""
    *outer, inner = SHAPE[: form.axes]
    return *outer, inner * texels * math.prod(SHAPE[form.axes :])


def own_texture(table: np.ndarray, form: TextureForm) -> np.ndarray:
    """The texture of `networks.table` of one channel or three, a texel for each factor.

    Returns:
        float16 (depth, height, width, numbers), without a depth for two axes.
    """
    nodes = table[..., None] if table.ndim == len(SHAPE) + 1 else table
    nodes = np.broadcast_to(nodes, (*SHAPE, 3, nodes.shape[-1])).swapaxes(-1, -2)
    return _stacked(np.pad(nodes, [(0, 0)] * 4 + [(0, form.numbers - 3)]), form)


def basis_texture(model: Model, form: TextureForm) -> np.ndarray:
    """The texture of a basis, as `own_texture`: at each node b, U_1, U_2 and so on; U_0 is one."""
    rows = np.delete(model.networks.basis.rows, 1, axis=1)  # U_0
    rows = np.pad(rows, [(0, 0), (0, -rows.shape[1] % form.numbers)])
    return _stacked(rows.reshape(*SHAPE, -1, form.numbers), form)


def _stacked(nodes: np.ndarray, form: TextureForm) -> np.ndarray:
    """The texture of texels (*SHAPE, T, numbers)."""
    axes = form.axes
    nodes = np.moveaxis(nodes, [3, axes - 1], [axes - 1, 3])
    return nodes.reshape(*SHAPE[: axes - 1], -1, form.numbers).astype(np.float16)


def rest_f(
    body: Function,
    rest: Rest,
    form: TextureForm,
    texture: Expression,
    wi: Expression,
    wo: Expression,
) -> Expression:
    """f [1/sr] of a rest, see `nets.basis`."""
    body.note_line("The table's coordinates, from the first node to the last.")
    both, apart = body.let("both", wi + wo), body.let("apart", wi - wo)
    xp, around = namespace(body), []
    if rest.stretch is None:
        places = coordinates(both, apart, xp)
    else:
        places, factors = stretched(both, apart, rest.stretch * rest.stretch, xp)
        around = [body.let(f"factor{k}", factor) for k, factor in enumerate(factors)]
    texels = _looked_up(body, rest.texels, form, texture, places)
    if not rest.code:
        logarithm = texels[0].colour
        for factor, texel in zip(around, texels[1:], strict=True):
            logarithm = logarithm + factor * texel.colour
        return body.let("rest", call("exp", logarithm))
    numbers = [texel.component(i) for texel in texels for i in range(form.numbers)]
    logarithm = rest.code[0] + numbers[0]  # the gain, and b
    for number, function, k in zip(rest.code[1:], numbers[1:], rest.factors[1:], strict=False):
        logarithm = logarithm + number * (around[k - 1] * function if k else function)
    return body.let("rest", call("exp", call("clamp", logarithm, MIN_LOG, MAX_LOG)))


def _looked_up(
    body: Function, count: int, form: TextureForm, texture: Expression, places: Sequence[Expression]
) -> list[Expression]:
    """The texels of a node, linear between the nodes around places in [0, 1]."""
    at = [
        body.let(f"node{i}", call("clamp", place, 0.0, 1.0) * (nodes - 1.0))
        for i, (place, nodes) in enumerate(zip(places, SHAPE, strict=True))
    ]
    inner, others = SHAPE[form.axes - 1], SHAPE[form.axes :]
    blocks, width = math.prod(others), texture_shape(count, form)[-1]
    outer: list[Value] = [
        body.let(f"place{i}", (at[i] + 0.5) * (1.0 / SHAPE[i])) for i in range(form.axes - 1)
    ]
    first, shares = at[form.axes - 1] + 0.5, []
    for place, nodes in zip(at[form.axes :], others, strict=True):
        low = body.let("low", call("min", call("floor", place), nodes - 2.0))
        shares.append(body.let("share", place - low))
        first = first + low * float(inner)
    first = body.let("first", first)

    def texel(label: str, block: int) -> Expression:
        along = (first + float(inner * block)) * (1.0 / width)
        place = body.let(f"{label}_place", vector(*[along, *reversed(outer), 0.0][:3]))
        return body.let(label, Expression("texel", TEXEL, (texture, place)))

    texels = []
    for k in range(count):
        corners = [
            texel(f"texel{k}_{i}", k * blocks + step) for i, step in enumerate(corner_steps(others))
        ]
        for share in shares:
            corners = [corners[0] + (corners[1] - corners[0]) * share]
        texels.append(body.let(f"texel{k}", corners[0]))
    return texels
