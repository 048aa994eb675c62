"""Baking of latent textures, without a renderer.

The inputs of every texel and channel have a hash. Rows, which are pairs of a texel and a channel,
of equal hashes are computed once, wherever they are in the texture. After a change, only texels
whose hashes have changed are computed again.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from urushi import checks
from urushi.checks import CoatParameters
from urushi.core.random import INCREMENT, mix64
from urushi.material.coated_anisotropic import coated_f as anisotropic_coated_f
from urushi.material.coated_values import coated_values
from urushi.material.energy import limit_albedo
from urushi.material.layer import absent, check_ratios, layer_texels, with_widths
from urushi.material.material import Material
from urushi.material.substrate import Substrate
from urushi.material.values import codes_of
from urushi.nets import lobe as lobes
from urushi.nets.weights import Model
from urushi.textures.store import TexelGrid, TextureStore

#: Bits of the mantissa that numbers are rounded to, a relative step of 1e-4: texture filters return
#: texels with rounding errors, and half precision rounds more.
MANTISSA_BITS = 12

#: Texels whose inputs are read and compared at once: bounds memory.
TEXEL_BLOCK = 1 << 18

#: Different rows up to which light transport layers them, by the number of GGX widths: those of a
#: parameter of 8 bits, and a few seconds.
FEW = {1: 3 << 8, 2: 12}

#: Codes (k, size) of rows, by the indices (k,) of texels, in ascending order, and of channels.
CodesAt = Callable[[np.ndarray, np.ndarray], np.ndarray]

#: Gives the texels start to stop - 1: hashes uint64 (n or 1, C) of their inputs, and the function
#: that computes codes of rows, whose texels are counted from start.
Source = Callable[[int, int], tuple[np.ndarray, CodesAt]]

#: Gives the coat's parameters at texels start to stop - 1, arrays (n, 1 or C).
Coats = Callable[[int, int], CoatParameters]


class BakedTexture:
    """The packed codes of a source on a grid of texels, none before the first `update`."""

    def __init__(self, model: Model, grid: TexelGrid, channels: int, mipmaps: bool = False):
        """mipmaps: whether to hold all levels of the mip pyramid; else the first one only."""
        self.grid = grid
        self._hashes = np.zeros((grid.texels, channels), np.uint64)
        self.store = TextureStore(model, channels, grid.width, grid.height, mipmaps=mipmaps)

    def update(self, source: Source, advance: Callable[[int], Any] = lambda texels: None) -> None:
        """Compute the texels with a changed hash.

        advance: called with the number of texels of each block when it is done.
        """
        shared = SharedCodes(self.store.layout.size)
        rows, index, hashes = [], [], []
        for start in range(0, self.grid.texels, TEXEL_BLOCK):
            stop = min(start + TEXEL_BLOCK, self.grid.texels)
            present, codes_at = source(start, stop)
            former = self._hashes[start:stop]
            present = np.broadcast_to(present, former.shape)
            changed = np.flatnonzero((present != former).any(axis=1))
            if len(changed):
                hashes.append(present[changed])
                index.append(shared.index(hashes[-1], changed, codes_at))
                rows.append(start + changed)
            advance(stop - start)
        if rows:
            chosen = np.concatenate(rows)
            everything = len(chosen) == self.grid.texels
            place = slice(self.grid.texels) if everything else chosen
            self.store.write(place, shared.codes, np.concatenate(index))
            self._hashes[chosen] = np.concatenate(hashes)

    def read(self, start: int, stop: int) -> tuple[np.ndarray, CodesAt]:
        """The texture as a `Source`."""

        def codes_at(texel: np.ndarray, channel: np.ndarray) -> np.ndarray:
            texels, place = np.unique(start + texel, return_inverse=True)
            return self.store.read(texels)[place, channel]

        return self._hashes[start:stop], codes_at


class SharedCodes:
    """Codes of rows, each hash computed once."""

    def __init__(self, size: int):
        """size: numbers of a code."""
        self._keys, self._numbers = np.zeros(0, np.uint64), np.zeros(0, np.uint32)
        self._parts = [np.zeros((0, size), np.float32)]

    def index(self, hashes: np.ndarray, texels: np.ndarray, codes_at: CodesAt) -> np.ndarray:
        """Which code each row (n, C) of hashes (n, C) has; new ones are computed.

        texels: (n,) by which `codes_at` counts.
        """
        keys, first, label = np.unique(hashes.ravel(), return_index=True, return_inverse=True)
        place = np.searchsorted(self._keys, keys)
        number = np.zeros(len(keys), np.uint32)
        known = place < len(self._keys)
        known[known] = self._keys[place[known]] == keys[known]
        number[known] = self._numbers[place[known]]
        fresh = np.flatnonzero(~known)
        if len(fresh):
            fresh = fresh[np.argsort(first[fresh])]  # ascending texels
            number[fresh] = len(self._keys) + np.arange(len(fresh), dtype=np.uint32)
            place_in_hashes, channel = np.divmod(first[fresh], hashes.shape[1])
            codes = codes_at(texels[place_in_hashes], channel)
            self._parts.append(codes.astype(np.float32))
            fresh = np.sort(fresh)  # ascending keys
            self._keys = np.insert(self._keys, place[fresh], keys[fresh])
            self._numbers = np.insert(self._numbers, place[fresh], number[fresh])
        return number[label].reshape(hashes.shape)

    @property
    def codes(self) -> np.ndarray:
        """The codes float32 (k, size) that `index` refers to."""
        return np.concatenate(self._parts)


def coat_source(model: Model, coats: Coats, bottom: Source) -> Source:
    """The source of a coat of these parameters over a bottom."""

    def source(start: int, stop: int) -> tuple[np.ndarray, CodesAt]:
        parameters = coats(start, stop)
        hashes, bottom_at = bottom(start, stop)

        def codes_at(texel: np.ndarray, channel: np.ndarray) -> np.ndarray:
            below, few = bottom_at(texel, channel), is_few(model, len(texel))
            if len(texel) == present.size and not few:  # channels share what depends on texels
                grid = below.reshape(*present.shape, -1)
                return layer_texels(model, grid, parameters).reshape(below.shape)

            def at_rows(array: np.ndarray) -> np.ndarray:
                count, width = array.shape[:2]
                return array[texel if count > 1 else 0, channel if width > 1 else 0]

            rows = [np.broadcast_to(at_rows(column), len(texel)) for column in parameters.columns()]
            layered = transported if few else layer_texels
            return layered(model, below, CoatParameters.of_columns(rows))

        present = row_hashes([hashes, *parameters.columns()])
        return present, codes_at

    return source


def is_few(model: Model, rows: int) -> bool:
    """Whether so many different rows are layered by light transport and not by the network."""
    return rows <= FEW[model.widths]


def transported(model: Model, z: np.ndarray, coat: CoatParameters) -> np.ndarray:
    """`layer_texels` of rows z (k, L) under coats (k,), by light transport at the probe pairs."""
    coat = checks.coat(with_widths(model, coat), "the coat's", any_shape=True)
    check_ratios(model, z, coat)
    lobe = np.broadcast_to(lobes.of_coat(coat.alpha, coat.eta), (len(z), model.arch.lobe))
    lobe = lobe.astype(np.float32)[:, None]
    top = lobes.f(lobe[:, :, None], *model.networks.pairs())
    # Each row is a material of its own.
    codes = codes_of(model, transported_rests(model, z, coat)[:, None] + top, lobe)[:, 0]
    return np.where(absent(coat)[:, None], z, limit_albedo(model, codes))


def transported_rests(model: Model, z: np.ndarray, coat: CoatParameters) -> np.ndarray:
    """f float32 (k, P) [1/sr] of rows z (k, L) under coats (k,) at the probe pairs, without the
    lobes of the coats."""
    columns, pairs = np.stack(coat.columns()).astype(np.float64), model.networks.pairs()
    if model.widths == 1:
        bottoms, which = np.unique(z.astype(np.float32), axis=0, return_inverse=True)
        below = Substrate.of(Material(bottoms, model))
        return coated_values(below, which.ravel(), columns[:2], columns[2:], *pairs).T
    # Rows of one interface and of bottoms of like shapes share the directions inside.
    shapes = [*columns[[0, 1, 5]], *z.T[[*lobes.WIDTH_PLACES[2], -1]]]
    _, group = np.unique(np.stack(shapes), axis=1, return_inverse=True)
    rest = np.empty((len(z), len(pairs[0])), np.float32)
    for own in (group.ravel() == index for index in range(group.max() + 1)):
        under = CoatParameters.of_columns(columns[:, own])
        rest[own] = anisotropic_coated_f(Material(z[own], model).f, under, *pairs).T
    return rest


def row_hashes(columns: Sequence[np.ndarray], bits: int = MANTISSA_BITS) -> np.ndarray:
    """Hashes uint64 (...) of rows; the columns are arrays that broadcast to (...).

    Columns are floating-point numbers, which are rounded to `bits` of mantissa, or hashes (uint64).
    Two different rows have the same hash with a probability of 2^-64.
    """
    key: np.ndarray = np.zeros((), np.uint64)
    dropped = 23 - bits
    for column in columns:
        if column.dtype != np.uint64:
            stored = np.asarray(column + np.float32(0), np.float32).view(np.uint32)  # -0 is 0
            rounded = (stored + np.uint32(1 << (dropped - 1))) >> np.uint32(dropped)
            column = rounded.astype(np.uint64)
        key = mix64((key ^ column) + INCREMENT)
    return np.ascontiguousarray(key).reshape(key.shape)


def code_hashes(codes: np.ndarray, bits: int = MANTISSA_BITS) -> np.ndarray:
    """`row_hashes` (...) of vectors (..., size)."""
    return row_hashes(list(np.moveaxis(codes, -1, 0)), bits)
