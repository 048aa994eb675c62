"""The picture of a material in a notebook: a lit sphere without noise."""

import functools

import numpy as np

from urushi.eval import metrics, sheet, sphere
from urushi.material import Material

#: Number of pictures that are remembered: a notebook shows the same material several times.
REMEMBERED = 32


@functools.lru_cache(REMEMBERED)
def png(material: Material) -> bytes:
    """A sphere in Urushi's studio as a PNG file, 128 pixels across, transparent around it.

    material: of one or three channels. The tangents of an anisotropic one point away from the
    middle. A picture takes about two seconds.
    """
    import mitsuba as mi  # lazily: a notebook may never show a material

    alpha = sphere.mask().astype(float)[..., None]
    pixels = np.concatenate([metrics.shown(sheet.picture(material)), alpha], axis=-1)
    stream = mi.MemoryStream()
    bitmap = mi.Bitmap((255 * pixels + 0.5).astype(np.uint8), mi.Bitmap.PixelFormat.RGBA)
    bitmap.write(stream, mi.Bitmap.FileFormat.PNG)
    return bytes(stream.raw_buffer())
