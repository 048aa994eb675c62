"""Fitting the linear basis to tables of many materials.

The logarithm of the rest of material n at node p is modelled as

    ln f_np = c_n0 + sum_{k > 0} U_pk c_nk,

as in `urushi.nets.basis`, with a mean of zero so that a Lambertian is exact. Weighted least squares
alternate between the codes c and, node by node, the functions U. The weights are first the share of
a node in the light of a material, then those by which squares of logarithms equal the error E of a
material, as in `nets.code_fit`.

The functions are not unique. They are chosen so that their codes have the mean square 1 and mean
products 0 over the materials, and are ordered by their effect on the light. Their weighted mean
over the nodes is 0, so that c_0 alone is the logarithmic gain.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import nnls

from urushi.core.directions import directions_at
from urushi.core.probe_pairs import probe_pairs
from urushi.core.table import (
    HIGHEST,
    LOWEST,
    MAX_LOG,
    MIN_LOG,
    SHAPE,
    TAN2_OFFSET,
    corners,
    pair_coordinates,
)
from urushi.nets import code_fit
from urushi.nets.basis import Basis, on_grid

#: Rounds of the alternation by light, and by the error.
ROUNDS, LATE_ROUNDS = 8, 2

#: Weight of the measure beside the light, share of a node's mean weight that every material has
#: there beside its own, and share of the weights by light in those by the error.
FLOOR, EVEN, MIXED = 0.05, 0.1, 0.3

#: Share of the trace that is added to the diagonal of a node's normal equations.
RIDGE = 1e-6

#: Materials whose rest is a smaller share of all light teach nothing.
LEAST_LIGHT = 4e-3

#: Materials whose principal components begin the fit.
STARTING = 600

#: Probe weights: share of the squares that keep them equal, and least weight over the mean one.
EQUAL, LEAST_WEIGHT = 0.02, 0.02

#: Materials, or nodes, that are computed at once.
BLOCK = 128


class Tables(NamedTuple):
    """Materials at the nodes of `core.table`."""

    logs: np.ndarray  # float32 (N, P) ln f of the rests
    top: np.ndarray  # float32 (N, P) f of the lobes [1/sr]

    def light(self, measure: np.ndarray) -> np.ndarray:
        """All light (N, 1): integrals of f over pairs."""
        return ((np.exp(self.logs) + self.top) @ measure)[:, None]

    def taken(self, rows: np.ndarray) -> "Tables":
        """The materials of some rows."""
        return Tables(self.logs[rows], self.top[rows])


def at_probes(values: np.ndarray, count: int) -> np.ndarray:
    """Values (N, count) at the probe pairs of values (N, P) at the nodes, linear in between."""
    around = corners(SHAPE, *pair_coordinates(*probe_pairs(count)))
    return sum(values[:, nodes] * share for nodes, share in around)


def node_measure() -> np.ndarray:
    """Share float32 (P,) of each node in integrals over pairs of cosine density on both sides.

    By a fine midpoint rule in the half angle, the difference angle and the azimuth; a point counts
    at the corners of its cell.
    """
    tan2 = np.exp(LOWEST + np.linspace(0, 1, 481) * (HIGHEST - LOWEST)) - TAN2_OFFSET
    edges = np.sqrt(np.maximum(tan2, 0))
    bounds = np.arctan(edges), np.arccos(1 - np.linspace(0, 1, 161) ** 2), np.linspace(0, np.pi, 97)
    middle, size = zip(*((0.5 * (x[1:] + x[:-1]), np.diff(x)) for x in bounds), strict=True)
    theta_d, phi_d = (x.ravel() for x in np.meshgrid(*middle[1:], indexing="ij"))
    around = np.multiply.outer(*size[1:]).ravel() * np.sin(theta_d) * np.cos(theta_d)
    total = np.zeros(np.prod(SHAPE))
    for theta_h, width in zip(middle[0], size[0], strict=True):
        wi, wo = directions_at(np.full_like(theta_d, theta_h), theta_d, phi_d)
        weight = width * np.sin(theta_h) * around * wi[:, 2].clip(0) * wo[:, 2].clip(0)
        above = weight > 0
        for row, share in corners(SHAPE, *pair_coordinates(wi[above], wo[above])):
            total += np.bincount(row, share * weight[above], len(total))
    return (total / total.sum() + 1e-10).astype(np.float32)  # no node is without weight


def prepared(logs: np.ndarray, top: np.ndarray, measure: np.ndarray) -> tuple[Tables, np.ndarray]:
    """The tables that a basis is fitted to, and their rows among ln f and lobes (N, P).

    Values count as at least a share of their mean, as in `code_fit`.
    """
    f = np.exp(logs.astype(np.float32))
    rest = f @ measure
    rows = np.flatnonzero(rest > LEAST_LIGHT * (rest + top @ measure))
    return Tables(np.log(code_fit.bounded(f[rows], measure)), top[rows]), rows


def fit_basis(tables: Tables, measure: np.ndarray, functions: int, probes: int) -> Basis:
    """The basis of K = `functions` functions, and what codes need at `probes` probe pairs.

    measure: `node_measure`.
    """
    rows = on_grid(fit_rows(tables, measure, functions))
    weights = _light_weights(tables, measure)
    codes = _codes(rows, tables, weights)
    products = codes.T @ codes / len(codes) + 1e-9 * np.eye(functions)
    prior = np.linalg.inv(products.astype(float)).astype(np.float32)
    return Basis.of(rows, probe_measure(tables, measure, probes), prior)


def fit_rows(tables: Tables, measure: np.ndarray, functions: int) -> np.ndarray:
    """Functions float32 (P, 1 + K), after a mean of 0, by alternating least squares."""
    logs, by_light = tables.logs, _light_weights(tables, measure)
    weights, mean_weight = by_light, by_light.mean(axis=0)
    some = logs[np.random.default_rng(0).permutation(len(logs))[:STARTING]]
    some = some - (some @ mean_weight)[:, None] / mean_weight.sum()
    start = np.linalg.svd(some, full_matrices=False)[2][: functions - 1]
    start *= np.sqrt(start.shape[1])
    rows = np.stack([0 * start[0], 0 * start[0] + 1, *start], axis=1).astype(np.float32)
    for turn in range(ROUNDS + LATE_ROUNDS):
        if turn >= ROUNDS:
            weights = _error_weights(rows, tables, measure, _codes(rows, tables, weights))
            weights = weights * (1 / (weights / by_light).mean()) + MIXED * by_light
        rows = standardised(rows, _codes(rows, tables, weights), mean_weight)
        rows = _functions(_codes(rows, tables, weights), logs, weights)
    return standardised(rows, _codes(rows, tables, weights), mean_weight)


def standardised(rows: np.ndarray, codes: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """The same model, with the functions that the module describes.

    rows: (P, 1 + K). codes: (N, K). weight: (P,) of the nodes.
    """
    functions, weight = rows[:, 2:].astype(float), weight / weight.sum(dtype=float)
    functions = functions - weight @ functions
    sizes, axes = np.linalg.eigh((functions.T * weight) @ functions)
    root = (axes * np.sqrt(np.maximum(sizes, 1e-12))) @ axes.T
    products = codes[:, 1:].T.astype(float) @ codes[:, 1:] / len(codes)
    effects, axes = np.linalg.eigh(root @ products @ root)
    axes = axes[:, ::-1] * np.sqrt(np.maximum(effects[::-1], 1e-12))
    functions = functions @ np.linalg.solve(root, axes)
    return np.concatenate([rows[:, :2], functions], axis=1, dtype=np.float32)


def probe_measure(tables: Tables, measure: np.ndarray, count: int) -> np.ndarray:
    """Weights float32 (count,) of the probe pairs, by which sums of f are the tables' integrals.

    Nonnegative least squares of relative errors, about equal weights.
    """
    f = np.exp(at_probes(tables.logs, count))
    shares = f / (np.exp(tables.logs) @ measure)[:, None] / count
    tie = np.sqrt(EQUAL * len(f) / count)
    system = np.concatenate([shares, tie * np.eye(count)])
    weights, _ = nnls(system, np.append(np.ones(len(f)), np.full(count, tie)), maxiter=50 * count)
    return (np.maximum(weights, LEAST_WEIGHT) / count).astype(np.float32)


def errors(basis: Basis, tables: Tables, measure: np.ndarray, codes: np.ndarray) -> np.ndarray:
    """E (N,) of codes (N, K) over all nodes, as shares of all light."""
    total = tables.light(measure)

    def of(rows: slice) -> np.ndarray:
        logs = basis.rows[:, 0] + codes[rows] @ basis.rows[:, 1:].T
        f = np.exp(np.clip(logs, MIN_LOG, MAX_LOG))
        return np.abs(f - np.exp(tables.logs[rows])) @ measure / total[rows, 0]

    return _in_blocks(of, len(codes))


def codes_at_probes(basis: Basis, tables: Tables) -> np.ndarray:
    """Codes float32 (N, K) of materials from their values at the probe pairs."""
    return code_fit.solve_codes(basis, np.exp(at_probes(tables.logs, len(basis.measure))))


def _light_weights(tables: Tables, measure: np.ndarray) -> np.ndarray:
    """Weights float32 (N, P) of squared errors of logarithms by light, and a floor."""
    f = np.exp(tables.logs)
    return measure * (f / tables.light(measure) + np.float32(FLOOR))


def _error_weights(
    rows: np.ndarray, tables: Tables, measure: np.ndarray, codes: np.ndarray
) -> np.ndarray:
    """Weights float32 (N, P) by which squares equal the errors of codes (N, K)."""
    total = tables.light(measure)

    def of(some: slice) -> np.ndarray:
        f = np.exp(tables.logs[some])
        return code_fit.weighed(rows, measure, f, total[some], codes[some])[1].astype(np.float32)

    return _in_blocks(of, len(codes))


def _codes(rows: np.ndarray, tables: Tables, weights: np.ndarray) -> np.ndarray:
    """Codes float32 (N, K) of least squares with weights (N, P)."""
    functions, none = rows[:, 1:], np.zeros((rows.shape[1] - 1, rows.shape[1] - 1))

    def of(some: slice) -> np.ndarray:
        return code_fit.solved(functions, tables.logs[some] - rows[:, 0], weights[some], none)

    return _in_blocks(of, len(weights)).astype(np.float32)


def _functions(codes: np.ndarray, logs: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Functions float32 (P, 1 + K), after a mean of 0, of least squares at every node."""
    count, inputs = codes.shape[1] - 1, codes[:, 1:]
    weights = weights + EVEN * weights.mean(axis=0)
    normal = code_fit.weighted_products(inputs, weights.T)
    right = (weights * (logs - codes[:, :1])).T @ inputs
    normal += RIDGE * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(count) / count
    found = np.linalg.solve(normal, right[..., None].astype(float))[..., 0]
    fixed = np.broadcast_to(np.array([0.0, 1.0]), (len(found), 2))
    return np.concatenate([fixed, found], axis=1, dtype=np.float32)


def _in_blocks(function: Callable[[slice], np.ndarray], count: int) -> np.ndarray:
    """`function` of all slices of `BLOCK` of `count` rows, one after another."""
    return np.concatenate([function(slice(i, i + BLOCK)) for i in range(0, count, BLOCK)])
