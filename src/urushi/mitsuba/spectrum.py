"""A material's channels and the current variant's spectrum.

RGB variants have three channels, mono variants one. Spectral variants have one of two sets of
bands, each a channel:

- Constant coats have `COUNT` bands, spaced by the density of Mitsuba's wavelengths, as many in each
  band. A wavelength has the value of the band that it lies in. f of a coat is not linear in the
  colour of its bottom: bands that are wider desaturate.
- Textures, files and tables have three bands at fixed wavelengths (`RGB`). Between them values are
  linear in wavelength; textured coats follow an estimate (`plugins.estimates`).

Values are constant beyond the outermost bands, so that grey stays grey.
"""

import contextlib
import contextvars
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

#: Dominant wavelengths of the sRGB primaries, red, green, blue [nm].
RGB = (611.0, 549.0, 464.0)

#: Number of the bands of constant coats, and the wavelengths between which they lie [nm].
COUNT, ENDS = 56, (380.0, 720.0)

#: Of the density of wavelengths, the square of 1 / cosh(STEEPNESS (wavelength - CENTRE)): Mitsuba's
#: `sample_rgb_spectrum` (Radziszewski, Boryczko and Alda 2009).
STEEPNESS, CENTRE = 0.0072, 538.0

_LOWEST, _HIGHEST = np.tanh(STEEPNESS * (np.array(ENDS) - CENTRE)).tolist()

#: Middles of the bands of constant coats [nm].
_places = _LOWEST + (np.arange(COUNT) + 0.5) / COUNT * (_HIGHEST - _LOWEST)
FINE: tuple[float, ...] = tuple((CENTRE + np.arctanh(_places) / STEEPNESS).tolist())

#: The bands nearest to `RGB`.
FINE_AT_RGB = tuple(int(np.argmin(np.abs(np.array(FINE) - wavelength))) for wavelength in RGB)

#: The bands that materials are read at. Mitsuba loads plugins in several threads.
_read: contextvars.ContextVar[tuple[float, ...]] = contextvars.ContextVar("bands", default=RGB)


@contextlib.contextmanager
def bands_of(grid: object) -> Iterator[None]:
    """Read materials at the bands of textures, or of constant coats if there is no grid."""
    before = _read.set(RGB if grid else FINE)
    try:
        yield
    finally:
        _read.reset(before)


def channel_count() -> int:
    """Channels that materials are read with: 1, 3, or `COUNT` within `bands_of`."""
    if mi.is_monochromatic:
        return 1
    return len(_read.get()) if mi.is_spectral else 3


def set_bands(si) -> None:
    """Set a surface interaction's wavelengths to `RGB`, in spectral variants."""
    if mi.is_spectral:
        si.wavelengths = mi.Spectrum([*RGB, RGB[-1]])


def at_bands(si, evaluate: Callable[[], Sequence]) -> list:
    """The channels of evaluate() at a surface interaction.

    evaluate: returns the channels, of `to_channels`, at the interaction's wavelengths; spectral
        variants call it for each group of bands.
    """
    if not mi.is_spectral:
        return list(evaluate())
    lanes = dr.size_v(mi.Spectrum)
    channels: list = []
    for start in range(0, len(_read.get()), lanes):
        group = _read.get()[start : start + lanes]
        si.wavelengths = mi.Spectrum([*group, *[group[-1]] * (lanes - len(group))])
        channels += evaluate()[: len(group)]
    return channels


def to_channels(value) -> list:
    """The channels of a spectrum, as Dr.Jit floats; in spectral variants, of its wavelengths."""
    return [value[0]] if mi.is_monochromatic else list(value)


def points(uv: np.ndarray) -> "mi.SurfaceInteraction3f":
    """Surface interactions at points uv (M, 2), for textures."""
    si = dr.zeros(mi.SurfaceInteraction3f, len(uv))
    si.uv = mi.Point2f(np.ascontiguousarray(uv.T, np.float32))
    return si


def stacked(channels: Sequence[Sequence], count: int) -> np.ndarray:
    """Numbers float32 (count, C, K) from K Dr.Jit floats for each channel."""
    dr.eval(channels)
    rows = [[np.broadcast_to(value.numpy(), count) for value in channel] for channel in channels]
    return np.moveaxis(np.array(rows, np.float32), -1, 0)


def band_at(wavelengths) -> list:
    """The band of constant coats (UInt32) at each wavelength of a spectrum [nm]."""
    place = (dr.tanh(STEEPNESS * (wavelengths - CENTRE)) - _LOWEST) * (COUNT / (_HIGHEST - _LOWEST))
    return [mi.UInt32(dr.clip(x, 0, COUNT - 1)) for x in place]


def from_channels(
    values: Sequence, wavelengths, estimates: tuple[Any, Sequence] | None = None
) -> "mi.Spectrum":
    """The variant's spectrum at `wavelengths` [nm].

    Args:
        values: one, three, red first, or in spectral variants one for each wavelength.
        estimates: of three values' spectrum at the wavelengths and at `RGB`, up to a factor and a
            constant; what is left is linear in wavelength. None: all is.
    """
    if len(values) == 1:
        return mi.Spectrum(values[0])
    if mi.is_monochromatic:
        return mi.Spectrum(mi.luminance(mi.Color3f(*values)))
    if not mi.is_spectral:
        return mi.Color3f(*values)
    if len(values) > len(RGB):
        return mi.Spectrum(*values)
    long, middle, short = RGB
    above = dr.clip((wavelengths - middle) / (long - middle), 0, 1)
    below = dr.clip((middle - wavelengths) / (middle - short), 0, 1)

    def linear(red, green, blue):
        return green + above * (red - green) + below * (blue - green)

    if estimates is None:
        return linear(*values)
    at_wavelengths, at_bands = estimates
    mean, center = sum(values) / len(RGB), sum(at_bands) / len(RGB)
    covariance = sum((x - mean) * (y - center) for x, y in zip(values, at_bands, strict=True))
    slope = covariance / dr.maximum(sum(dr.square(y - center) for y in at_bands), 1e-9)
    return dr.maximum(linear(*values) + slope * (at_wavelengths - linear(*at_bands)), 0)


def from_color(color: Sequence[float]) -> dict:
    """A Mitsuba spectrum, as a dictionary, of a colour's channels as bands (spectral variants)."""
    nodes = [(100.0, color[2]), *zip(reversed(RGB), reversed(color), strict=True)]
    nodes.append((2000.0, color[0]))
    return {
        "type": "irregular",
        "wavelengths": ", ".join(str(wavelength) for wavelength, _ in nodes),
        "values": ", ".join(repr(float(value)) for _, value in nodes),
    }
