"""The probe pairs: fixed pairs of directions at which a BRDF's values give its code."""

import functools

import numpy as np

from urushi.core.direction_sets import direction
from urushi.core.directions import directions_at_tangent, turned

#: Number of probe pairs of isotropic BRDFs.
PROBES = 256

#: The same for anisotropic BRDFs, which depend on the azimuth too.
ANISOTROPIC_PROBES = 384

#: Share of the pairs that is uniform in the logarithm of the half angle. The rest has independent
#: directions over the hemisphere.
HALF_ANGLE_SHARE = 2 / 3

#: Range of tan theta_h, largest theta_d [rad], and least cosine of either direction.
MIN_TANGENT, MAX_TANGENT = 1e-3, 4.0
MAX_DIFFERENCE = np.radians(86.0)
MIN_COSINE = 0.02


def even_points(count: int, dimension: int) -> np.ndarray:
    """Return the first points of Roberts' R sequence (2018) in the unit cube, float64."""
    base = 2.0
    for _ in range(64):  # the root of x^(d+1) = x + 1, by fixed-point iteration
        base = (1.0 + base) ** (1.0 / (dimension + 1))
    steps = base ** -np.arange(1.0, dimension + 1)
    return (0.5 + np.arange(1, count + 1)[:, None] * steps) % 1.0


def _half_angle_pairs(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Pairs log-uniform in tan theta_h; phi_d in one quadrant, by reciprocity and isotropy."""
    u = even_points(8 * count, 3)
    tan_h = MIN_TANGENT * (MAX_TANGENT / MIN_TANGENT) ** u[:, 0]
    wi, wo = directions_at_tangent(tan_h, MAX_DIFFERENCE * u[:, 1], 0.5 * np.pi * u[:, 2])
    above = np.flatnonzero((wi[:, 2] > MIN_COSINE) & (wo[:, 2] > MIN_COSINE))[:count]
    return wi[above], wo[above]


def _hemisphere_pairs(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Pairs with independent uniform cosines and a uniform difference of azimuths."""
    u = even_points(count, 3)
    cos_i, cos_o = (MIN_COSINE + (1.0 - MIN_COSINE) * u[:, i] for i in (0, 1))
    return direction(cos_i, np.zeros(count)), direction(cos_o, 0.5 * u[:, 2])


def _slope_pairs(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Pairs whose half vector has independent log-uniform slopes, in one quadrant by mirroring.

    Every second one has a log-uniform tan theta_h and a uniform azimuth instead.
    """
    u = even_points(8 * count, 4)
    log_range = np.log(MAX_TANGENT / MIN_TANGENT)
    along, across = (MIN_TANGENT * np.exp(log_range * u[:, i]) for i in (0, 3))
    radial = np.arange(len(u)) % 2 == 0
    tan_h = np.where(radial, along, np.hypot(along, across))
    azimuth = np.where(radial, 0.5 * np.pi * u[:, 3], np.arctan2(across, along))
    pairs = directions_at_tangent(tan_h, MAX_DIFFERENCE * u[:, 1], np.pi * u[:, 2])
    wi, wo = (turned(w, azimuth) for w in pairs)
    kept = (wi[:, 2] > MIN_COSINE) & (wo[:, 2] > MIN_COSINE) & (tan_h <= MAX_TANGENT)
    above = np.flatnonzero(kept)[:count]
    return wi[above], wo[above]


def _turned_hemisphere_pairs(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Pairs with independent uniform cosines and azimuths, wi in one quadrant by mirroring."""
    u = even_points(count, 4)
    wi, wo = _hemisphere_pairs(count)
    wo = turned(wo, np.pi * (u[:, 2] > 0.5))
    return turned(wi, 0.5 * np.pi * u[:, 3]), turned(wo, 0.5 * np.pi * u[:, 3])


@functools.cache
def probe_pairs(n: int = PROBES, widths: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Return the n pairs wi, wo: read-only float32 (n, 3), above the horizon, always the same.

    Two thirds have tan theta_h log-uniform in [0.001, 4] and theta_d up to 86 degrees, so that
    lobes down to alpha = 0.01 are resolved. The rest covers the hemisphere. For widths = 1, of
    isotropic BRDFs, the half vector lies in the xz plane. For widths = 2 its azimuth varies, in one
    quadrant: BRDFs are taken to be symmetric about the xz and the yz plane.
    """
    first = round(n * HALF_ANGLE_SHARE)
    if widths == 1:
        parts = _half_angle_pairs(first), _hemisphere_pairs(n - first)
    else:
        parts = _slope_pairs(first), _turned_hemisphere_pairs(n - first)
    wi, wo = (np.concatenate(sides).astype(np.float32) for sides in zip(*parts, strict=True))
    wi.flags.writeable = wo.flags.writeable = False
    return wi, wo


def pair_measure(count: int) -> np.ndarray:
    """Shares float32 (count,) of the probe pairs of two widths in integrals over pairs.

    Both cosines over the density of the pairs, a sum over their sets: every second pair of the
    first has a log-uniform tan theta_h, the others log-uniform slopes.
    """
    wi, wo = (w.astype(np.float64) for w in probe_pairs(count, 2))
    first = round(count * HALF_ANGLE_SHARE)
    h = wi + wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    x, y = np.abs(h[:, 0] / h[:, 2]), np.abs(h[:, 1] / h[:, 2])
    tangent, cos_d = np.hypot(x, y), np.clip((wi * h).sum(axis=1), 0, 1)
    sin_d = np.sqrt(np.maximum(1 - cos_d * cos_d, 1e-12))
    span = np.log(MAX_TANGENT / MIN_TANGENT)
    radial = (tangent > MIN_TANGENT) * 2 / (np.pi * span * tangent**2)
    sloped = (np.minimum(x, y) > MIN_TANGENT) / (span**2 * np.maximum(x * y, 1e-12))
    density = 0.5 * (radial + sloped) / h[:, 2] ** 3 / (MAX_DIFFERENCE * np.pi * 4 * cos_d * sin_d)
    density *= first * (tangent < MAX_TANGENT) * (np.arccos(cos_d) < MAX_DIFFERENCE)
    density += (count - first) * 2 / ((1 - MIN_COSINE) ** 2 * np.pi**2)
    measure = wi[:, 2] * wo[:, 2] / density
    return (measure / measure.sum()).astype(np.float32)
