"""A material's channels and the current variant's spectrum.

RGB variants have three channels, mono variants one. Spectral variants have one of two sets of
bands, each a channel:

- Constant coats have `COUNT` bands, spaced by the density of Mitsuba's wavelengths, as many in each
  band. A wavelength has the value of the band that it lies in. f of a coat is not linear in the
  colour of its bottom: bands that are wider desaturate.
- Texels, files and tables have three bands, which are read at fixed wavelengths (`RGB`). They are
  linear sRGB: their spectrum is `of_rgb`. Materials over axes have one for wavelengths.

Grey is the same at all wavelengths.
"""

import contextlib
import contextvars
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core.namespace import DRJIT, NUMPY, Namespace

#: Dominant wavelengths of the sRGB primaries, red, green, blue [nm].
RGB = (611.0, 549.0, 464.0)

#: Wavelengths that Mitsuba samples [nm].
SAMPLED = (360.0, 830.0)

#: Number of the bands of constant coats, and the wavelengths between which they lie [nm].
COUNT, ENDS = 56, (380.0, 720.0)

#: Of the density of wavelengths, the square of 1 / cosh(STEEPNESS (wavelength - CENTRE)): Mitsuba's
#: `sample_rgb_spectrum` (Radziszewski, Boryczko and Alda 2009).
STEEPNESS, CENTRE = 0.0072, 538.0


def _sum_below(wavelength: Any, xp: Any) -> Any:
    """The integral of the density up to a wavelength [nm], up to a factor and a constant.

    xp: the module NumPy, Dr.Jit or `math`.
    """
    return xp.tanh(STEEPNESS * (wavelength - CENTRE))


def _wavelength_of(sum_below: Any, xp: Any) -> Any:
    """The inverse of `_sum_below`."""
    return CENTRE + xp.atanh(sum_below) / STEEPNESS


_LOWEST, _HIGHEST = _sum_below(np.array(ENDS), np).tolist()
_FIRST, _LAST = _sum_below(np.array(SAMPLED), np).tolist()

#: Middles of the bands of constant coats [nm].
FINE: tuple[float, ...] = tuple(
    _wavelength_of(_LOWEST + (np.arange(COUNT) + 0.5) / COUNT * (_HIGHEST - _LOWEST), np).tolist()
)

#: Spectra of red and blue under `of_rgb`: the middle of the step [nm], its slope [1/nm], and the
#: least value. They solve the equations that red, and blue, is that colour under D65.
RED, BLUE = (591.638151, 0.691987131, 0.0175948803), (489.161910, -0.116379780, 0.0145232678)

#: Wavelengths [nm] at which spectra of colours are given to Mitsuba.
NODES = np.array([100.0, *range(400, 702, 2), 2000.0])

#: Least share of light that is taken to cross a medium twice.
LEAST_PASSED = 1e-12

#: The bands nearest to `RGB`.
FINE_AT_RGB = tuple(int(np.argmin(np.abs(np.array(FINE) - wavelength))) for wavelength in RGB)

#: The middle of uv, where what is the same everywhere is read.
MIDDLE = np.full((1, 2), 0.5)

#: The bands that materials are read at, or an array of one wavelength for each of as many points
#: along u. Mitsuba loads plugins in several threads.
_read: contextvars.ContextVar[tuple[float, ...] | np.ndarray] = contextvars.ContextVar(
    "bands", default=RGB
)


@contextlib.contextmanager
def reading_at(bands: tuple[float, ...] | np.ndarray) -> Iterator[None]:
    """Read materials at bands, `FINE` for constant coats.

    bands: an array of wavelengths [nm] is for points uv whose u lie in the middles of as many equal
        parts, each point at its own wavelength: one channel.
    """
    before = _read.set(bands)
    try:
        yield
    finally:
        _read.reset(before)


def channel_count() -> int:
    """Channels that materials are read with: 1, 3, or as many as `reading_at` says."""
    if mi.is_monochromatic or isinstance(_read.get(), np.ndarray):
        return 1
    return len(_read.get()) if mi.is_spectral else 3


def at_bands(si, evaluate: Callable[..., Any]) -> list:
    """The channels of evaluate() at a surface interaction.

    evaluate: returns the channels, maybe as a spectrum, at the interaction's wavelengths; spectral
        variants call it for each group of bands.
    """
    if not mi.is_spectral:
        return list(evaluate())
    bands = _read.get()
    if isinstance(bands, np.ndarray):
        at = mi.UInt32(si.uv.x * len(bands))
        nanometres = dr.gather(mi.Float, mi.Float(bands), at)
        si.wavelengths = mi.Spectrum(*_sampled_with(nanometres, dr))
        return list(evaluate())[:1]
    channels: list = []
    for band in bands:
        si.wavelengths = mi.Spectrum(_sampled_with(band, math))
        channels += list(evaluate())[:1]
    return channels


def _sampled_with(wavelength: Any, xp: Any) -> list:
    """A wavelength [nm], and the others that Mitsuba samples together with it.

    Some BSDFs depend on all wavelengths of a ray: the tints of `principled` are relative to a
    luminance, which Mitsuba estimates from them.

    xp: as of `_sum_below`.
    """
    lanes = dr.size_v(mi.Spectrum)
    place = (_sum_below(wavelength, xp) - _FIRST) / (_LAST - _FIRST)
    moved = [place + k / lanes for k in range(1, lanes)]
    others = [_FIRST + (x - xp.floor(x)) * (_LAST - _FIRST) for x in moved]
    return [wavelength, *(_wavelength_of(x, xp) for x in others)]


def mean(value) -> Any:
    """The mean over the channels; a number as it is."""
    return value if dr.depth_v(value) == 1 else dr.mean(value)


def luminance(color, wavelengths) -> Any:
    """The luminance of a spectrum, in spectral variants as Mitsuba estimates it of a ray's."""
    return mi.luminance(color, wavelengths) if mi.is_spectral else mi.luminance(color)


def points(uv: np.ndarray) -> "mi.SurfaceInteraction3f":
    """Surface interactions at points uv (M, 2), for textures."""
    si = dr.zeros(mi.SurfaceInteraction3f, len(uv))
    si.uv = mi.Point2f(np.ascontiguousarray(uv.T, np.float32))
    return si


def channels_at(uv: np.ndarray, read: Callable[..., Any]) -> np.ndarray:
    """Numbers float32 (C, M) at points uv (M, 2).

    read: from surface interactions and active lanes to its channels, maybe as a spectrum.
    """
    si = points(uv)
    channels = at_bands(si, lambda: read(si, True))
    dr.eval(channels)
    return np.array([np.broadcast_to(x.numpy(), len(uv)) for x in channels], np.float32)


def band_at(wavelengths) -> list:
    """The band of constant coats (UInt32) at each wavelength of a spectrum [nm]."""
    place = (_sum_below(wavelengths, dr) - _LOWEST) * (COUNT / (_HIGHEST - _LOWEST))
    return [mi.UInt32(dr.clip(x, 0, COUNT - 1)) for x in place]


def of_rgb(channels: Iterable, wavelengths, xp: Namespace = DRJIT) -> Any:
    """A spectrum of a linear sRGB colour under D65, linear in its channels, at `wavelengths` [nm].

    The spectra of red, green and blue are not negative and add up to one, so that grey stays grey
    and the spectrum lies between the channels, as those of Mallett and Yuksel 2019. They are nearly
    steps: where one of them is about one, the others are about zero. Powers and exponentials of a
    spectrum have therefore nearly the colour of that function of the channels.
    """
    scale = 1 - RED[2] - BLUE[2]
    reddish, bluish = (
        least + scale * xp.falling_logistic(slope * (middle - wavelengths))
        for middle, slope, least in (RED, BLUE)
    )
    red, green, blue = channels
    return green + reddish * (red - green) + bluish * (blue - green)


#: From the values of `of_rgb` at `RGB` to the colour.
_TO_COLOR = np.linalg.inv(
    np.stack([of_rgb(color, np.array(RGB), NUMPY) for color in np.eye(3)], axis=1)
).tolist()


def from_channels(values: Sequence, wavelengths, *, colors: bool = False) -> "mi.Spectrum":
    """The variant's spectrum at `wavelengths` [nm].

    Args:
        values: one, three, red first, or in spectral variants one for each wavelength.
        colors: whether three values are linear sRGB, as in files; else they were read at `RGB`.
    """
    if len(values) == 1:
        return mi.Spectrum(values[0])
    if mi.is_monochromatic:
        return mi.Spectrum(mi.luminance(mi.Color3f(*values)))
    if not mi.is_spectral:
        return mi.Color3f(*values)
    if len(values) > len(RGB):
        return mi.Spectrum(*values)
    if not colors:
        values = [sum(a * x for a, x in zip(row, values, strict=True)) for row in _TO_COLOR]
    return mi.Spectrum(dr.maximum(of_rgb(values, wavelengths), 0))


def at_nodes(color: Sequence[float] | np.ndarray) -> np.ndarray:
    """`of_rgb` of channels of zero or more at `NODES`."""
    return np.maximum(of_rgb(np.asarray(color), NODES, NUMPY), 0)  # rounding


def from_nodes(values: np.ndarray) -> dict:
    """A Mitsuba spectrum, as a dictionary, of values at `NODES`."""
    if np.ptp(values) <= 1e-9 * values.max():
        return {"type": "uniform", "value": float(values[0])}
    return {
        "type": "irregular",
        "wavelengths": ", ".join(map(str, NODES)),
        "values": ", ".join(map(repr, values.tolist())),
    }


def from_color(color: Sequence[float] | np.ndarray, *, power: float = 1.0) -> dict:
    """A Mitsuba spectrum of a colour of channels of zero or more, as a dictionary.

    power: of the spectrum, which has the colour of that power of the channels.
    """
    return from_nodes(at_nodes(np.asarray(color) ** power) ** (1 / power))


def from_depth(depth: Sequence[float] | np.ndarray) -> dict:
    """As `from_color`, of the optical depth of a medium that absorbs.

    Light that has crossed the medium twice has the colour of the channels.
    """
    passed = at_nodes(np.exp(-2 * np.asarray(depth)))
    return from_nodes(-np.log(np.maximum(passed, LEAST_PASSED)) / 2)
