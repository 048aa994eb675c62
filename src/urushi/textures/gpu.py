"""Packed latent textures as files for graphics hardware, DDS and KTX2, with all mip levels.

Four bytes of a texel are a layer of an array texture of the format RGBA8, without gamma. Hardware
interpolates bytes one by one, as packed textures allow (`textures.packing`). Sources: Microsoft's
Programming Guide for DDS; KTX File Format Specification 2.0 and Data Format Specification 1.3
(Khronos).
"""

import struct
from collections.abc import Iterator

import numpy as np

from urushi.errors import ParameterError
from urushi.export.statements import LinearNumber, Texels
from urushi.textures.grid import TexelGrid
from urushi.textures.store import TextureStore

#: Numbers of the format with four bytes of 8 bits, linear: in DXGI and in Vulkan.
_DXGI_RGBA8, _VULKAN_RGBA8 = 28, 37


def texels(store: TextureStore, grid: TexelGrid) -> Texels:
    """The layout by which shaders read a texture's codes."""
    layout, packed = store.layout, store.packed
    if layout.channels not in (1, 3):
        raise ParameterError(
            f"the texture has {layout.channels} channels; only textures of one or three can be "
            "exported"
        )
    numbers = []
    for number in range(layout.size):
        offset, step = float(packed.lowest[number]), float(packed.step[number])
        high, low = layout.high[number], layout.low[number]
        channels = []
        for channel in range(layout.channels):
            start = layout.start(channel, number)
            factors: tuple[tuple[int, float], ...] = ()
            if high >= 0 and low >= 0:
                factors = ((start + high, 255 * 256 * step), (start + low, 255 * step))
            elif high >= 0:
                factors = ((start + high, 255 * step),)
            channels.append(LinearNumber(offset, factors))
        numbers.append(channels)
    return Texels(numbers, _layers(store), grid.to_texture, _filtering(grid))


def _filtering(grid: TexelGrid) -> str:
    """The wrap and filter modes that the sampler of a grid needs."""
    wraps = {"repeat": "repeat", "mirror": "mirrored repeat", "clamp": "clamp to edge"}
    kind = "nearest" if grid.nearest else "linear"
    return f"Its sampler has the wrap mode {wraps[grid.wrap]} and {kind} filtering."


def _layers(store: TextureStore) -> int:
    return max(-(-store.layout.used_bytes // 4), 1)


def _levels(store: TextureStore) -> Iterator[np.ndarray]:
    """The bytes of each level: uint8 (layers, height, width, 4)."""
    start, layers = 0, _layers(store)
    for width, height in store.levels:
        rows = store.packed.bytes[start : start + width * height, : 4 * layers]
        start += width * height
        yield rows.reshape(height, width, layers, 4).transpose(2, 0, 1, 3)


def dds(store: TextureStore) -> bytes:
    """A texture as the content of a DDS file: an array texture with all its levels."""
    width, height = store.levels[0]
    count = len(store.levels)
    flags = 0x1 | 0x2 | 0x4 | 0x8 | 0x1000 | (0x20000 if count > 1 else 0)
    caps = 0x1000 | (0x400008 if count > 1 else 0)
    header = struct.pack("<4s7I44x", b"DDS ", 124, flags, height, width, 4 * width, 0, count)
    header += struct.pack("<2I4s20x5I", 32, 0x4, b"DX10", caps, 0, 0, 0, 0)
    header += struct.pack("<5I", _DXGI_RGBA8, 3, 0, _layers(store), 0)
    levels = list(_levels(store))
    parts = [level[layer].tobytes() for layer in range(_layers(store)) for level in levels]
    return header + b"".join(parts)


def ktx2(store: TextureStore) -> bytes:
    """A texture as the content of a KTX2 file: an array texture with all its levels."""
    width, height = store.levels[0]
    levels = [level.tobytes() for level in _levels(store)]
    description = _data_format()
    start = 80 + 24 * len(levels)
    offset, places = start + len(description), []
    for level in reversed(levels):  # the smallest first
        places.append((offset, len(level), len(level)))
        offset += len(level)
    header = b"\xabKTX 20\xbb\r\n\x1a\n" + struct.pack(
        "<9I", _VULKAN_RGBA8, 1, width, height, 0, _layers(store), 1, len(levels), 0
    )
    header += struct.pack("<4I2Q", start, len(description), 0, 0, 0, 0)
    index = b"".join(struct.pack("<3Q", *place) for place in reversed(places))
    return header + index + description + b"".join(reversed(levels))


def _data_format() -> bytes:
    """The data format descriptor of four linear bytes: red, green, blue and alpha."""
    samples = [(0, 0), (8, 1), (16, 2), (24, 15)]  # first bit, and the channel's number
    block = struct.pack("<4B4x8B", 1, 0, 1, 0, 4, 0, 0, 0, 0, 0, 0, 0)
    for bit, channel in samples:
        block += struct.pack("<HBB4xII", bit, 7, channel, 0, 255)
    size = 8 + len(block)
    return struct.pack("<IIHH", 4 + size, 0, 2, size) + block
