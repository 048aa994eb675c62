"""Thin-film iridescence (OpenPBR Surface 1.1.1, 3.3): the reflectance of a filmed facet.

Light inside the film interferes. The reflectance at one wavelength is a Fourier series in the phase
that the light gains on its way through the film. A colour is the integral of every term over a
sensitivity curve, in closed form.

Source: Belcour and Barla 2017, A practical extension to microfacet theory for the modeling of
varying iridescence. The argument `xp` has the functions of the arrays.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from urushi.core import fresnel
from urushi.core.namespace import NUMPY, Namespace
from urushi.nets import lobe

#: Terms of the series; the next is at most 2 % of the light for a film of index 2.
ORDERS = 5

#: Largest reflectance of a metal that is taken as a complex index, which has no bound at one.
LARGEST_REFLECTANCE = 0.9999

#: Cosine at which the reflectance of a filmed metal is about its mean over the facets that diffuse
#: light meets.
MEAN_COSINE = 0.66

#: Least argument of roots, whose derivatives have no bound at zero.
LEAST = 1e-12

#: Gaussians of the sensitivities in the wave number, one for Y and Z and two for X: row of XYZ,
#: share of the row, mean [1/m] and variance [1/m^2] (Belcour and Barla 2017, their code).
_GAUSSIANS = (
    (0, 0.8462, 1.6810e6, 4.3278e9),
    (0, 0.1538, 2.2399e6, 4.5282e9),
    (1, 1.0, 1.7953e6, 9.3046e9),
    (2, 1.0, 2.2084e6, 6.6121e9),
)

#: Linear sRGB from XYZ, its rows scaled such that a reflectance of one is white.
_RGB = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)
_RGB = _RGB / _RGB.sum(axis=1, keepdims=True)

#: Mean of cos(2 pi D / wavelength + shift) over a channel: a function of D [um] and the shift.
Response = Callable[[Any, Any, Any], Any]


class Film(NamedTuple):
    """A film."""

    eta: Any  # its index relative to the medium above
    index: Any  # its index of refraction
    thickness: Any  # [micrometres]


class Below(NamedTuple):
    """Complex index eta + i k of the material below the film, relative to the medium above it."""

    eta: Any
    k: Any = 0.0


def color_response(weights: np.ndarray) -> Response:
    """The response of a channel.

    weights: (3,) of X, Y and Z, of sum one.
    """

    def response(path: Any, shift: Any, xp: Namespace) -> Any:
        phase = 2e-6 * math.pi * path
        total = 0.0 * path
        for row, share, mean, variance in _GAUSSIANS:
            fading = xp.exp(-variance * phase * phase)
            total = total + float(weights[row]) * share * (fading * xp.cos(mean * phase + shift))
        return total

    return response


#: The responses of the channels of linear sRGB, and of a monochromatic channel, Y.
RGB = [color_response(row) for row in _RGB]
LUMINANCE = color_response(np.array([0.0, 1.0, 0.0]))


def wavelength_response(wavelength: Any) -> Response:
    """The response at a wavelength [nm]."""
    return lambda path, shift, xp: xp.cos(path * (2e3 * math.pi / wavelength) + shift)


def reflectance(
    cosine: Any, film: Film, below: Below, response: Response, xp: Namespace = NUMPY
) -> Any:
    """Reflectance of a facet under a film, for unpolarised light.

    cosine: of the angle between the light above the film and the facet, in [0, 1].

    Returns:
        In [0, 1]; 1 where the film reflects totally.
    """
    sine2 = xp.maximum(1 - cosine * cosine, 0) / (film.eta * film.eta)
    inside = xp.sqrt(xp.maximum(1 - sine2, 1e-8))
    path = 2 * film.index * film.thickness * inside
    # Squared index of the material below relative to the film, and its component along z.
    scale = 1 / (film.eta * film.eta)
    eta, k = below
    square = (eta * eta - k * k) * scale, 2 * eta * k * scale
    along = _root((square[0] - sine2, square[1]), xp)
    front = (
        (cosine - film.eta * inside) / (cosine + film.eta * inside),
        (film.eta * cosine - inside) / (film.eta * cosine + inside),
    )
    back = (
        _ratio((inside - along[0], -along[1]), (inside + along[0], along[1])),
        _ratio(
            (square[0] * inside - along[0], square[1] * inside - along[1]),
            (square[0] * inside + along[0], square[1] * inside + along[1]),
        ),
    )
    total = 0.0 * path
    for r, (real, imaginary) in zip(front, back, strict=True):
        total = total + 0.5 * _series(r, real, imaginary, path, response, xp)
    seen = xp.where(sine2 < 1, total, 1.0)
    return xp.clip(seen, 0, 1)


def metal_index(f0: Any, tint: Any, xp: Namespace = NUMPY) -> Below:
    """The complex index of a metal, relative to the medium above, by its F82-tint term.

    All indices n + i k of one reflectance at normal incidence lie on a curve. The point on it has
    the reflectance of F82-tint at 82 degrees, within a few percent, or is the end of the curve.

    f0: reflectance at normal incidence, in [0, 1]. tint: specular_color, in [0, 1].

    Source: Gulbrandsen 2014, Artist friendly metallic Fresnel, equations 1 to 4, for the curve.
    """
    r = xp.clip(f0, 0.001, LARGEST_REFLECTANCE)
    root = xp.sqrt(r)
    least, most = (1 - r) / (1 + r), (1 + root) / (1 - root)
    c = fresnel.EDGE_COSINE
    target = xp.maximum(fresnel.f82(c, r, tint, xp), fresnel.exact(c, most, 0 * r, xp))
    # For |n + i k| well above one both polarisations are quotients of linear functions of n, and
    # their mean at a given reflectance is the root of a quadratic equation.
    q, s = (1 + r) / (1 - r), 1 - c * c
    above, under = (q - c, c * (q * c - 1)), (q + c, c * (q * c + 1))
    twice = above[0] * under[1] + above[1] * under[0] - 2 * target * under[0] * under[1]
    linear = s * (above[0] - under[1] + under[0] - above[1] - 2 * target * (under[0] - under[1]))
    constant = -2 * s * s * (1 - target)
    root = xp.sqrt(xp.maximum(linear * linear - 4 * twice * constant, 0))
    n = xp.clip((linear + root) / (-4 * twice), least, most)
    excess = r * (n + 1) * (n + 1) - (n - 1) * (n - 1)
    return Below(n, xp.sqrt(xp.maximum(excess, 0) / (1 - r)))


class FilmedMetal(NamedTuple):
    """A rough metal under a film, in air."""

    alpha: float  # GGX width
    eta: tuple[float, float, float]  # complex index eta + i k of the metal for red, green and blue
    k: tuple[float, float, float]
    ior: float  # of the film
    thickness: float  # of the film [micrometres]

    def reflectance(self, cosine: np.ndarray) -> np.ndarray:
        """Reflectance (N, 3) of a facet at cosines (N,)."""
        film = Film(self.ior, self.ior, self.thickness)
        columns = zip(map(Below, self.eta, self.k), RGB, strict=True)
        return np.stack([reflectance(cosine, film, *pair) for pair in columns], axis=-1)

    def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """The BRDF (N, 3) [1/sr] of directions (N, 3) above the horizon."""
        white = np.array([self.alpha, 1, 1, 0, 1.5, 0], np.float32)
        cosine = 0.5 * np.linalg.norm(wi + wo, axis=-1)
        return lobe.f(white, wi, wo)[:, None] * self.reflectance(np.minimum(cosine, 1))


def _series(
    front: Any, real: Any, imaginary: Any, path: Any, response: Response, xp: Namespace
) -> Any:
    """The reflectance of one polarisation, by the real amplitude of the film's front.

    real, imaginary: of the amplitude at its back.

    Source: Belcour and Barla 2017, equations 7 to 10.
    """
    magnitude = xp.sqrt(xp.maximum(real * real + imaginary * imaginary, LEAST))
    angle = xp.arctan2(imaginary, real)
    passed = 1 - front * front
    both = -front * magnitude
    rest = passed * passed * magnitude * magnitude / xp.maximum(1 - both * both, 1e-6)
    total = front * front + rest
    factor = rest - passed
    for order in range(1, ORDERS + 1):
        factor = factor * both
        total = total + 2 * factor * response(order * path, order * angle, xp)
    return total


def _root(z: tuple[Any, Any], xp: Namespace) -> tuple[Any, ...]:
    """The root of a complex number of positive imaginary part, with positive parts."""
    length = xp.sqrt(xp.maximum(z[0] * z[0] + z[1] * z[1], LEAST))
    return tuple(xp.sqrt(xp.maximum(length + x, LEAST) / 2) for x in (z[0], -z[0]))


def _ratio(a: tuple[Any, Any], b: tuple[Any, Any]) -> tuple[Any, Any]:
    """The quotient of two complex numbers."""
    scale = 1 / (b[0] * b[0] + b[1] * b[1])
    return (a[0] * b[0] + a[1] * b[1]) * scale, (a[1] * b[0] - a[0] * b[1]) * scale
