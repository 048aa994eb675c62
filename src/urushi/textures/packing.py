"""Latent textures in few bytes: every number of a texel as 8 or 16 bits of its range.

Fan et al. (2022) keep the numbers of a latent texture in floating point. Here each number of a code
is a fixed-point number between its least and its greatest value in the texture. A texel takes a
power of two of bytes. The numbers with the greatest effect on f have 16 bits, as many as fit, the
gain first; the others have 8. Sixteen bits are two separate bytes, high and low: interpolation is
linear, so that a renderer may interpolate all bytes in the same way and add them afterwards.
"""

from typing import NamedTuple

import numpy as np

from urushi.checks import MIN_ALPHA, CoatParameters
from urushi.nets.networks import UrushiNetworks
from urushi.nets.weights import Model
from urushi.parallel import fill_blocks

#: Least number of 16-bit numbers in a channel: the gain and the next most important one.
LEAST_FINE_NUMBERS = 2

#: The measurement of importance: number of random coats, maximum number of direction pairs, seed of
#: its random numbers, and change of a number, as the share of its range that 8 bits resolve.
COATS, PAIRS, SEED, STEP = 256, 64, 0, 1 / 255


class TexelLayout(NamedTuple):
    """Positions of the numbers of a texel's codes in its bytes.

    Attributes:
        channels, size: codes in a texel, and numbers in a code.
        low: (size,) for a channel: the position of each number's low byte, or -1. The high bytes
            come first, in the order of the numbers.
        stride: bytes of a channel; channel c begins at byte c * stride.
        texel_bytes: a power of two, at least 4; bytes at the end may be unused.
    """

    channels: int
    size: int
    low: tuple[int, ...]
    stride: int
    texel_bytes: int

    @property
    def levels(self) -> np.ndarray:
        """Steps (size,) from the smallest to the largest value."""
        return np.where(np.array(self.low) < 0, 255, 65535)


class PackedTexels(NamedTuple):
    """A packed texture.

    Attributes:
        bytes: uint8 (..., B), B = `TexelLayout.texel_bytes`.
        lowest, step: float32 (size,): a number's smallest value, and the size of one step.
    """

    bytes: np.ndarray
    lowest: np.ndarray
    step: np.ndarray


def texel_layout(model: Model, channels: int) -> TexelLayout:
    """The layout of texels of codes (channels, size) of a model."""
    size = model.arch.latent
    count = 4
    while count < channels * (size + LEAST_FINE_NUMBERS):
        count *= 2
    fine = min(count // channels - size, size)
    second = {number: size + index for index, number in enumerate(importance_order(model)[:fine])}
    low = tuple(second.get(number, -1) for number in range(size))
    return TexelLayout(channels, size, low, size + fine, count)


def importance_order(model: Model) -> list[int]:
    """The numbers of a code by their effect on f, the greatest first.

    Codes of networks without a gain keep their order.
    """
    if model.fingerprint not in _importance:
        _importance[model.fingerprint] = (
            measure_importance(model) if isinstance(model.networks, UrushiNetworks) else []
        )
    return _importance[model.fingerprint] or list(range(model.arch.latent))


#: By fingerprint. Those of the shipped networks are stored, because measuring takes a second.
_importance: dict[str, list[int]] = {
    "18db0cb6471c": [  # base
        0, 8, 29, 3, 20, 15, 23, 2, 9, 11, 4, 6, 21, 16, 13, 28,
        26, 14, 17, 22, 25, 27, 30, 18, 24, 1, 31, 19, 12, 10, 5, 7,
    ],
    "670684d2b9d0": [2, 0, 16, 8, 7, 5, 13, 11, 1, 10, 4, 3, 12, 14, 15, 6, 17, 9],  # small
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


def with_ranges(
    layout: TexelLayout, texels: np.ndarray, lowest: np.ndarray, highest: np.ndarray
) -> PackedTexels:
    """Packed texels of bytes (T, B), with ranges from lowest to highest (size,)."""
    bottom = lowest.astype(np.float32)
    return PackedTexels(texels, bottom, ((highest - bottom) / layout.levels).astype(np.float32))


def pack_rows(
    layout: TexelLayout, packed: PackedTexels, rows: slice | np.ndarray, codes: np.ndarray
) -> None:
    """Overwrite rows of a packed texture (T, B) by codes (n, channels, size) within its ranges."""
    part = packed.bytes[rows]  # a view if `rows` is a slice, else a copy
    fill_blocks(part, lambda z: _bytes(layout, packed, z), codes)
    if not isinstance(rows, slice):
        packed.bytes[rows] = part


def pack_codes(layout: TexelLayout, packed: PackedTexels, codes: np.ndarray) -> np.ndarray:
    """Bytes (n, `layout.stride`) of single codes (n, size), each one channel of a texel."""
    one = layout._replace(channels=1, texel_bytes=layout.stride)
    result = np.empty((len(codes), layout.stride), np.uint8)
    fill_blocks(result, lambda z: _bytes(one, packed, z[:, None]), codes)
    return result


def _bytes(layout: TexelLayout, packed: PackedTexels, codes: np.ndarray) -> np.ndarray:
    inverse = 1 / np.where(packed.step > 0, packed.step, 1)
    levels = np.rint((codes - packed.lowest) * inverse)
    whole = np.clip(levels, 0, layout.levels).astype(np.uint16)
    result = np.zeros((len(codes), layout.texel_bytes), np.uint8)
    low = np.array(layout.low)
    fine = np.flatnonzero(low >= 0)
    for channel in range(layout.channels):
        start = channel * layout.stride
        numbers = whole[:, channel]
        high = numbers.copy()
        high[:, fine] >>= 8
        result[:, start : start + layout.size] = high
        result[:, start + low[fine]] = numbers[:, fine] & 255
    return result


def in_ranges(packed: PackedTexels, layout: TexelLayout, codes: np.ndarray) -> bool:
    """Whether codes (T, channels, size) lie within a packed texture's ranges or one step beyond."""
    slack = packed.step
    highest = packed.lowest + layout.levels * packed.step
    return bool((codes >= packed.lowest - slack).all() and (codes <= highest + slack).all())


def unpack(layout: TexelLayout, packed: PackedTexels) -> np.ndarray:
    """Codes float32 (T, channels, size) of bytes (T, B)."""
    codes = np.empty((len(packed.bytes), layout.channels, layout.size), np.float32)
    fill_blocks(
        codes.reshape(len(codes), -1), lambda rows: _codes(layout, packed, rows), packed.bytes
    )
    return codes


def unpack_serial(layout: TexelLayout, packed: PackedTexels) -> np.ndarray:
    """`unpack` on the calling thread alone."""
    return _codes(layout, packed, packed.bytes).reshape(-1, layout.channels, layout.size)


def _codes(layout: TexelLayout, packed: PackedTexels, rows: np.ndarray) -> np.ndarray:
    """Codes (T, channels * size) of bytes (T, B)."""
    codes = np.empty((len(rows), layout.channels, layout.size), np.float32)
    low = np.array(layout.low)
    fine = np.flatnonzero(low >= 0)
    for channel in range(layout.channels):
        start = channel * layout.stride
        levels = rows[:, start : start + layout.size].astype(np.float32)
        levels[:, fine] *= 256
        levels[:, fine] += rows[:, start + low[fine]]
        codes[:, channel] = packed.lowest + levels * packed.step
    return codes.reshape(len(rows), -1)
