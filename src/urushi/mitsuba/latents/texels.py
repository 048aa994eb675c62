"""Codes at texels over uv, one of which is drawn at each point.

Of texels of codes, f is filtered, not the code: f of the code halfway between two codes is far from
the mean of both f where the two differ much. A look-up therefore takes one texel, drawn in
proportion to its weight in the filter (Pharr, Wronski, Salvi and Fajardo 2024, *Filtering After
Shading With Stochastic Texture Filtering*) by a hash of the position and of wi. f, density and
sample of a vertex belong to one texel, and f is right in the mean over positions.
"""

from collections.abc import Sequence
from functools import partial

import drjit as dr
import mitsuba as mi

from urushi.textures.axes import LINEAR, Axis, Varying
from urushi.textures.store import TexelGrid

#: Number of steps of a texel's weight along an axis. A point within half a step of the centre of a
#: texel has this texel alone.
WEIGHT_STEPS = 256


def texel_axes(grid: TexelGrid) -> list[Varying]:
    """The axes v and u of the texels of a grid, one of which is drawn at each point."""

    def read(si, active, along: int) -> list:
        count = (grid.width, grid.height)[along]
        (a, b, c), (d, e, f) = grid.to_texture
        point = a * si.uv.x + b * si.uv.y + c, d * si.uv.x + e * si.uv.y + f
        sizes = [mi.Int32(grid.width), mi.Int32(grid.height)]
        texel = drawn_texel(point, sizes, grid, texel_draw(si.uv, si.wi))
        return [mi.Float(texel[along]) * (1 / max(count - 1, 1))]

    return [
        Varying(Axis(name, LINEAR, 0.0, 1.0), partial(read, along=along))
        for name, along in (("v", 1), ("u", 0))
    ]


def texel_draw(uv, wi) -> list:
    """Three numbers in (0, 1) that draw a texel at uv seen from wi: along x, along y, and a level.

    They are a hash of uv and wi, multiples of 1 / `WEIGHT_STEPS` plus half of it.
    """
    bits = [_bits(value) for value in (uv.x, uv.y, wi.x, wi.y)]
    hashed, _ = mi.sample_tea_32(bits[0] + 0x9E3779B9 * bits[2], bits[1] + 0x85EBCA6B * bits[3])
    return [
        (mi.Float((hashed >> shift) % WEIGHT_STEPS) + 0.5) / WEIGHT_STEPS for shift in (8, 16, 24)
    ]


def _bits(value):
    """The bits of a float in single precision."""
    single = dr.float32_array_t(type(value))(dr.detach(value))
    return dr.reinterpret_array(mi.UInt32, single)


def drawn_texel(point: Sequence, sizes: Sequence, grid: TexelGrid, draw: Sequence) -> list:
    """Column and row (Int32) of one of the texels around a point, drawn by its weight.

    point: x and y in texture space. sizes: Int32, numbers of texels along them. draw: of
    `texel_draw`.
    """
    return [
        _drawn_along(x, count, grid, u) for x, count, u in zip(point, sizes, draw, strict=False)
    ]


def _drawn_along(x, count, grid: TexelGrid, u):
    """The texel (Int32) of `drawn_texel` along one axis."""
    if grid.wrap == "repeat":
        x = x - dr.floor(x)
    elif grid.wrap == "mirror":
        x = dr.abs(x - 2 * dr.round(0.5 * x))
    else:
        x = dr.clip(x, 0, 1)
    texel = mi.Int32(dr.floor(x * count - (0.0 if grid.nearest else 0.5 - u)))
    if grid.wrap == "repeat":
        texel = dr.select(texel >= count, 0, dr.select(texel < 0, count - 1, texel))
    return dr.clip(texel, 0, count - 1)  # NaN too
