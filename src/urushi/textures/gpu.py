"""Textures as files for graphics hardware, DDS and KTX2: packed latent textures and tables of ln f.

Four bytes of a texel of a latent texture are a layer of an array texture of the format RGBA8,
without gamma. Hardware interpolates bytes one by one, as packed textures allow
(`textures.packing`). A table of ln f is a 3D texture of the format RGBA16F (`export.rest`).
Sources: Microsoft's Programming Guide for DDS; KTX File Format Specification 2.0 and Data Format
Specification 1.3 (Khronos).
"""

import struct
from typing import NamedTuple

import numpy as np

from urushi.errors import ParameterError
from urushi.export.statements import Texels
from urushi.textures.packing import Texture
from urushi.textures.store import TexelGrid


class Image(NamedTuple):
    """The content of a file."""

    texels: np.ndarray  # uint8 or float16 (layers or depth, height, width, 4)
    is_volume: bool  # whether it is a 3D texture, not an array texture

    @property
    def is_half(self) -> bool:
        return self.texels.dtype == np.float16


def texture_image(texture: Texture, grid: TexelGrid) -> Image:
    """The image of a latent texture: uint8 (layers, height, width, 4)."""
    layers = _layers(texture)
    rows = texture.bytes[:, : 4 * layers].reshape(grid.height, grid.width, layers, 4)
    return Image(rows.transpose(2, 0, 1, 3), is_volume=False)


def texels(texture: Texture) -> Texels:
    """The layout by which shaders read a texture's codes."""
    layout = texture.layout
    if layout.channels not in (1, 3):
        raise ParameterError(
            f"the texture has {layout.channels} channels; only textures of one or three can be "
            "exported"
        )
    numbers = []
    for number, (high, low) in enumerate(zip(layout.high, layout.low, strict=True)):
        offset, step = float(texture.lowest[number]), float(texture.step[number])
        factors = {high: 255 * step} if low < 0 else {high: 255 * 256 * step, low: 255 * step}
        factors.pop(-1, None)  # what is the same in the whole texture has no bytes
        starts = (layout.start(channel, number) for channel in range(layout.channels))
        numbers.append(
            [(offset, tuple((start + x, y) for x, y in factors.items())) for start in starts]
        )
    sampler = "Its sampler has the wrap mode repeat and linear filtering."
    whole = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)  # the unit square of uv
    return Texels(numbers, _layers(texture), whole, sampler)


def _layers(texture: Texture) -> int:
    return max(-(-texture.layout.used_bytes // 4), 1)


def dds(image: Image) -> bytes:
    """The content of a DDS file."""
    depth, height, width, _ = image.texels.shape
    flags = 0x1 | 0x2 | 0x4 | 0x8 | 0x1000 | (0x800000 if image.is_volume else 0)
    pitch, slices = width * image.texels[0, 0, 0].nbytes, depth if image.is_volume else 0
    header = struct.pack("<4s7I44x", b"DDS ", 124, flags, height, width, pitch, slices, 1)
    header += struct.pack(
        "<2I4s20x5I", 32, 0x4, b"DX10", 0x1000, 0x200000 if image.is_volume else 0, 0, 0, 0
    )
    kind = 10 if image.is_half else 28  # DXGI_FORMAT_R16G16B16A16_FLOAT, R8G8B8A8_UNORM
    dimension, layers = (4, 1) if image.is_volume else (3, depth)
    header += struct.pack("<5I", kind, dimension, 0, layers, 0)
    return header + image.texels.tobytes()


def ktx2(image: Image) -> bytes:
    """The content of a KTX2 file."""
    depth, height, width, _ = image.texels.shape
    description, start = _data_format(image.is_half), 104
    offset = -(-(start + len(description)) // 8) * 8
    padding = bytes(offset - start - len(description))
    kind, size = (97, 2) if image.is_half else (37, 1)  # VK_FORMAT_R16G16B16A16_SFLOAT, R8…_UNORM
    slices, layers = (depth, 0) if image.is_volume else (0, depth)
    header = b"\xabKTX 20\xbb\r\n\x1a\n" + struct.pack(
        "<9I", kind, size, width, height, slices, layers, 1, 1, 0
    )
    header += struct.pack("<4I2Q", start, len(description), 0, 0, 0, 0)
    index = struct.pack("<3Q", offset, image.texels.nbytes, image.texels.nbytes)
    return header + index + description + padding + image.texels.tobytes()


def _data_format(is_half: bool) -> bytes:
    """The data format descriptor of four linear numbers: red, green, blue and alpha."""
    bits, sign = (16, 0xC0) if is_half else (8, 0)  # 0xC0: signed floats
    lowest, highest = (0xBF800000, 0x3F800000) if is_half else (0, 255)  # -1 and 1 as floats
    block = struct.pack("<4B4x8B", 1, 0, 1, 0, bits // 2, 0, 0, 0, 0, 0, 0, 0)
    for place, channel in enumerate((0, 1, 2, 15)):  # the numbers of the channels
        block += struct.pack("<HBB4xII", bits * place, bits - 1, channel | sign, lowest, highest)
    size = 8 + len(block)
    return struct.pack("<IIHH", 4 + size, 0, 2, size) + block
