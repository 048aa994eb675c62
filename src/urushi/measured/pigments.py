"""Paints by their measured pigments: K and S of Kubelka and Munk, as media of coats.

`pigments.csv` has K and S of 19 artist's acrylics (Berns 2016), each paint undiluted, relative to
the S of titanium white. They were fitted to opaque films of the paint and of its mixture with
white. A mixture has the sums of K and S (Duncan 1940), wavelength by wavelength. Per channel,

    R = 1 + K/S - sqrt((K/S)^2 + 2 K/S)                      of the opaque mixture, to linear sRGB,
    S = mean of S over the channel's sensitivity,  K = S (1 - R)^2 / (2 R),                     (1)
    scattering (1 - g) = 4/3 S,  absorption = 1/2 K                   (Mudgett and Richards 1971).

Limits. The measurements are relative: S of titanium white is assumed, `WHITE` at thickness 1, which
is a film of 40 um if S is 0.15 per um. g is not known from diffuse light, and is 0: media of equal
scattering times 1 - g look alike. Colours outside sRGB are clipped to `GAMUT`. Thin films of a
coloured paint have one depth per channel where the paint has a spectrum.
"""

from collections.abc import Iterable, Mapping
from functools import cache
from importlib.resources import files
from numbers import Real
from typing import Any

import numpy as np

from urushi.errors import ParameterError
from urushi.measured.rgl import srgb_weights

#: Scattering S of titanium white at thickness 1: an optical depth of 8.
WHITE = 6.0

#: Least and greatest reflectance of an opaque mixture in a channel.
GAMUT = 0.004, 0.996

#: Wavelengths of the measurements [nm].
WAVELENGTHS = np.arange(380.0, 751.0, 10.0)


def pigment(paint: str | Mapping[str, float]) -> dict[str, Any]:
    """The medium of a measured paint or a mixture, as arguments of `urushi.coat` and `layer`.

    ``urushi.coat(bottom, ior=1.5, **urushi.pigment({"titanium white": 4, "cobalt blue": 1}))``

    Args:
        paint: name of an acrylic, or parts by mass, zero or more, by name. The names are bone
            black, titanium white, bismuth vanadate yellow, hansa yellow opaque, diarylide yellow,
            cadmium orange, pyrrole orange, cadmium red light, pyrrole red, quinacridone red,
            quinacridone magenta, dioxazine purple, ultramarine blue, cobalt blue, cerulean blue
            chromium, phthalo blue green shade, phthalo blue red shade, phthalo green blue shade and
            phthalo green yellow shade.

    Returns:
        `albedo`, `sigma_t` and `g`, each for red, green and blue, at thickness 1: about 40 um of
        dry paint. `urushi.measured.pigments` says how, and how far to trust it. The data are those
        of Berns 2016 (MIT licence, in the data file).

    Raises:
        ParameterError: a name is unknown, or no part is above 0, or one is negative.
    """
    if not isinstance(paint, str | Mapping):
        raise ParameterError(f"paint is {paint!r}; give a name, or a dictionary of parts by name")
    parts = {paint: 1.0} if isinstance(paint, str) else dict(paint)
    names = list(paints())
    if unknown := [name for name in parts if name not in names]:
        raise ParameterError(f"no paint is named '{unknown[0]}'; the paints are {', '.join(names)}")
    numbers = all(isinstance(part, Real) for part in parts.values())
    if not numbers or not parts or min(parts.values()) < 0 or not 0 < sum(parts.values()) < np.inf:
        raise ParameterError(f"the parts of a mixture are {parts}; give numbers above 0")
    k, s = mixed(parts, np.array([list(parts.values())]))
    scattering, absorption = 4 / 3 * s[0], k[0] / 2
    depth = scattering + absorption
    return {
        "albedo": tuple((scattering / depth).tolist()),
        "sigma_t": tuple(depth.tolist()),
        "g": (0.0, 0.0, 0.0),
    }


def mixed(names: Iterable[str], parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """K and S (M, 3) of mixtures at thickness 1, equation 1; parts (M, P) of the P paints."""
    table = np.stack([paints()[name] for name in names])
    shares = parts / parts.sum(axis=1, keepdims=True)
    k, s = np.moveaxis(np.tensordot(shares, table, 1), 1, 0)
    weights = srgb_weights(WAVELENGTHS)
    sensitivity = np.maximum(weights, 0)
    reflectance = np.clip(opaque(k / s) @ weights, *GAMUT)
    s = WHITE * (s @ sensitivity) / sensitivity.sum(axis=0)
    return s * (1 - reflectance) ** 2 / (2 * reflectance), s


def opaque(ratio: np.ndarray) -> np.ndarray:
    """Reflectance of an opaque film of K/S, inside (Kubelka and Munk 1931)."""
    return 1 + ratio - np.sqrt(ratio * (ratio + 2))


def over(k: np.ndarray, s: np.ndarray, ground: np.ndarray) -> np.ndarray:
    """Reflectance of films of K and S over a ground, inside (Kubelka 1948, equation 21)."""
    a = 1 + k / s
    b = np.sqrt(a * a - 1)
    turn = b / np.tanh(b * s)
    return (1 - ground * (a - turn)) / (a - ground + turn)


@cache
def paints() -> dict[str, np.ndarray]:
    """K and S (2, W) of every paint by its name, relative to the S of titanium white."""
    text = (files("urushi.measured") / "pigments.csv").read_text(encoding="ascii")
    rows = [line.split(",") for line in text.splitlines() if not line.startswith("#")]
    pairs = zip(rows[::2], rows[1::2], strict=True)
    return {k[0]: np.array([k[3:], s[3:]], np.float64) for k, s in pairs}
