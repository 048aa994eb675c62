"""Tabulated BRDFs as bottoms of the random walk, with sampling by fitted lobes.

A table is one of `measured.tabulated`: trilinear between bin centres over sqrt(theta_h), theta_d
and phi_d (Rusinkiewicz 1998). Directions are drawn from a mixture of two GGX lobes and a cosine
lobe. The lobes minimise the second moment of f cos / pdf, the integral of (f cos)^2 / pdf, for wi
of several elevations. The moment is convex in the lobes' shares, which multiplicative steps
optimise; the two widths, common to all elevations, are found by trial of all pairs from a list.
"""

import importlib
import itertools
from collections.abc import Callable
from types import ModuleType
from typing import Any, NamedTuple

import drjit as dr
import numpy as np

from urushi.core.directions import half_difference
from urushi.core.mixture import Mixture
from urushi.core.namespace import DRJIT
from urushi.core.random import stream
from urushi.walk.monte_carlo import backend

#: GGX widths that are tried, in a geometric series.
ALPHAS = np.geomspace(0.01, 0.8, 11)

#: Number of elevations of wi, at the centres of equal intervals of the cosine; samples of wo at
#: each; seed.
ELEVATIONS, SAMPLES, SEED = 16, 2048, 0

#: Steps of the optimisation of shares: for each trial of widths, and for the final ones.
TRIAL_STEPS, STEPS = 15, 100

#: Least share of a GGX lobe, and of the cosine lobe, because samples may miss parts of f.
MIN_SHARE, MIN_COSINE_SHARE = 0.02, 0.1


#: Numbers that one load reads.
LANES = 4


class Lobes(NamedTuple):
    """A proposal for each elevation of wi, whose cosines are (i + 0.5) / ELEVATIONS."""

    alphas: np.ndarray  # (2,) widths of the GGX lobes
    shares: np.ndarray  # (ELEVATIONS, 3) of the GGX lobes and of the cosine lobe, of sum 1


def fit_lobes(f: Callable[[Any, Any], Any], device: ModuleType) -> Lobes:
    """Fit lobes to a BRDF f(wi, wo) of one channel, evaluated in the types of `device`."""
    # `SAMPLES` directions for each elevation, from all lobes with equal shares.
    lane = dr.arange(device.UInt32, ELEVATIONS * SAMPLES)
    cos_i = (device.Float(lane // SAMPLES) + 0.5) / ELEVATIONS
    wi = device.Array3f(dr.sqrt(1 - cos_i * cos_i), 0, cos_i)
    rng = stream(device.PCG32, device.UInt64(lane), SEED)
    alphas = [device.Float(float(alpha)) for alpha in ALPHAS]
    uniform = Mixture([device.Float(1 / (len(alphas) + 1))] * (len(alphas) + 1), alphas)
    u = rng.next_float32(), rng.next_float32(), rng.next_float32()
    wo = uniform.sample(wi, u[0], u[1:])
    f_cos = (f(wi, wo) * wo.z).numpy().astype(np.float64)
    lobes = [Mixture([1.0, 0.0], [alpha]).pdf(wi, wo).numpy() for alpha in alphas]
    lobes.append((wo.z * dr.inv_pi).numpy())
    densities = np.stack(lobes, axis=-1).reshape(ELEVATIONS, SAMPLES, -1)
    drawn = densities.mean(axis=-1)
    f_cos = f_cos.reshape(drawn.shape)
    albedo = (f_cos / drawn).mean(axis=1, keepdims=True)
    # The sum over samples of cost / pdf estimates the integral of (f cos)^2 / pdf, relative to the
    # squared integral of f cos.
    cost = f_cos**2 / (drawn * np.maximum(albedo, 1e-9) ** 2 * SAMPLES)
    cosine = len(ALPHAS)
    best = min(
        itertools.combinations(range(cosine), 2),
        key=lambda pair: _best_shares(cost, densities[..., [*pair, cosine]], TRIAL_STEPS)[1],
    )
    shares, _ = _best_shares(cost, densities[..., [*best, cosine]], STEPS)
    least = np.array([MIN_SHARE, MIN_SHARE, MIN_COSINE_SHARE])
    return Lobes(ALPHAS[list(best)], least + (1 - least.sum()) * shares)


def _best_shares(cost: np.ndarray, densities: np.ndarray, steps: int) -> tuple[np.ndarray, float]:
    """Optimal shares (A, 3) for cost (A, S) and densities (A, S, 3), and their mean cost.

    Uses the multiplicative algorithm of optimal design (Silvey, Titterington and Torsney 1978).
    """
    shares = np.full((len(cost), densities.shape[-1]), 1 / densities.shape[-1])
    for _ in range(steps):
        pdf = np.einsum("ask,ak->as", densities, shares)
        slope = np.einsum("as,ask->ak", cost / pdf**2, densities)
        shares *= np.sqrt(np.maximum(slope, 1e-12))
        shares /= shares.sum(axis=1, keepdims=True)
    pdf = np.einsum("ask,ak->as", densities, shares)
    return shares, float((cost / pdf).sum(axis=1).mean())


class Tabulated:
    """A tabulated BRDF on any backend: a `urushi.walk.bottoms.bottom.Bottom`."""

    def __init__(self, table: np.ndarray, weights: np.ndarray | None = None):
        """Fit the proposal.

        table: float32 (theta_h, theta_d, phi_d, C) [1/sr], finite. C is 3 for walks.
        weights: (C,) of the channels in the mean that the lobes are fitted to; None: equal ones.
        """
        self._table = table
        device = backend()
        count = table.shape[3]
        lookup = Lookup(device, table)
        mean = [1 / count] * count if weights is None else weights.tolist()

        def f(wi: Any, wo: Any) -> Any:
            return sum(x * weight for x, weight in zip(lookup(wi, wo), mean, strict=True))

        self._lobes = fit_lobes(f, device)
        self._on: dict[ModuleType, Reflector] = {}

    def on(self, scalar: type) -> "Reflector":
        """The BRDF in the memory of the backend that a Dr.Jit float type belongs to."""
        device = importlib.import_module(scalar.__module__)
        if device not in self._on:
            self._on[device] = Reflector(Lookup(device, self._table), self._lobes, device)
        return self._on[device]

    def f_pdf(self, wi: Any, wo: Any) -> tuple[Any, Any]:
        """BRDF [1/sr], a colour, and the density of `sample` at wo, zero below the horizon."""
        reflector = self.on(type(wi.z))
        return reflector.f(wi, wo), reflector.mixture(wi.z).pdf(wi, wo)

    def sample(self, wi: Any, u0: Any, u1: Any, u2: Any) -> tuple[Any, Any, Any]:
        """Draw wo by three uniform numbers; returns (wo, f cos / pdf, pdf)."""
        reflector = self.on(type(wi.z))
        mixture = reflector.mixture(wi.z)
        wo = mixture.sample(wi, u0, (u1, u2))
        pdf = mixture.pdf(wi, wo)
        f = reflector.f(wi, wo)
        return wo, dr.select(pdf > 0, f * (wo.z / pdf), 0), pdf


class Reflector:
    """A tabulated BRDF on one backend."""

    def __init__(self, lookup: "Lookup", lobes: Lobes, device: ModuleType):
        self._lookup, self._device = lookup, device
        self._nodes = len(lobes.shares)
        self._shares = device.Float(_padded(lobes.shares))
        self._alphas = [device.Float(float(alpha)) for alpha in lobes.alphas]
        dr.make_opaque(self._shares, self._alphas)

    def channels(self, wi: Any, wo: Any) -> list:
        """BRDF [1/sr] of each channel, zero where a direction is below the horizon."""
        above = (wi.z > 0) & (wo.z > 0)
        return [dr.select(above, x, 0) for x in self._lookup(wi, wo)]

    def f(self, wi: Any, wo: Any) -> Any:
        """`channels` of three, as a colour."""
        return self._device.Array3f(*self.channels(wi, wo))

    def mixture(self, cos_i: Any) -> Mixture:
        """The proposal for wi of cosine cos_i."""
        index, share = _between_centres(cos_i * self._nodes, self._nodes)
        low, high = (dr.gather(self._device.Array4f, self._shares, i) for i in (index, index + 1))
        shares = dr.lerp(low, high, share)
        return Mixture([shares[i] for i in range(len(self._alphas) + 1)], self._alphas)


class Lookup:
    """Interpolation in the table: f(wi, wo), a list of channels, for directions above the horizon.

    The Dr.Jit counterpart of `measured.tabulated.interpolated`.
    """

    def __init__(self, device: ModuleType, table: np.ndarray):
        self._device = device
        self._shape, self._channels = table.shape[:3], table.shape[3]
        self._bins = device.Float(_padded(table))
        dr.eval(self._bins)

    def __call__(self, wi: Any, wo: Any) -> list:
        half, difference, turn = self._shape
        theta_h, theta_d, phi_d = half_difference(wi, wo, DRJIT)
        i, x = _between_centres(dr.sqrt(theta_h * (2 * dr.inv_pi)) * half, half)
        j, y = _between_centres(theta_d * (2 * dr.inv_pi * difference), difference)
        k = phi_d * (dr.inv_pi * turn) - 0.5  # periodic
        before = dr.floor(k)
        z = k - before
        before = type(i)(dr.select(before < 0, turn - 1, before))
        after = dr.select(before + 1 >= turn, 0, before + 1)
        loads = -(-self._channels // LANES)
        result: list[Any] = [0] * loads
        for a, weight_i in ((i, 1 - x), (i + 1, x)):
            for b, weight_j in ((j, 1 - y), (j + 1, y)):
                row = (a * difference + b) * turn
                for c, weight_k in ((before, 1 - z), (after, z)):
                    weight = weight_i * weight_j * weight_k
                    for load in range(loads):
                        at = (row + c) * loads + load
                        result[load] += dr.gather(self._device.Array4f, self._bins, at) * weight
        return [x for load in result for x in load][: self._channels]


def _between_centres(position: Any, bins: int) -> tuple[Any, Any]:
    """The lower of the two bins around a position in [0, bins], and the weight of the upper."""
    position = dr.clip(position - 0.5, 0, bins - 1)
    lower = dr.minimum(dr.floor(position), bins - 2)
    return dr.uint32_array_t(type(position))(lower), position - lower


def _padded(rows: np.ndarray) -> np.ndarray:
    """Rows (..., C) as flat float32, padded to a multiple of the numbers that a load reads."""
    padding = [(0, 0)] * (rows.ndim - 1) + [(0, -rows.shape[-1] % LANES)]
    return np.pad(rows.astype(np.float32), padding).ravel()
