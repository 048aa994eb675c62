"""The medium of a layer as the walk crosses it: its flights, and a diffuser for its deep middle.

Absorption is carried as a weight where a medium hardly scatters: of the flights that collide, the
share `scatters` scatters, and the others reach the end of the layer with a smaller weight.

In the middle of a deep lossless medium, light is diffuse: radiance is isotropic but for a part
proportional to the net flux, which is constant (Chandrasekhar 1960; Case & Zweifel 1967). There, a
sheet that scatters diffusely to both sides passes as much light as the slab that it replaces.
`KEPT` is left on both of its sides. The layer's f differs by less than 0.1 % from the whole slab's,
by doubling (tests/walk/test_medium.py), and a walk's length is bounded.
"""

from typing import Any, NamedTuple

import drjit as dr

from urushi.core.directions import from_versine
from urushi.core.namespace import DRJIT
from urushi.walk import spectral_mis

#: Collisions whose albedo is below this scatter with probability albedo / threshold; walks whose
#: throughput falls below this continue with probability throughput / threshold.
ROULETTE_THRESHOLD = 0.25

#: Optical depth that is left on each side of a sheet, and from which on a medium has a sheet; both
#: times 1 - g for g > 0.
KEPT, DEEP = 5.0, 12.0

#: Largest optical depth, times 1 - g for g > 0, of a channel of a colour without a sheet, because
#: another channel is shallow or absorbs. Deeper ones transmit less than 0.13 %.
DEEPEST = 1000.0

#: Milne's extrapolation distance of the diffuse field beyond a free surface [transport mean free
#: paths]. For HG phase functions it differs by at most 0.02.
MILNE = 0.7104

#: Largest |g|: nearer to 1, single precision would round it to 1.
LARGEST_ASYMMETRY = 1 - 2**-24

#: Depth of the sheet in its layer.
SHEET_DEPTH = 0.5


class Medium(NamedTuple):
    """Parameters are floats or colours; `scatters` is a float, `deep` a mask."""

    albedo: Any
    sigma_t: Any  # without what a sheet replaces
    g: Any
    scatters: Any  # the share of collisions that scatter
    deep: Any  # whether there is a sheet
    passed: Any  # the share of light that the sheet transmits, the rest is reflected

    @classmethod
    def of(cls, albedo: Any, sigma_t: Any, g: Any) -> "Medium":
        """The medium with these parameters, floats or colours."""
        g = dr.clip(g, -LARGEST_ASYMMETRY, LARGEST_ASYMMETRY)
        scatters = dr.minimum(spectral_mis.greatest(albedo) / ROULETTE_THRESHOLD, 1)
        reduced = 1 - dr.maximum(g, 0)
        deep = (spectral_mis.least(albedo) >= 1) & (spectral_mis.least(sigma_t * reduced) > DEEP)
        kept = 2 * KEPT / reduced
        # Two diffusers in series with half-spaces of the medium: each half-space adds its distance
        # MILNE, each Lambertian surface 2/3.
        resistance = 0.75 * (1 - g) * (sigma_t - kept) + 1 - 1.5 * MILNE
        passed = dr.select(deep, 1 / (1 + resistance), 1)
        if dr.depth_v(type(sigma_t)) > 1:
            sigma_t = dr.minimum(sigma_t, DEEPEST / reduced)
        return cls(albedo, dr.select(deep, kept, sigma_t), g, scatters, deep, passed)

    def transmittance(self, depth: Any, cos_theta: Any) -> Any:
        """Beer's law from `depth` to the top of the layer; nothing passes a sheet unscattered."""
        direct = dr.exp(-self.sigma_t * (depth / cos_theta))
        return dr.select(self.deep & (depth > SHEET_DEPTH), 0, direct)

    def end(self, depth: Any, down: Any) -> Any:
        """The depth at which a flight from `depth` without a collision ends."""
        middle = self.deep & dr.select(down, depth < SHEET_DEPTH, depth > SHEET_DEPTH)
        return dr.select(middle, SHEET_DEPTH, dr.select(down, type(depth)(1), 0))


def hg(cos_theta, g, xp=DRJIT):
    """Phase function [1/sr] at the cosine between the propagation directions; it is its density.

    `g` in (-1, 1) is the mean of that cosine: positive scatters forward.
    """
    # In single precision, rounding would give 0 or less at the peak from |g| = 0.9999 on.
    least = 1 - xp.absolute(g)
    base = xp.maximum(1 + g * g - 2 * g * cos_theta, least * least)
    return (0.25 / dr.pi) * (1 - g * g) / (base * xp.sqrt(base))


def hg_between(w, direction, g):
    """`hg` between two propagation directions, exact in the sharpest peak.

    There, single precision would round their cosine to 1.
    """
    size = dr.abs(g)
    near, far = dr.squared_norm(direction - w), dr.squared_norm(direction + w)
    # Without a choice by the sign of g, whose result would be no spectrum to Dr.Jit
    base = dr.square(1 - size) + 0.5 * ((size + g) * near + (size - g) * far)
    return (0.25 / dr.pi) * (1 - g * g) / (base * dr.sqrt(base))


def sample_hg(w, g, u1, u2):
    """Sample a direction after w, by inversion; `u1`, `u2` in [0, 1)."""
    # About w or, for g < 0, about -w, in terms that do not cancel: with x = 2 u1 - 1,
    # s = (1 - g^2) / (1 + g x) and cos = (1 + g^2 - s^2) / (2 g).
    size, forwards = dr.abs(g), g >= 0
    low, high = 2 * dr.select(forwards, u1, 1 - u1), 2 * dr.select(forwards, 1 - u1, u1)
    least = 1 - size
    relative = least / (least + size * low)
    versine = 0.5 * relative * high * (relative * (1 + size) + least)
    return from_versine(dr.select(forwards, w, -w), dr.minimum(versine, 2), 2 * dr.pi * u2)
