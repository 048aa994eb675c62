"""The linear functions of codes from which the weights of proposals follow, by their variance.

One sample f cos / pdf of a proposal has the variance of ``m - 1``, relative to the squared albedo
a^2, where m is the integral of (f cos)^2 / pdf over a^2. The mean of ln(m - 1 + `NOISE`) over
materials and directions wi is minimised (L-BFGS). The gain of a code has the factor one, and the
other numbers are decorrelated first.
"""

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from scipy.optimize import minimize

from urushi.core.mixture import reflection_pdf
from urushi.core.namespace import NUMPY, arrays, components
from urushi.core.quadrature import AZIMUTH_NODES, half_vector_rule
from urushi.nets import lobe as lobes
from urushi.nets import proposal
from urushi.nets.networks import Networks
from urushi.nets.transmittance import of_lobe

#: Polar angles and azimuths of wi [degrees] by the number of GGX widths, and materials at most.
ANGLES = {1: (0, 15, 30, 45, 55, 65, 75, 82, 87), 2: (5, 30, 55, 70, 83)}
AZIMUTHS = {1: (0,), 2: (0, 45, 90)}
MATERIALS = {1: 1200, 2: 400}

#: Variance below which noise does not matter.
NOISE = 0.02

#: Penalty of the squared factors of decorrelated numbers.
PENALTY = 1e-4

#: Steps of the optimisation.
STEPS = 400


class Problem(NamedTuple):
    """Materials (S) at directions wi (A) with nodes wo (M)."""

    lobe: np.ndarray  # float32 (S, 1, N)
    rest: np.ndarray  # float32 (S, 1, K), codes without lobes
    inputs: np.ndarray  # (S, 1, K - 1), decorrelated numbers of the rests without gains
    factor: np.ndarray  # (K - 1, K - 1) which decorrelates them
    squares: np.ndarray  # float32 (S, A, M) (f cos / albedo)^2 and the weight of the node
    # Densities of all lobes and of cosines: float32 (A, M), or (S, A, M).
    densities: list[np.ndarray]
    cosine: np.ndarray  # float32 (A,) of wi
    passed: np.ndarray  # float32 (S, A) T(wi) of `nets.transmittance`


def fit_proposal(networks: Networks, codes: np.ndarray) -> dict[str, np.ndarray]:
    """The parameters ``proposal.weight``, ``.bias`` and ``.overlap`` for codes (N, L) of materials.

    networks: only their basis is used.
    """
    problem = problem_of(networks, codes[:: -(-len(codes) // MATERIALS[networks.arch.widths])])
    half = proposal.TERMS // 2
    start = np.zeros((len(problem.factor) + 2, proposal.TERMS))
    start[-2, :half] = -2.0
    slopes = jax.jit(jax.value_and_grad(variance, argnums=1))
    on_device = jax.tree.map(jnp.asarray, problem)

    def value_and_slope(x: np.ndarray) -> tuple[float, np.ndarray]:
        value, slope = slopes(on_device, x.reshape(start.shape))
        return float(value), np.asarray(slope, np.float64).ravel()

    found = minimize(
        value_and_slope, start.ravel(), jac=True, method="L-BFGS-B", options={"maxiter": STEPS}
    ).x.reshape(start.shape)
    gain = np.where(np.arange(proposal.TERMS) < half, 1.0, 0.0)
    weight = np.concatenate([gain[None], problem.factor @ found[:-2]])
    bias = found[-2] - problem.rest[:, 0, 1:].mean(axis=0) @ weight[1:]
    parameters = {"weight": weight, "bias": bias, "overlap": np.exp(found[-1, : half - 1])}
    return {f"proposal.{name}": x.astype(np.float32) for name, x in parameters.items()}


def problem_of(networks: Networks, z: np.ndarray) -> Problem:
    """The problem of codes (S, L)."""
    widths, size = networks.arch.widths, networks.arch.lobe
    angles = np.meshgrid(np.radians(ANGLES[widths]), np.radians(AZIMUTHS[widths]), indexing="ij")
    theta, phi = (x.ravel() for x in angles)
    wi = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    wo, share = half_vector_rule(wi, anisotropic=widths == 2, azimuths=AZIMUTH_NODES // 4)
    wi, wo = np.broadcast_to(wi[:, None], wo.shape).astype(np.float32), wo.astype(np.float32)
    lobe, rest = z[:, :size], z[:, size:]
    functions = networks.basis.functions_at(wi.reshape(-1, 3), wo.reshape(-1, 3))
    f_cos = networks.rest_at_all(z, functions)
    f_cos = f_cos.reshape(len(z), *share.shape)
    f_cos += np.stack([lobes.f(own, wi, wo) for own in lobe])
    f_cos *= wo[..., 2]
    albedo = np.sum(f_cos * share, axis=-1, keepdims=True)
    squares = ((f_cos / albedo) ** 2 * share).astype(np.float32)
    width, log_stretch = lobes.width(lobe[:, None, None]), z[:, None, None, -1]
    pair = components(wi), components(wo)
    densities = [
        reflection_pdf(alpha, *pair, NUMPY).astype(np.float32)
        for alpha in proposal.widths_of(width, log_stretch, NUMPY)
    ]
    densities.append(wo[..., 2] / np.float32(np.pi))
    cov = np.cov(np.clip(rest[:, 1:], *np.quantile(rest[:, 1:], (0.01, 0.99), axis=0)).T)
    values, vectors = np.linalg.eigh(cov)
    factor = vectors / np.sqrt(np.maximum(values, 1e-6 * values[-1]))
    inputs = (rest[:, 1:] - rest[:, 1:].mean(axis=0)) @ factor
    parts = lobe[:, None], rest[:, None], inputs[:, None].astype(np.float32)
    near = wi[:, 0]
    passed = of_lobe(lobe[:, None], near)
    return Problem(*parts, factor, squares, densities, near[:, 2], passed)


def variance(problem: Problem, x: Any) -> Any:
    """The mean of ln(m - 1 + `NOISE`), with the penalty.

    x: (K + 1, `TERMS`) factors of the decorrelated numbers, the offsets, and the logarithms of the
        overlaps, of which there are fewer.
    """
    half, xp = proposal.TERMS // 2, arrays(problem.lobe)
    terms = problem.inputs @ x[:-2] + x[-2]  # (S, 1, `TERMS`)
    terms += problem.rest[..., :1] * (np.arange(proposal.TERMS) < half)
    weights = proposal.weights(
        [terms[..., k] for k in range(proposal.TERMS)],
        list(jnp.exp(x[-1, : half - 1])),
        lobes.width(problem.lobe),
        functools.partial(lobes.reflectance, problem.lobe),
        problem.cosine,
        xp,
        problem.passed,
    )
    pairs = zip(weights, problem.densities, strict=True)
    density = sum(weight[..., None] * density for weight, density in pairs)
    moments = (problem.squares / xp.maximum(density, 1e-9)).sum(axis=-1)
    size = jnp.mean(xp.log(xp.maximum(moments - 1, 0) + NOISE))
    return size + PENALTY * jnp.mean(x[:-2] ** 2)
