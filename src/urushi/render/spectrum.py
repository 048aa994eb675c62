"""A material's channels and the current variant's spectrum.

RGB variants have three channels, mono variants one. Spectral variants treat the three channels as
bands at fixed wavelengths (`BANDS`): values are linear in wavelength between them and constant
beyond, so that grey stays grey.
"""

from collections.abc import Sequence

import drjit as dr
import mitsuba as mi

#: Dominant wavelengths of the sRGB primaries, red, green, blue [nm].
BANDS = (611.0, 549.0, 464.0)


def channel_count() -> int:
    """Channels that materials have in the current variant: 1 or 3."""
    return 1 if mi.is_monochromatic else 3


def set_bands(si) -> None:
    """Set a surface interaction's wavelengths to the bands', in spectral variants."""
    if mi.is_spectral:
        lanes = dr.size_v(mi.Spectrum)
        si.wavelengths = mi.Spectrum([*BANDS, *[BANDS[-1]] * (lanes - len(BANDS))])


def to_channels(value) -> list:
    """The channels of a spectrum that was evaluated with `set_bands`, as Dr.Jit floats."""
    return [value[i] for i in range(channel_count())]


def from_channels(values: Sequence, wavelengths) -> "mi.Spectrum":
    """The variant's spectrum of one or three channels, red first, at `wavelengths` [nm]."""
    if len(values) == 1:
        return mi.Spectrum(values[0])
    if mi.is_monochromatic:
        return mi.Spectrum(mi.luminance(mi.Color3f(*values)))
    if not mi.is_spectral:
        return mi.Color3f(*values)
    red, green, blue = values
    long, middle, short = BANDS
    above = dr.clip((wavelengths - middle) / (long - middle), 0, 1)
    below = dr.clip((middle - wavelengths) / (middle - short), 0, 1)
    return green + above * (red - green) + below * (blue - green)


def from_color(color: Sequence[float]) -> dict:
    """A Mitsuba spectrum, as a dictionary, of a colour's channels as bands (spectral variants)."""
    nodes = [(100.0, color[2]), *zip(reversed(BANDS), reversed(color), strict=True)]
    nodes.append((2000.0, color[0]))
    return {
        "type": "irregular",
        "wavelengths": ", ".join(str(wavelength) for wavelength, _ in nodes),
        "values": ", ".join(repr(float(value)) for _, value in nodes),
    }
