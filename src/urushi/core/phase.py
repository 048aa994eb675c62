"""The Henyey-Greenstein phase function (Henyey & Greenstein 1941)."""

import drjit as dr


def hg(cos_theta, g):
    """Phase function [1/sr] at the cosine between the propagation directions; it is its density.

    `g` in (-1, 1) is the mean of that cosine: positive scatters forward.
    """
    base = 1 + g * g - 2 * g * cos_theta
    return (0.25 / dr.pi) * (1 - g * g) / (base * dr.sqrt(base))


def sample_hg_cosine(g, u):
    """Sample the cosine between the propagation directions, by inversion; `u` in [0, 1)."""
    x = 2 * u - 1
    flat = dr.abs(g) < 1e-3
    safe_g = dr.select(flat, 1, g)
    s = (1 - g * g) / (1 + g * x)
    cosine = (1 + g * g - s * s) / (2 * safe_g)
    # The first-order expansion in g avoids 0 / 0 near isotropy.
    return dr.clip(dr.select(flat, x + 1.5 * g * (1 - x * x), cosine), -1, 1)
