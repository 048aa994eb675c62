"""Latent textures in few bytes: every number of a texel as 8 or 16 bits of its range.

Fan et al. (2022) keep the numbers of a latent texture in floating point. Here each number of a code
is a fixed-point number between its least and its greatest value in the texture. A texel takes a
power of two of bytes. The numbers with the greatest effect on f have 16 bits, so that the others
change it by less than `LIMIT`, and as many more as fit; the others have 8. Sixteen bits are two
separate bytes, high and low: interpolation is linear, so that a renderer may interpolate all bytes
in the same way and add them afterwards. Numbers that are equal in the whole texture take no bytes;
numbers that are equal in all channels are stored once.
"""

from typing import NamedTuple

import numpy as np

from urushi.nets.weights import Model
from urushi.parallel import fill_blocks

#: Error of f by all numbers of 8 bits together, at most.
LIMIT = 7e-4

#: Codes by which the errors are measured, and stride of the probe pairs.
SAMPLE, PAIR_STRIDE = 32, 3


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

    @property
    def places(self) -> np.ndarray:
        """Where a texel holds the low and the high byte of each number, (channels * size * 2).

        A byte that is zero everywhere, the last of a texel and one more, has no place in the texel.
        """
        result = np.full((self.channels, self.size, 2), self.texel_bytes)
        for channel, number in np.ndindex(self.channels, self.size):
            start, high, low = self.start(channel, number), self.high[number], self.low[number]
            if low >= 0:
                result[channel, number] = start + low, start + high
            elif high >= 0:
                result[channel, number, 0] = start + high
        return result.ravel()


class Texture(NamedTuple):
    """Packed codes of texels."""

    layout: TexelLayout
    bytes: np.ndarray  # uint8 (T, B), B = `TexelLayout.texel_bytes`
    lowest: np.ndarray  # float32 (size,): a number's smallest value
    step: np.ndarray  # float32 (size,): the size of one step

    @classmethod
    def of(cls, model: Model, codes: np.ndarray) -> "Texture":
        """Pack codes float32 (T, channels, size) of a model."""
        lowest, highest = codes.min(axis=(0, 1)), codes.max(axis=(0, 1))
        errors = rounding_errors(model, codes.reshape(-1, codes.shape[-1]), lowest, highest)
        same = (codes == codes[:, :1]).all(axis=(0, 1))
        layout = texel_layout(codes.shape[1], errors, lowest == highest, same)
        step = ((highest - lowest) / layout.levels).astype(np.float32)
        texels = np.zeros((len(codes), layout.texel_bytes), np.uint8)
        texture = cls(layout, texels, lowest, step)
        fill_blocks(texels, texture._bytes, codes)
        return texture

    def codes(self) -> np.ndarray:
        """The codes float32 (T, channels, size)."""
        layout = self.layout
        codes = np.empty((len(self.bytes), layout.channels * layout.size), np.float32)
        fill_blocks(codes, self._codes, self.bytes)
        return codes.reshape(len(codes), layout.channels, layout.size)

    def _bytes(self, codes: np.ndarray) -> np.ndarray:
        """Bytes (T, B) of codes (T, channels, size)."""
        layout = self.layout
        inverse = (1 / np.where(self.step > 0, self.step, 1)).astype(np.float32)
        highest = layout.levels.astype(np.float32)
        # One row for each texel: NumPy is slow along axes as short as a code.
        lowest, inverse, highest = (
            np.tile(x, layout.channels) for x in (self.lowest, inverse, highest)
        )
        flat = codes.astype(np.float32, order="C").reshape(len(codes), len(lowest))
        levels = np.rint((flat - lowest) * inverse).clip(0, highest)
        # A texel's bytes are chosen from the low and the high byte of every number.
        both = levels.astype("<u2").view(np.uint8)
        source = np.zeros(layout.texel_bytes + 1, np.intp)
        source[layout.places] = np.arange(both.shape[1])
        result = np.zeros((len(codes), layout.texel_bytes), np.uint8)
        result[:, : layout.used_bytes] = both.take(source[: layout.used_bytes], axis=1)
        return result

    def _codes(self, rows: np.ndarray) -> np.ndarray:
        """Codes (T, channels * size) of bytes (T, B)."""
        padded = np.pad(rows, [(0, 0), (0, 1)])
        levels = padded.take(self.layout.places, axis=1).view("<u2").astype(np.float32)
        lowest, step = (np.tile(x, self.layout.channels) for x in (self.lowest, self.step))
        return lowest + levels * step


def texel_layout(
    channels: int, errors: np.ndarray, constant: np.ndarray, same: np.ndarray
) -> TexelLayout:
    """The layout of texels of codes (channels, size).

    Args:
        channels: codes in a texel.
        errors: (size,) error of f by 8 bits of each number, see `rounding_errors`.
        constant, same: (size,) which numbers are the same in the whole texture, and in all channels
            of a texel.
    """
    size = len(errors)
    kept = [number for number in range(size) if not constant[number]]
    price = {number: 1 if same[number] else channels for number in kept}
    order = sorted(price, key=lambda number: -errors[number])
    left = sum(price.values())
    # Rounding errors are independent: their squares add up.
    squares = np.cumsum(np.square([errors[number] for number in order[::-1]]))
    needed = sum(squares > LIMIT**2)
    least = left + sum(price[number] for number in order[:needed])
    count = max(4, 1 << (least - 1).bit_length())
    left = count - left
    chosen = []
    for number in order:
        if price[number] <= left:
            left -= price[number]
            chosen.append(number)
    alike = tuple(same.tolist())
    parts = [0, 0]  # bytes of a channel's part, and of the part that channels share
    high, low = [-1] * size, [-1] * size
    for places, numbers in ((high, kept), (low, sorted(chosen))):
        for number in numbers:
            places[number] = parts[alike[number]]
            parts[alike[number]] += 1
    stride, shared = parts
    return TexelLayout(channels, size, tuple(high), tuple(low), alike, shared, stride, count)


def rounding_errors(
    model: Model, codes: np.ndarray, lowest: np.ndarray, highest: np.ndarray
) -> np.ndarray:
    """Mean relative error (size,) of f by 8 bits of each number.

    codes: (k, size), of which a few are tried. lowest, highest: (size,) the ranges.
    """
    wi, wo = (w[::PAIR_STRIDE] for w in model.networks.pairs())

    def log_f(codes: np.ndarray) -> np.ndarray:
        return np.log(model.networks.f(codes[:, None], wi, wo))

    some = codes[:: -(-len(codes) // SAMPLE)].astype(np.float32)
    before = log_f(some)
    shift = (highest - lowest).astype(np.float32) / (4 * 255)  # mean distance to the nearest level
    errors = np.zeros(len(shift), np.float32)
    for number in np.flatnonzero(shift):
        moved = some.copy()
        # towards the middle, where numbers of the lobe remain valid
        middle = 0.5 * (lowest[number] + highest[number])
        moved[:, number] += np.where(some[:, number] < middle, shift[number], -shift[number])
        errors[number] = np.abs(log_f(moved) - before).mean()
    return errors
