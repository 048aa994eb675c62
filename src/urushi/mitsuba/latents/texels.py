"""Codes at texels over uv, one of which is drawn at each point.

Of texels of codes, f is filtered, not the code: f of the code halfway between two codes is far from
the mean of both f where the two differ much. A look-up therefore takes one texel, drawn in
proportion to its weight in the filter (Pharr, Wronski, Salvi and Fajardo 2024, *Filtering After
Shading With Stochastic Texture Filtering*) by a hash of the position and of wi. f, density and
sample of a vertex belong to one texel, and f is right in the mean over positions.
"""

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
        return [mi.Float(drawn_texel(si, grid)[along]) * (1 / max(count - 1, 1))]

    return [
        Varying(Axis(name, LINEAR, 0.0, 1.0), partial(read, along=along))
        for name, along in (("v", 1), ("u", 0))
    ]


def drawn_texel(si, grid: TexelGrid) -> list:
    """Column and row (Int32) of one of the texels around a point, drawn by its weight.

    The numbers in (0, 1) by which it is drawn are a hash of uv and wi, multiples of
    1 / `WEIGHT_STEPS` plus half of it.
    """
    values = (si.uv.x, si.uv.y, si.wi.x, si.wi.y)
    singles = (dr.float32_array_t(type(x))(dr.detach(x)) for x in values)
    bits = [dr.reinterpret_array(mi.UInt32, x) for x in singles]
    hashed, _ = mi.sample_tea_32(bits[0] + 0x9E3779B9 * bits[2], bits[1] + 0x85EBCA6B * bits[3])
    found = []
    for (a, b, c), texels, shift in zip(
        grid.to_texture, (grid.width, grid.height), (8, 16), strict=True
    ):
        u = (mi.Float((hashed >> shift) % WEIGHT_STEPS) + 0.5) / WEIGHT_STEPS
        x, count = a * si.uv.x + b * si.uv.y + c, mi.Int32(texels)
        if grid.wrap == "repeat":
            x = x - dr.floor(x)
        elif grid.wrap == "mirror":
            x = dr.abs(x - 2 * dr.round(0.5 * x))
        else:
            x = dr.clip(x, 0, 1)
        texel = mi.Int32(dr.floor(x * count - (0.0 if grid.nearest else 0.5 - u)))
        if grid.wrap == "repeat":
            texel = dr.select(texel >= count, 0, dr.select(texel < 0, count - 1, texel))
        found.append(dr.clip(texel, 0, count - 1))  # NaN too
    return found
