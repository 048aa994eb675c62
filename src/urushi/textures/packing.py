"""Latent textures in few bytes: every number of a texel as 8 or 16 bits of its range.

Fan et al. (2022) keep the numbers of a latent texture in floating point. Here each number of a code
is a fixed-point number between its least and its greatest value in the texture. A texel takes a
power of two of bytes. The numbers with the greatest effect on f have 16 bits, as many as fit, the
lobe's width and the gain first; the others have 8. Sixteen bits are two separate bytes, high and
low: interpolation is linear, so that a renderer may interpolate all bytes in the same way and add
them afterwards. Numbers that are equal in the whole texture take no bytes; numbers that are equal
in all channels are stored once.
"""

from typing import NamedTuple

import numpy as np

from urushi.checks import MIN_ALPHA, CoatParameters, Widths
from urushi.nets.lobe import WIDTH_PLACES
from urushi.nets.weights import Model
from urushi.parallel import fill_blocks

#: Least number of 16-bit numbers in a channel: the lobe's width and the gain, or its two widths.
LEAST_FINE_NUMBERS = 2

#: Texels of shared codes that a core packs at once.
SHARED_ROWS = 1 << 14

#: The measurement of importance: number of random coats, maximum number of direction pairs, seed of
#: its random numbers, and change of a number, as the share of its range that 8 bits resolve.
COATS, PAIRS, SEED, STEP = 256, 64, 0, 1 / 255


class TexelLayout(NamedTuple):
    """Positions of the numbers of a texel's codes in its bytes.

    A texel has a part for the numbers that are the same in all channels, and then one part for each
    channel. Numbers that are the same in the whole texture have no bytes.
    """

    channels: int  # codes in a texel
    size: int  # numbers in a code
    high: tuple[int, ...]  # (size,) place of a number's high byte in its part; -1: it has no byte
    low: tuple[int, ...]  # (size,) place of its low byte; -1: it has 8 bits or none
    same: tuple[bool, ...]  # (size,) whether it is the same in all channels of a texel
    shared: int  # bytes of the part that the channels share
    stride: int  # bytes of a channel's part
    texel_bytes: int  # a power of two, at least 4; bytes at the end may be unused

    @property
    def levels(self) -> np.ndarray:
        """Steps (size,) from the smallest to the largest value."""
        return np.where(np.array(self.low) < 0, 255, 65535)

    @property
    def constant(self) -> np.ndarray:
        """Whether each number (size,) is the same in the whole texture."""
        return np.array(self.high) < 0

    @property
    def used_bytes(self) -> int:
        """Bytes of a texel that hold numbers."""
        return self.shared + self.channels * self.stride

    def start(self, channel: int, number: int) -> int:
        """Where the part that holds a number of a channel begins."""
        return 0 if self.same[number] else self.shared + channel * self.stride


class PackedTexels(NamedTuple):
    """A packed texture."""

    bytes: np.ndarray  # uint8 (..., B), B = `TexelLayout.texel_bytes`
    lowest: np.ndarray  # float32 (size,): a number's smallest value
    step: np.ndarray  # float32 (size,): the size of one step


def texel_layout(
    model: Model,
    channels: int,
    constant: np.ndarray | None = None,
    same: np.ndarray | None = None,
) -> TexelLayout:
    """The layout of texels of codes (channels, size) of a model.

    constant, same: (size,) which numbers are the same in the whole texture, and in all channels of
    a texel. None: none are.
    """
    size = model.arch.latent
    constant = np.zeros(size, bool) if constant is None else constant
    same = np.zeros(size, bool) if same is None else same
    kept = [number for number in range(size) if not constant[number]]
    price = {number: 1 if same[number] else channels for number in kept}
    order = [number for number in importance_order(model) if number in price]
    left = sum(price.values())
    count, least = 4, left + sum(price[number] for number in order[:LEAST_FINE_NUMBERS])
    while count < least:
        count *= 2
    left = count - left
    fine = []
    for number in order:
        if price[number] <= left:
            left -= price[number]
            fine.append(number)
    parts: dict[bool, int] = {True: 0, False: 0}
    high, low = [-1] * size, [-1] * size
    for places, numbers in ((high, kept), (low, sorted(fine))):
        for number in numbers:
            places[number] = parts[bool(same[number])]
            parts[bool(same[number])] += 1
    return TexelLayout(
        channels,
        size,
        tuple(high),
        tuple(low),
        tuple(bool(value) for value in same),
        parts[True],
        parts[False],
        count,
    )


def importance_order(model: Model) -> list[int]:
    """The numbers of a code by their effect on f, the greatest first."""
    if model.fingerprint not in _importance:
        first = (*WIDTH_PLACES[model.widths], model.arch.lobe)  # the lobe's widths, and the gain
        order = measure_importance(model)
        _importance[model.fingerprint] = [*first, *(i for i in order if i not in first)]
    return _importance[model.fingerprint]


#: By fingerprint. Those of the shipped networks are stored, because measuring takes a second.
_importance: dict[str, list[int]] = {
    "b7e9657aa0a4": [
        0, 6, 4, 18, 23, 15, 10, 8, 7, 22, 16, 9, 19, 13, 14, 12, 11, 21, 20, 17, 5, 3, 2, 1,
    ],
    "ac5fbe8d97db": [
        0, 6, 7, 4, 17, 15, 11, 22, 12, 25, 13, 21, 19, 24, 16, 9, 20, 14, 8, 18, 23,
        26, 10, 5, 3, 2, 1,
    ],
}  # fmt: skip


def measure_importance(model: Model) -> list[int]:
    """`importance_order` by the change of ln f, in codes of random coats over diffuse bottoms."""
    rng = np.random.default_rng(SEED)
    wi, wo = model.networks.pairs()
    f = np.repeat(rng.uniform(0, 1 / np.pi, (COATS, 1)), len(wi), axis=1).astype(np.float32)
    columns = (
        np.exp(rng.uniform(np.log(MIN_ALPHA), 0, COATS)),
        rng.uniform(1.2, 2, COATS),
        rng.random(COATS),
        rng.exponential(1, COATS),
        rng.uniform(-0.8, 0.8, COATS),
    )
    coat = CoatParameters(*(column.astype(np.float32) for column in columns))
    if model.widths == 2:
        across = np.exp(rng.uniform(np.log(MIN_ALPHA), 0, COATS)).astype(np.float32)
        coat = coat._replace(alpha=Widths(coat.alpha, across))
    networks = model.networks
    z = networks.layer(networks.encode(f), coat)
    chosen = slice(None, None, len(wi) // PAIRS + 1)
    wi, wo = wi[chosen], wo[chosen]
    before = np.log(networks.f(z[:, None], wi, wo))
    shift = STEP * np.ptp(z, axis=0)
    change = []
    for number in range(z.shape[1]):
        moved = z.copy()
        moved[:, number] += shift[number]
        change.append(np.abs(np.log(networks.f(moved[:, None], wi, wo)) - before).mean())
    return [int(number) for number in np.argsort(change)[::-1]]


def pack(
    layout: TexelLayout,
    codes: np.ndarray,
    index: np.ndarray,
    others: np.ndarray,
    lowest: np.ndarray,
    highest: np.ndarray,
) -> PackedTexels:
    """Pack texels of shared codes, and other texels after them.

    Args:
        codes: (k, size); index (n, channels) chooses one for each texel and channel. Every code is
            packed once.
        others: (m, channels, size).
        lowest, highest: (size,) ranges of all codes.
    """
    bottom = lowest.astype(np.float32)
    step = ((highest - bottom) / layout.levels).astype(np.float32)
    empty = np.zeros((len(index) + len(others), layout.texel_bytes), np.uint8)
    packed = PackedTexels(empty, bottom, step)
    width = layout.shared + layout.stride
    one = layout._replace(channels=1, texel_bytes=width)
    parts = np.empty((len(codes), width), np.uint8)
    fill_blocks(parts, lambda z: _bytes(one, packed, z[:, None]), codes)

    def texels(index: np.ndarray) -> np.ndarray:
        own = parts[:, layout.shared :][index].reshape(len(index), -1)
        return np.concatenate([parts[index[:, 0], : layout.shared], own], axis=1)

    fill_blocks(empty[: len(index), : layout.used_bytes], texels, index, rows=SHARED_ROWS)
    fill_blocks(empty[len(index) :], lambda z: _bytes(layout, packed, z), others)
    return packed


def _bytes(layout: TexelLayout, packed: PackedTexels, codes: np.ndarray) -> np.ndarray:
    inverse = (1 / np.where(packed.step > 0, packed.step, 1)).astype(np.float32)
    highest = layout.levels.astype(np.float32)
    # One row for each texel: NumPy is slow along axes as short as a code.
    lowest, inverse, highest = (
        np.tile(x, layout.channels) for x in (packed.lowest, inverse, highest)
    )
    levels = codes.astype(np.float32, order="C").reshape(len(codes), len(lowest))
    levels -= lowest
    levels *= inverse
    np.rint(levels, out=levels)
    np.maximum(levels, 0, out=levels)
    np.minimum(levels, highest, out=levels)
    # A texel's bytes are chosen from the low and the high byte of every number.
    both = levels.astype("<u2").view(np.uint8)
    source = np.zeros(layout.texel_bytes + 1, np.intp)
    source[_places(layout)] = np.arange(both.shape[1])
    result = np.zeros((len(codes), layout.texel_bytes), np.uint8)
    result[:, : layout.used_bytes] = both.take(source[: layout.used_bytes], axis=1)
    return result


def _places(layout: TexelLayout) -> np.ndarray:
    """Where a texel holds the low and the high byte of each number, (channels * size * 2).

    A byte that is zero everywhere, the last of a texel and one more, has no place in the texel.
    """
    result = np.full((layout.channels, layout.size, 2), layout.texel_bytes)
    for channel in range(layout.channels):
        for number, (high, low) in enumerate(zip(layout.high, layout.low, strict=True)):
            start = layout.start(channel, number)
            if low >= 0:
                result[channel, number] = start + low, start + high
            elif high >= 0:
                result[channel, number, 0] = start + high
    return result.ravel()


def unpack(layout: TexelLayout, packed: PackedTexels) -> np.ndarray:
    """Codes float32 (T, channels, size) of bytes (T, B)."""
    codes = np.empty((len(packed.bytes), layout.channels * layout.size), np.float32)
    fill_blocks(codes, lambda rows: _codes(layout, packed, rows), packed.bytes)
    return codes.reshape(len(codes), layout.channels, layout.size)


def _codes(layout: TexelLayout, packed: PackedTexels, rows: np.ndarray) -> np.ndarray:
    """Codes (T, channels * size) of bytes (T, B)."""
    padded = np.pad(rows, [(0, 0), (0, 1)])
    levels = padded.take(_places(layout), axis=1).view("<u2").astype(np.float32)
    return np.tile(packed.lowest, layout.channels) + levels * np.tile(packed.step, layout.channels)
