"""Tables that Dr.Jit looks up in packets: numbers at nodes, f over directions, and albedos.

Numbers of 16 bits, two to a word, take a third less time than numbers of half precision, and are
more exact. Tables over directions (`core.table`) are f of constant materials. Directional albedos
are those of rough interfaces (`core.albedos`).
"""

from collections.abc import Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core import albedos, anisotropic_albedos
from urushi.core.lanes import cell
from urushi.core.namespace import DRJIT
from urushi.core.table import SHAPE, coordinates, corner_steps
from urushi.mitsuba.recording import Recorded, owned

#: Largest level of a number.
TOP = (1 << 16) - 1

#: Most words of a packet: more are slower.
PACKET = 8


def packet(kind: type, table, index, size: int) -> list:
    """`size` numbers of a table from an index on, of whose type `kind` is the dynamic array."""
    if size == 1:  # Dr.Jit 1.5 fails on packets of one number in calls
        return [dr.gather(type(table), table, index)]
    return list(dr.gather(kind, table, index, shape=(size, dr.width(index))))


class Numbers:
    """Numbers (P, N) at P nodes, each in 16 bits of its range."""

    def __init__(self, numbers: np.ndarray):
        """Store numbers."""
        self.nodes, self.count = numbers.shape
        lowest = numbers.min(axis=0)
        steps = np.maximum(numbers.max(axis=0) - lowest, 1e-9) / TOP
        levels = np.rint((numbers - lowest) / steps).astype(np.uint32)
        if self.count % 2:
            levels = np.pad(levels, [(0, 0), (0, 1)])
        words = levels[:, ::2] + (levels[:, 1::2] << 16)
        self._packets: list[Any] = []
        while words.shape[1]:
            size = min(1 << (words.shape[1].bit_length() - 1), PACKET)
            self._packets.append(owned(mi.UInt32, words[:, :size]))
            words = words[:, size:]
        # From memory, so that all materials of the same axes share compiled code
        self._steps, self._lowest = ([mi.Float(float(x)) for x in own] for own in (steps, lowest))
        dr.make_opaque(self._steps, self._lowest)

    def _levels(self, node) -> list:
        """The levels (N) of a node, an index (UInt32), as Dr.Jit floats."""
        words = list[Any]()
        for own in self._packets:
            words += packet(mi.ArrayXu, own, node, len(own) // self.nodes)
        levels = [mi.Float(half) for word in words for half in (word & 0xFFFF, word >> 16)]
        return levels[: self.count]

    def at(self, corners: Sequence[tuple[Any, Any]]) -> list:
        """The numbers (N), Dr.Jit floats: sums over nodes, indices (UInt32), times weights.

        The weights add up to one.
        """
        total = list[Any]()
        for node, weight in corners:
            # One corner after the other, whose sums stay in a processor's registers: without it,
            # Dr.Jit computes one number after the other, at two thirds of the speed or less.
            dr.detail.new_scope(dr.backend_v(mi.Float))
            levels = self._levels(node)
            if total:
                total = [dr.fma(weight, x, y) for x, y in zip(levels, total, strict=True)]
            else:
                total = [weight * x for x in levels]
        return [dr.fma(*x) for x in zip(total, self._steps, self._lowest, strict=True)]


def stored(table: np.ndarray, half: bool) -> Any:
    """A table (..., C), `padded`, as flat Dr.Jit floats; half: in half precision."""
    kind, dtype = (dr.float16_array_t(mi.Float), np.float16) if half else (mi.Float, np.float32)
    return owned(kind, padded(table).astype(dtype))


def padded(table: np.ndarray) -> np.ndarray:
    """A table (..., C) as float32, C padded to a power of two, which Dr.Jit gathers at once."""
    channels = table.shape[-1]
    size = 1 << (channels - 1).bit_length()
    return np.pad(table.astype(np.float32), [*[(0, 0)] * (table.ndim - 1), (0, size - channels)])


def interpolated(table, shape: Sequence[int], coordinates: Sequence, band=None) -> list:
    """The numbers of an entry (K) of a table (*shape, K), linear between its nodes.

    table: flattened Dr.Jit floats, `stored`; K is a power of two. coordinates: in [0, 1], one for
    each axis. band: index (UInt32) of the table in a sequence of tables with K = 1.
    """
    first, shares = cell(shape, coordinates, mi.UInt32(0 if band is None else band))
    size = 1 if band is not None else len(table) // int(np.prod(shape))

    half = dr.type_v(table) == dr.VarType.Float16
    kind = dr.float16_array_t(mi.ArrayXf) if half else mi.ArrayXf

    def entry(index) -> list:
        return [mi.Float(x) for x in packet(kind, table, index, size)]

    values = [entry(first + step) for step in corner_steps(shape)]
    for share in reversed(shares):
        pairs = zip(values[::2], values[1::2], strict=True)
        values = [
            [dr.fma(share, y - x, x) for x, y in zip(low, high, strict=True)] for low, high in pairs
        ]
    return values[0]


def tabulated(table, channels: int, wi, wo, bands: Sequence | None = None) -> list:
    """Each channel of a table of logarithms over directions, see `core.table.interpolated_at`.

    Exchanging wi and wo gives the same bits.

    bands: index (UInt32) of each channel's table, if the table is a sequence of tables of one.
    """
    places = [dr.clip(x, 0, 1) for x in coordinates(wi + wo, wi - wo, DRJIT)]
    if bands is None:
        logs = interpolated(table, SHAPE, places)
    else:
        logs = [interpolated(table, SHAPE, places, band)[0] for band in bands]
    return [dr.exp(log) for log in logs[:channels]]


class InterfaceAlbedo(Recorded):
    """Directional albedos of a rough dielectric interface, from above.

    Directions are unit vectors above the horizon, or cosines if the interface has one width.

    eta: its index if it is constant, which methods then need not get, `facets.MIRROR` for facets
        that reflect all light; None: any between 1/3 and 3. two_widths: whether its widths are
        `Widths`.
    """

    def __init__(self, eta: float | None, two_widths: bool = False):
        self._constant, self._two = eta, two_widths
        known = (anisotropic_albedos if two_widths else albedos).tables(self._constant)
        self._shares = self._tables(known.reflected, known.passed)
        self._means = self._tables(known.reflected_mean, known.passed_mean)
        self._entered = self._tables(known.reflected_entered, known.passed_entered)

    def reflected(self, w, alpha, eta=None):
        """Share of the light from a direction that is reflected; w is None: of diffuse light."""
        return self.both(w, alpha, eta)[0]

    def both(self, w, alpha, eta, mirrored=None) -> list:
        """Shares that are reflected and transmitted; the rest would meet a second facet.

        mirrored: share of diffuse light that has entered as `albedos.Tables` says.
        """
        at = self._at(w, alpha, eta)
        found = (self._means if w is None else self._shares)(at)
        if mirrored is None:
            return found
        return [dr.lerp(a, b, mirrored) for a, b in zip(found, self._entered(at), strict=True)]

    def _tables(self, *values: np.ndarray):
        """Tables as channels, without the axis of the index if it is constant."""
        table = np.stack(values, axis=-1)
        return Interpolated(table if self._constant is None else table[0])

    def _at(self, w, alpha, eta) -> list:
        eta = eta if self._constant is None else self._constant
        cosine = w.z if isinstance(w, mi.Vector3f) else w
        if not self._two:
            return albedo_coordinates(cosine, alpha, eta)
        at = anisotropic_albedos.coordinates(w, alpha, DRJIT)
        if w is not None:
            at = [albedos.cosine_coordinate(cosine, eta, DRJIT), *at]
        if self._constant is None:
            at.append(anisotropic_albedos.index_coordinate(eta, DRJIT))
        return at


def albedo_coordinates(cosine, alpha, eta) -> list:
    """Coordinates in [0, 1] of a look-up in tables of `albedos`, their last axis first.

    cosine: None in tables without its axis.
    eta: None in tables that do not depend on it; a float in tables of one index, without its axis.
    """
    at = [] if cosine is None else [albedos.cosine_coordinate(cosine, eta, DRJIT)]
    at.append(albedos.roughness_coordinate(alpha, DRJIT))
    if eta is not None and not isinstance(eta, float):
        at.append(albedos.index_coordinate(eta, DRJIT))
    return at


class Interpolated:
    """A table of channels, the last axis, as a function of coordinates in [0, 1].

    The coordinate of the last axis but the channels comes first. The table is linear between its
    nodes, which are from 0 to 1 on each axis.
    """

    def __init__(self, table: np.ndarray):
        *self._shape, self._channels = table.shape
        self._table = stored(table, half=False)

    def __call__(self, at: list) -> list:
        """The channels."""
        places = [dr.clip(mi.Float(x), 0, 1) for x in reversed(at)]
        return interpolated(self._table, self._shape, places)[: self._channels]
