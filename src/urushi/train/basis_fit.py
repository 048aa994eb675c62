"""Fitting the linear basis to tables of many materials.

The logarithm of g of `nets.transmittance` of material n at node p and azimuth t is modelled as

    ln g_npt = sum_k A_npt,a(k) U_pk c_nk,

as in `urushi.nets.basis`, with a mean of zero so that a Lambertian is exact. One width has one
azimuth and the factor A = 1; for two widths see `core.stretched`. The first functions are
given: the constant one, or those of one width. Weighted least squares alternate between the codes c
and, node by node, the other functions U. The weights are first the share of a node in the light of
a material, then those by which squares of logarithms equal the error E of a material, as in
`nets.code_fit`.

The functions of a factor are not unique. They are chosen so that their codes have the mean square 1
and mean products 0 over the materials, and are ordered by their effect on the light. Functions
without a factor have the weighted mean 0 over the nodes, so that c_0 alone is the logarithmic gain.
"""

import functools
import itertools
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import nnls

from urushi.core.directions import directions_at
from urushi.core.probe_pairs import probe_pairs
from urushi.core.table import MAX_LOG, SHAPE, corners, node_pairs, pair_coordinates, squared_tangent
from urushi.nets import code_fit
from urushi.nets import lobe as lobes
from urushi.nets.basis import on_grid
from urushi.nets.transmittance import both_ways
from urushi.nets.weights import Model
from urushi.train.stretched_tables import NODES, Nodes, nodes_of

#: Rounds of the alternation by light, and by the error.
ROUNDS, LATE_ROUNDS = 24, 4

#: Weight of the measure beside the light, share of a node's mean weight that every material has
#: there beside its own, and share of the weights by light in those by the error.
FLOOR, EVEN, MIXED = 0.05, 0.1, 0.3

#: Shares of all weights at a node, and of a material, that are added to the diagonals of their
#: normal equations. Functions are so zero where their factors are.
RIDGE, CODE_RIDGE = 1e-3, 1e-9

#: Materials whose rest is a smaller share of all light teach nothing.
LEAST_LIGHT = 4e-3

#: Materials whose principal components begin the fit.
STARTING = 600

#: Probe weights: share of the squares that keep them equal, and least weight over the mean one.
EQUAL, LEAST_WEIGHT = 0.02, 0.02

#: Materials that are computed at once.
BLOCK = 128


class Tables(NamedTuple):
    """Materials N at azimuths T and nodes P. What all materials share has N = 1.

    Functions (P, K) are at these nodes, without their factors `which` (K,), see `nets.basis`.
    """

    logs: np.ndarray  # float32 (N, T, P) ln g
    top: np.ndarray  # float32 (N, 1, 1) integrals of f of the lobes over pairs
    measure: np.ndarray  # float32 (N, T, P) T(wi) T(wo), times shares in integrals over pairs
    factors: np.ndarray  # float32 (1 or N, `core.stretched.FACTORS`, T, P); of one width empty

    def rest(self) -> np.ndarray:
        """Integrals (N, 1, 1) of the rests over pairs."""
        return (np.exp(self.logs) * self.measure).sum(axis=(1, 2), keepdims=True)

    def light(self) -> np.ndarray:
        """Integrals (N, 1, 1) of f over pairs: all light."""
        return self.rest() + self.top

    def taken(self, rows: np.ndarray | slice) -> "Tables":
        """The materials of some rows."""
        return Tables(*(x if len(x) == 1 else x[rows] for x in self))

    def summed(self, values: np.ndarray, *factors: int) -> np.ndarray:
        """Sums (N, P) over the azimuths of values (N, T, P) times factors."""
        for factor in factors:
            values = values * self.factors[:, factor - 1] if factor else values
        return values.sum(axis=1)

    def at_nodes(self, rows: np.ndarray) -> np.ndarray:
        """Values float32 (P, K) at these nodes, of rows (nodes, K) at those of `core.table`."""
        if self.logs.shape[2] == len(rows):
            return rows
        axes = [np.linspace(0, 1, count) for count in NODES]
        places = (x.ravel() for x in np.meshgrid(*axes, indexing="ij"))
        return sum(rows[node] * share[:, None] for node, share in corners(SHAPE, *places))

    def light_weights(self) -> np.ndarray:
        """Weights float32 (N, T, P) of squared errors of logarithms by light, and a floor."""
        return self.measure * (np.exp(self.logs) / self.light() + np.float32(FLOOR))

    def logs_of(self, functions: np.ndarray, which: np.ndarray, codes: np.ndarray) -> np.ndarray:
        """ln g (N, T, P) of codes (N, K)."""
        total = np.zeros_like(self.logs)
        for factor, at in _blocks(which):
            part = (codes[:, at] @ functions[:, at].T)[:, None]
            total += part * self.factors[:, factor - 1] if factor else part
        return np.minimum(total, MAX_LOG)

    def codes(self, functions: np.ndarray, which: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Codes float32 (N, K) of least squares with weights (N, T, P)."""

        def of(own: Tables, weight: np.ndarray) -> np.ndarray:
            squares, products = (
                functools.partial(own.summed, x) for x in (weight, weight * own.logs)
            )
            ridge = CODE_RIDGE * weight.sum(axis=(1, 2))
            return np.linalg.solve(*_normal(functions, which, squares, products, ridge))[..., 0]

        return self._in_blocks(of, weights).astype(np.float32)

    def errors(self, functions: np.ndarray, which: np.ndarray, codes: np.ndarray) -> np.ndarray:
        """E (N,) of codes (N, K) over all nodes, as shares of all light."""

        def of(own: Tables, codes: np.ndarray) -> np.ndarray:
            f = np.exp(own.logs_of(functions, which, codes))
            return (np.abs(f - np.exp(own.logs)) * own.measure / own.light()).sum(axis=(1, 2))

        return self._in_blocks(of, codes)

    def error_weights(
        self, functions: np.ndarray, which: np.ndarray, codes: np.ndarray
    ) -> np.ndarray:
        """Weights float32 (N, T, P) by which squares equal the errors of codes (N, K)."""

        def of(own: Tables, codes: np.ndarray) -> np.ndarray:
            logs = own.logs_of(functions, which, codes)
            slopes = code_fit.error_slopes(logs, np.exp(own.logs), own.light())[1]
            return (own.measure * slopes).astype(np.float32)

        return self._in_blocks(of, codes)

    def _in_blocks(self, function: Callable[..., np.ndarray], rows: np.ndarray) -> np.ndarray:
        """`function` of the materials and these rows (N, ...), `BLOCK` at a time."""
        some = [slice(i, i + BLOCK) for i in range(0, len(rows), BLOCK)]
        return np.concatenate([function(self.taken(x), rows[x]) for x in some])


def materials(held: Mapping[str, np.ndarray]) -> Tables:
    """The materials of the arrays of a `TableStore`."""
    table, lobe = held["table"].astype(np.float32), held["lobe"]
    if "stretch" in held:
        columns = zip(*(held[name] for name in ("stretch", "stack", "level")), strict=True)
        nodes = [nodes_of(stretch, seed) for stretch, *seed in columns]
        factors = np.stack([at.factors for at in nodes])
    else:
        nodes = [Nodes(node_pairs(), node_measure(), np.empty(0))] * len(lobe)
        factors = np.empty((1, 0))
    top, measure = np.empty(len(lobe), np.float32), np.empty_like(table)
    for k, (own, at) in enumerate(zip(lobe, nodes, strict=True)):
        top[k] = (lobes.f(own, *at.pairs) * at.measure).sum()
        measure[k] = (both_ways(own, *at.pairs) * at.measure).ravel()
    shape = len(lobe), *np.atleast_2d(nodes[0].measure).shape
    return Tables(table.reshape(shape), top[:, None, None], measure.reshape(shape), factors)


def probed(held: Mapping[str, np.ndarray], count: int) -> np.ndarray:
    """g (N, count) of such arrays at the probe pairs; of one width by the tables."""
    if "probes" in held:
        return np.exp(held["probes"])
    around = corners(SHAPE, *pair_coordinates(*probe_pairs(count)))  # linear in between
    return np.exp(sum(held["table"][:, nodes] * share for nodes, share in around))


def bottom_codes(model: Model, held: Mapping[str, np.ndarray]) -> np.ndarray:
    """Codes float32 (N, L) of such arrays, with the lobes that they hold."""
    passed = both_ways(held["lobe"][:, None], *model.networks.pairs())
    rest = code_fit.solve_codes(model.networks.basis, probed(held, model.arch.probes), passed)
    return np.concatenate([held["lobe"], rest], axis=1)


def node_measure() -> np.ndarray:
    """Share float32 (P,) of each node in integrals over pairs of cosine density on both sides.

    By a fine midpoint rule in the half angle, the difference angle and the azimuth; a point counts
    at the corners of its cell.
    """
    edges = np.sqrt(np.maximum(squared_tangent(np.linspace(0, 1, 481)), 0))
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


def prepared(tables: Tables) -> tuple[Tables, np.ndarray]:
    """The tables that a basis is fitted to, and their rows (N,) among those given.

    Values below a share of their mean are raised to it, as in `code_fit`.
    """
    rows = np.flatnonzero(tables.rest() > LEAST_LIGHT * tables.light())
    found = tables.taken(rows)
    least = code_fit.LEAST_SHARE * found.rest() + 1e-12
    return found._replace(logs=np.maximum(found.logs, np.log(least))), rows


def fit_basis(tables: Tables, given: np.ndarray, which: np.ndarray) -> tuple[np.ndarray, ...]:
    """The functions of a basis by alternating least squares, and what codes are tied to.

    Args:
        tables: `prepared` materials.
        given: float32 (nodes, 1 + G) mean and first functions, at the nodes of `core.table`.
        which: (K,) the factor of each function.

    Returns:
        float32 (nodes, 1 + K) mean and all functions, the given ones among them, and the inverse
        float32 (K, K) of the mean products of codes.
    """
    first, count = tables.at_nodes(given)[:, 1:], given.shape[1] - 1
    weights = by_light = tables.light_weights()
    node_weight = by_light.mean(axis=(0, 1))
    functions = _started(tables, first, which, node_weight)
    for turn in range(ROUNDS + LATE_ROUNDS):
        codes = tables.codes(functions, which, weights)
        if turn >= ROUNDS:
            weights = tables.error_weights(functions, which, codes)
            weights = weights * (1 / (weights / by_light).mean()) + MIXED * by_light
            codes = tables.codes(functions, which, weights)
        functions = standardised(functions, count, which, codes, node_weight)
        codes = tables.codes(functions, which, weights)
        functions = _functions(codes, first, which, tables, weights)
    codes = tables.codes(functions, which, weights)
    functions = standardised(functions, count, which, codes, node_weight)
    codes = tables.codes(functions, which, by_light)
    products = codes.T @ codes / len(codes) + 1e-9 * np.eye(len(which))
    further = functions[:, count:]
    if len(further) != len(given):  # at coarse nodes: by cubic splines
        further = further.reshape(*NODES, -1).astype(float)
        for axis, (known, nodes) in enumerate(zip(NODES, SHAPE, strict=True)):
            spline = CubicSpline(np.linspace(0, 1, known), further, axis=axis)
            further = spline(np.linspace(0, 1, nodes))
        further = further.reshape(len(given), -1).astype(np.float32)
    rows = on_grid(np.concatenate([given, further], axis=1))
    return rows, np.linalg.inv(products.astype(float)).astype(np.float32)


def _started(
    tables: Tables, given: np.ndarray, which: np.ndarray, node_weight: np.ndarray
) -> np.ndarray:
    """The given functions (P, G), and principal components of some materials."""
    some = np.random.default_rng(0).permutation(len(tables.logs))[:STARTING]
    chosen, functions = tables.taken(some), [given]
    for factor, at in _blocks(which, given.shape[1]):
        mean = chosen.logs.mean(axis=1, keepdims=True)
        if not factor:
            mean = (mean[:, 0] @ node_weight / node_weight.sum())[:, None, None]
        centred = chosen.summed(chosen.logs - mean, factor)
        components = np.linalg.svd(centred, full_matrices=False)[2][: len(at)]
        functions.append(np.sqrt(len(given)) * components.T)
    return np.concatenate(functions, axis=1, dtype=np.float32)


def standardised(
    functions: np.ndarray, given: int, which: np.ndarray, codes: np.ndarray, weight: np.ndarray
) -> np.ndarray:
    """The same model, with the functions that the module describes.

    functions: (P, K), of which the first are given. codes: (N, K). weight: (P,) of the nodes.
    """
    result, weight = functions.copy(), weight / weight.sum(dtype=float)
    for factor, at in _blocks(which, given):
        own = functions[:, at].astype(float)
        if not factor:
            own = own - weight @ own
        sizes, axes = np.linalg.eigh((own.T * weight) @ own)
        root = (axes * np.sqrt(np.maximum(sizes, 1e-12))) @ axes.T
        products = codes[:, at].T.astype(float) @ codes[:, at] / len(codes)
        effects, axes = np.linalg.eigh(root @ products @ root)
        axes = axes[:, ::-1] * np.sqrt(np.maximum(effects[::-1], 1e-12))
        result[:, at] = own @ np.linalg.solve(root, axes)
    return result


def _blocks(which: np.ndarray, given: int = 0) -> list[tuple[int, np.ndarray]]:
    """Each factor of functions (K,) that are not given, and the places of its functions."""
    own = which[given:]
    return [(factor, given + np.flatnonzero(own == factor)) for factor in np.unique(own).tolist()]


def probe_measure(rest: np.ndarray, integrals: np.ndarray) -> np.ndarray:
    """Weights float32 (count,) of the probe pairs, by which sums of f are the tables' integrals.

    Nonnegative least squares of relative errors, about equal weights.

    rest: (N, count) f at the probe pairs. integrals: (N,).
    """
    count = rest.shape[1]
    shares = rest / integrals[:, None] / count
    tie = np.sqrt(EQUAL * len(rest) / count)
    system = np.concatenate([shares, tie * np.eye(count)])
    weights, _ = nnls(
        system, np.append(np.ones(len(rest)), np.full(count, tie)), maxiter=50 * count
    )
    return (np.maximum(weights, LEAST_WEIGHT) / count).astype(np.float32)


def _functions(
    codes: np.ndarray, given: np.ndarray, which: np.ndarray, tables: Tables, weights: np.ndarray
) -> np.ndarray:
    """Functions float32 (P, K) of least squares at every node, the first of which are given."""
    count = given.shape[1]
    weights = weights + EVEN * weights.mean(axis=0)
    left = weights * (tables.logs - (codes[:, :count] @ given.T)[:, None])
    normal, right = _normal(
        codes[:, count:],
        which[count:],
        lambda *some: tables.summed(weights, *some).T,
        lambda some: tables.summed(left, some).T,
        RIDGE * weights.sum(axis=(0, 1)),
    )
    shape = SHAPE if len(given) == np.prod(SHAPE) else NODES
    for x in (normal, right):  # w means nothing where the half or the difference angle is zero
        at = x.reshape(*shape, *x.shape[1:])
        at[0] = at[0].sum(axis=1, keepdims=True)
        at[:, 0] = at[:, 0].sum(axis=1, keepdims=True)
    found = np.linalg.solve(normal, right)[..., 0]
    return np.concatenate([given, found], axis=1, dtype=np.float32)


def _normal(
    x: np.ndarray,
    which: np.ndarray,
    weight: Callable[..., np.ndarray],
    right: Callable[[int], np.ndarray],
    ridge: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Normal equations (M, K, K) and (M, K, 1) of M least squares over I values.

    Args:
        x: (I, K) functions without their factors `which` (K,).
        weight: (M, I) by which the squares and two factors are weighed.
        right: (M, I) weights times one factor and the values.
        ridge: (M,) what is added to the diagonals.
    """
    blocks, count = _blocks(which), x.shape[1]
    sides = [right(factor) @ x[:, at] for factor, at in blocks]
    result = np.zeros((len(sides[0]), count, count))
    for (a, at), (b, to) in itertools.combinations_with_replacement(blocks, 2):
        if a == b:
            found = code_fit.weighted_products(x[:, at], weight(a, a))
        else:
            products = (x[:, at, None] * x[:, None, to]).reshape(len(x), -1)
            found = (weight(a, b) @ products).reshape(-1, len(at), len(to))
        result[:, at[:, None], to] = found
        result[:, to[:, None], at] = np.swapaxes(found, 1, 2)
    result += ridge[:, None, None] * np.eye(count)
    return result, np.concatenate(sides, axis=1)[..., None].astype(float)
