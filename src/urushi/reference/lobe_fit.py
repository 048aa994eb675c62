"""Lobes to draw directions from, fitted to a BRDF that is known by its values alone.

For every wi of some elevation, what is minimised is the second moment of f cos / pdf, the integral
of (f cos)^2 / pdf, pdf being a mixture of two GGX lobes and a cosine lobe. It is convex in the
lobes' shares, which are found by multiplicative steps; the widths, the same for all elevations, by
trying every pair of a list.
"""

import itertools
from collections.abc import Callable
from types import ModuleType
from typing import Any, NamedTuple

import drjit as dr
import numpy as np

from urushi.physics.mixture import Mixture
from urushi.reference.rng import stream

#: Widths that are tried, a fixed ratio apart.
ALPHAS = np.geomspace(0.01, 0.8, 11)

#: Elevations, at the centres of equal intervals of the cosine; directions at each; the seed.
ELEVATIONS, SAMPLES, SEED = 16, 2048, 0

#: Steps by which shares are found: while widths are tried, and at the end.
TRIAL_STEPS, STEPS = 15, 100

#: What no lobe's share, and the cosine lobe's, falls below: f need not be what the samples show.
LEAST_SHARE, LEAST_COSINE_SHARE = 0.02, 0.1


class Lobes(NamedTuple):
    """A proposal by elevation.

    Attributes:
        alphas: (2,) widths of the GGX lobes.
        shares: (ELEVATIONS, 3) of the lobes and, last, the cosine lobe; they add up to 1. For wi
            of the cosines (i + 0.5) / ELEVATIONS.
    """

    alphas: np.ndarray
    shares: np.ndarray


def fitted(f: Callable[[Any, Any], Any], device: ModuleType) -> Lobes:
    """Fit lobes to a BRDF f(wi, wo) of three channels, evaluated in the types of `device`."""
    cost, densities = _measured(f, device)
    cosine = len(ALPHAS)
    best = min(
        itertools.combinations(range(cosine), 2),
        key=lambda pair: _shared(cost, densities[..., [*pair, cosine]], TRIAL_STEPS)[1],
    )
    shares, _ = _shared(cost, densities[..., [*best, cosine]], STEPS)
    least = np.array([LEAST_SHARE, LEAST_SHARE, LEAST_COSINE_SHARE])
    return Lobes(ALPHAS[list(best)], least + (1 - least.sum()) * shares)


def _measured(f: Callable[[Any, Any], Any], device: ModuleType) -> tuple[np.ndarray, np.ndarray]:
    """Of directions drawn from all lobes alike: cost (A, S), densities (A, S, K + 1) of lobes.

    Summed over S, cost / pdf is the integral of (f cos)^2 / pdf, relative to that of f cos squared.
    """
    count = ELEVATIONS * SAMPLES
    lane = dr.arange(device.UInt32, count)
    cos_i = (device.Float(lane // SAMPLES) + 0.5) / ELEVATIONS
    wi = device.Array3f(dr.sqrt(1 - cos_i * cos_i), 0, cos_i)
    rng = stream(device.PCG32, device.UInt64(lane), SEED)
    alphas = [device.Float(float(alpha)) for alpha in ALPHAS]
    even = Mixture([device.Float(1 / (len(alphas) + 1))] * (len(alphas) + 1), alphas)
    u = rng.next_float32(), rng.next_float32(), rng.next_float32()
    wo = even.sample(wi, u[0], u[1:])
    f_cos = (dr.mean(f(wi, wo)) * wo.z).numpy().astype(np.float64)
    lobes = [Mixture([1.0, 0.0], [alpha]).pdf(wi, wo).numpy() for alpha in alphas]
    cosine = (wo.z * dr.inv_pi).numpy()
    densities = np.stack([*lobes, cosine], axis=-1).reshape(ELEVATIONS, SAMPLES, -1)
    drawn = densities.mean(axis=-1)
    f_cos = f_cos.reshape(drawn.shape)
    albedo = (f_cos / drawn).mean(axis=1, keepdims=True)
    cost = f_cos**2 / (drawn * np.maximum(albedo, 1e-9) ** 2 * SAMPLES)
    return cost, densities


def _shared(cost: np.ndarray, densities: np.ndarray, steps: int) -> tuple[np.ndarray, float]:
    """The best shares (A, 3) for cost (A, S) and densities (A, S, 3), and their mean cost.

    The multiplicative steps of optimal design (Silvey, Titterington and Torsney 1978).
    """
    shares = np.full((len(cost), densities.shape[-1]), 1 / densities.shape[-1])
    for _ in range(steps):
        pdf = np.einsum("ask,ak->as", densities, shares)
        slope = np.einsum("as,ask->ak", cost / pdf**2, densities)
        shares *= np.sqrt(np.maximum(slope, 1e-12))
        shares /= shares.sum(axis=1, keepdims=True)
    pdf = np.einsum("ask,ak->as", densities, shares)
    return shares, float((cost / pdf).sum(axis=1).mean())
