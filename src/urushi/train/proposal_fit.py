"""The linear functions of codes from which the weights of proposals follow, by their variance.

One sample f cos / pdf of a proposal has the variance of ``m - 1``, relative to the squared albedo
a^2, where m is the integral of (f cos)^2 / pdf over a^2. The mean of ln(m - 1 + `NOISE`) over
materials and directions wi is minimised (L-BFGS). The gain of a code has the factor one, and the
other numbers are decorrelated first.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from urushi.core.mixture import reflection_pdf
from urushi.core.namespace import NUMPY, components
from urushi.core.quadrature import AZIMUTH_NODES, half_vector_rule
from urushi.nets import lobe as lobes
from urushi.nets import proposal
from urushi.nets.networks import Networks

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

    codes: np.ndarray  # (S, K) without lobes
    factor: np.ndarray  # (K - 1, K - 1) decorrelates codes without gains
    squares: np.ndarray  # (S, A, M) (f cos / albedo)^2 and the weight of the node
    # Densities of the lobes of `proposal.ALPHAS` and of cosines: (A, M), or (S, A, M) if stretched.
    fixed: list[np.ndarray]
    own: np.ndarray  # (S, A, M) density of the code's lobe
    top: np.ndarray  # (S, A, 5) energies of the code's lobe by `proposal.weights`
    logs: np.ndarray  # (A,) logarithms of the cosines


def fit_proposal(networks: Networks, codes: np.ndarray) -> dict[str, np.ndarray]:
    """The parameters ``proposal.weight``, ``.bias`` and ``.overlap`` for codes (N, L) of materials.

    networks: only their basis is used. It takes 20 s, ten times as long with two widths.
    """
    problem = _problem(networks, codes[:: -(-len(codes) // MATERIALS[networks.arch.widths])])
    half = proposal.TERMS // 2
    start = np.zeros((len(problem.factor) + 2, proposal.TERMS))
    start[-2, :half] = -2.0
    found = minimize(
        lambda x: _value_and_slope(problem, x.reshape(start.shape)),
        start.ravel(),
        jac=True,
        method="L-BFGS-B",
        options={"maxiter": STEPS},
    ).x.reshape(start.shape)
    gain = np.where(np.arange(proposal.TERMS) < half, 1.0, 0.0)
    weight = np.concatenate([gain[None], problem.factor @ found[:-2]])
    bias = found[-2] - problem.codes[:, 1:].mean(axis=0) @ weight[1:]
    parameters = {"weight": weight, "bias": bias, "overlap": np.exp(found[-1, : half - 1])}
    return {f"proposal.{name}": x.astype(np.float32) for name, x in parameters.items()}


def _problem(networks: Networks, z: np.ndarray) -> Problem:
    widths, size = networks.arch.widths, networks.arch.lobe
    angles = np.meshgrid(np.radians(ANGLES[widths]), np.radians(AZIMUTHS[widths]), indexing="ij")
    theta, phi = (x.ravel() for x in angles)
    wi = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    wo, share = half_vector_rule(wi, anisotropic=widths == 2, azimuths=AZIMUTH_NODES // 4)
    wi, wo = np.broadcast_to(wi[:, None], wo.shape).astype(np.float32), wo.astype(np.float32)
    lobe, rest = z[:, :size], z[:, size:].astype(np.float64)
    functions = networks.basis.functions_at(wi.reshape(-1, 3), wo.reshape(-1, 3))
    f_cos = networks.rest_at_all(z, functions)
    f_cos = f_cos.reshape(len(z), *share.shape)
    f_cos += np.stack([lobes.f(own, wi, wo) for own in lobe])
    f_cos *= wo[..., 2]
    albedo = np.sum(f_cos * share, axis=-1, keepdims=True)
    squares = ((f_cos / albedo) ** 2 * share).astype(np.float32)
    width, log_stretch = lobes.width(lobe[:, None, None]), z[:, None, None, -1]
    pair = components(wi), components(wo)
    own, *fixed = (
        reflection_pdf(alpha, *pair, NUMPY).astype(np.float32)
        for alpha in proposal.widths_of(width, log_stretch, NUMPY)
    )
    fixed.append(wo[..., 2] / np.float32(np.pi))
    cov = np.cov(np.clip(rest[:, 1:], *np.quantile(rest[:, 1:], (0.01, 0.99), axis=0)).T)
    values, vectors = np.linalg.eigh(cov)
    factor = vectors / np.sqrt(np.maximum(values, 1e-6 * values[-1]))
    found = proposal.own_energies(
        lobes.width(lobe[:, None].astype(np.float64)),
        lambda cosine: lobes.reflectance(lobe[:, None].astype(np.float64), cosine),
        wi[None, :, 0, 2],
        NUMPY,
    )
    none = 0 * found[0]
    top = np.stack(np.broadcast_arrays(found[0], none, none, *found[1:]), axis=-1)
    logs = np.log(np.maximum(wi[:, 0, 2], proposal.MIN_COSINE))
    return Problem(rest, factor, squares, fixed, own, top, logs)


def _value_and_slope(problem: Problem, x: np.ndarray) -> tuple[float, np.ndarray]:
    """The mean logarithm of the variance, and its derivatives by x.

    x: (K + 1, `TERMS`) factors of the decorrelated numbers, the offsets, and the logarithms of the
        overlaps, of which there are fewer.
    """
    half, rest = proposal.TERMS // 2, problem.codes
    inputs = (rest[:, 1:] - rest[:, 1:].mean(axis=0)) @ problem.factor
    terms, overlap = inputs @ x[:-2] + x[-2], np.exp(x[-1, : half - 1])
    logs = terms[:, None, :half] + rest[:, None, :1] + terms[:, None, half:] * problem.logs[:, None]
    energy = np.exp(np.clip(logs, -60, proposal.MOST_LOG))  # (S, A, 4)
    alone = energy[..., :-1] - overlap * energy[..., 1:]
    root = np.sqrt(alone**2 + proposal.EDGE * energy[..., :-1] ** 2 + proposal.TINY)
    parts = problem.top.copy()
    parts[..., 1:-1] += 0.5 * (alone + root)
    parts[..., -1] += energy[..., -1]

    value, by_parts = _variance(problem, parts)
    by_alone = by_parts[..., 1:-1] * 0.5 * (1 + alone / root)
    by_energy = np.zeros_like(energy)
    by_energy[..., -1] = by_parts[..., -1]
    by_energy[..., :-1] += by_alone
    by_energy[..., :-1] += by_parts[..., 1:-1] * (0.5 * proposal.EDGE) * energy[..., :-1] / root
    by_energy[..., 1:] -= by_alone * overlap
    by_log = by_energy * energy * (logs < proposal.MOST_LOG)
    by_terms = np.concatenate(
        [by_log.sum(axis=1), np.sum(by_log * problem.logs[:, None], axis=1)], axis=-1
    )
    slope = np.zeros_like(x)
    slope[:-2], slope[-2] = inputs.T @ by_terms, by_terms.sum(axis=0)
    slope[:-2] += 2 * PENALTY * x[:-2] / x[:-2].size
    slope[-1, : half - 1] = -np.sum(by_alone * energy[..., 1:], axis=(0, 1)) * overlap
    return value + PENALTY * float(np.mean(x[:-2] ** 2)), slope.ravel()


def _variance(problem: Problem, parts: np.ndarray) -> tuple[float, np.ndarray]:
    """The mean of ln(m - 1 + `NOISE`) for parts (S, A, 5), and its derivatives by the parts."""
    share = 1 - proposal.MIN_COSINE_SHARE
    total = parts.sum(axis=-1, keepdims=True) + proposal.TINY
    weight = (share * parts / total).astype(np.float32)
    weight[..., -1] += proposal.MIN_COSINE_SHARE
    density = weight[..., :1] * problem.own
    for k, lobe in enumerate(problem.fixed, 1):
        density += weight[..., k, None] * lobe
    np.maximum(density, 1e-9, out=density)
    ratio = problem.squares / density
    excess = np.maximum(ratio.sum(axis=-1) - 1, 0) + NOISE
    ratio /= density
    densities = problem.own, *problem.fixed
    slopes = np.stack([np.sum(ratio * lobe, axis=-1) for lobe in densities], axis=-1)
    slopes *= -share / excess[..., None] / excess.size
    slopes -= np.sum(slopes * parts, axis=-1, keepdims=True) / total
    return float(np.mean(np.log(excess))), slopes / total
