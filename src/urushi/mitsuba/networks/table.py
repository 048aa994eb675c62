"""f of constant materials in Dr.Jit, by tables over directions (`material.table`)."""

from collections.abc import Sequence

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.material import anisotropic_table
from urushi.material.table import HIGHEST, LOWEST, SHAPES, TAN2_OFFSET, corner_steps
from urushi.mitsuba.networks import lobe
from urushi.mitsuba.networks.lobe import LobeKind


class TabulatedDecoder:
    """f [1/sr] of a constant material: its lobe, and a table of the rest or of all of f.

    The terms of a channel are the numbers of its lobe that `LobeKind.numbers` names.
    """

    def __init__(self, kind: LobeKind):
        """kind: what is known of the codes' lobes; no lobe is present in a table of all of f."""
        self._kind = kind

    def code_terms(self, latents: np.ndarray) -> list[np.ndarray]:
        """Terms (K,) of the code of each channel, from codes (C, size)."""
        return [code[self._kind.numbers(c)] for c, code in enumerate(latents)]

    def f_of_terms(
        self, tables: Sequence, terms: Sequence[Sequence], wi, wo, bands: Sequence | None = None
    ) -> list:
        """f of each channel, from its terms, lists of Dr.Jit floats.

        tables: the `padded` table as Dr.Jit floats; empty if there is no rest. bands: index
        (UInt32) of each term's table, if the table is a sequence of tables of one channel.
        Exchanging wi and wo gives the same bits.
        """
        rests = [wi.z * 0] * len(terms)
        if tables:
            rests = _looked_up(tables[0], len(terms), wi, wo, self._kind.widths, bands)
        if not self._kind.present:
            return rests
        values = lobe.f(self._kind.complete(terms), wi, wo, self._kind)
        return [a + b for a, b in zip(values, rests, strict=True)]


def padded(table: np.ndarray) -> np.ndarray:
    """A table (..., C) as float32, C padded to a power of two, which Dr.Jit gathers at once."""
    channels = table.shape[-1]
    size = 1 << (channels - 1).bit_length()
    return np.pad(table.astype(np.float32), [*[(0, 0)] * (table.ndim - 1), (0, size - channels)])


def interpolated(table, shape: Sequence[int], coordinates: Sequence, band=None) -> list:
    """The numbers of an entry (K) of a table (*shape, K), linear between its nodes.

    table: flattened Dr.Jit floats; K is a power of two. coordinates: in [0, 1], one for each axis.
    band: index (UInt32) of the table in a sequence of tables with K = 1.
    """
    first, shares = mi.UInt32(0 if band is None else band), []
    for coordinate, count in zip(coordinates, shape, strict=True):
        place = coordinate * (count - 1)
        index = dr.minimum(mi.UInt32(place), count - 2)
        first = first * count + index
        shares.append(place - mi.Float(index))

    def entry(index) -> list:
        if band is not None:  # Dr.Jit 1.5 fails on packets of one number in calls
            return [dr.gather(mi.Float, table, index)]
        packet = len(table) // int(np.prod(shape)), dr.width(index)
        return list(dr.gather(mi.ArrayXf, table, index, shape=packet))

    values = [entry(first + step) for step in corner_steps(shape)]
    for share in reversed(shares):
        pairs = zip(values[::2], values[1::2], strict=True)
        values = [
            [dr.fma(share, y - x, x) for x, y in zip(low, high, strict=True)] for low, high in pairs
        ]
    return values[0]


def _looked_up(table, channels: int, wi, wo, widths: int, bands: Sequence | None) -> list:
    """f of each channel [1/sr], see `material.table.interpolated`."""
    places = _coordinates(wi, wo) if widths == 1 else _anisotropic_coordinates(wi, wo)
    clipped = [dr.clip(place, 0, 1) for place in places]
    if bands is None:
        logs = interpolated(table, SHAPES[widths], clipped)
    else:
        logs = [interpolated(table, SHAPES[widths], clipped, band)[0] for band in bands]
    return [dr.exp(log) for log in logs[:channels]]


def _coordinates(wi, wo) -> tuple:
    """The coordinates u, v, w, see `material.table.coordinates`."""
    x, y, z = wi.x + wo.x, wi.y + wo.y, wi.z + wo.z
    across, z2 = x * x + y * y, z * z
    squared = across + z2
    u = (dr.log(across / z2 + TAN2_OFFSET) - LOWEST) * (1 / (HIGHEST - LOWEST))
    cos_d = dr.minimum(0.5 * dr.sqrt(squared), 1)
    sin2 = (1 - cos_d) * (1 + cos_d)
    # Roots that reach zero have finite derivatives if they are safe ones.
    reach = dr.maximum(dr.minimum(0.5 * z, dr.safe_sqrt(across / squared * sin2)), 1e-9)
    size = dr.clip(0.5 * dr.abs(wi.z - wo.z) / reach, 0, 1)
    return u, dr.safe_sqrt(1 - cos_d), 1 - dr.safe_sqrt(1 - size)


def _anisotropic_coordinates(wi, wo) -> tuple:
    """The coordinates u_x, u_y, v, p, see `material.anisotropic_table.coordinates`."""
    x, y, z = wi.x + wo.x, wi.y + wo.y, wi.z + wo.z
    dx, dy = wi.x - wo.x, wi.y - wo.y
    x2, y2, z2 = x * x, y * y, z * z
    lowest = anisotropic_table.LOWEST
    scale = 1 / (anisotropic_table.HIGHEST - lowest)
    up = 1 / z2
    along, across = (
        (dr.log(dr.fma(c, up, anisotropic_table.TAN2_OFFSET)) - lowest) * scale for c in (x2, y2)
    )
    cos_d = dr.minimum(0.5 * dr.sqrt(x2 + y2 + z2), 1)
    size_x, size_y = dr.abs(dx), dr.abs(dy)
    turned = 0.5 * size_y / dr.maximum(size_x + size_y, 1e-12)
    angle = dr.select((x * y) * (dx * dy) < 0, 1 - turned, turned)
    return along, across, dr.safe_sqrt(1 - cos_d), angle
