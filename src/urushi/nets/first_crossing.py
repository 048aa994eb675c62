"""The first crossing: a coated material whose light crosses the interface once on either way.

Directions are refracted at the mean surface to wi' and wo', with the cosines c_i and c_o. The light
is what the bottom reflects, and what the medium scatters once:

    f_below(wi', wo') exp(-sigma_t (1 / c_i + 1 / c_o))
        + albedo p(wi', wo') (1 - exp(-sigma_t (1 / c_i + 1 / c_o))) / (c_i + c_o)

with the phase function p of Henyey and Greenstein (1941) and single scattering after Chandrasekhar
(1960, section 47). A rough interface widens the bottom's lobe. Transmittances of the interface and
light that is turned back are left to the layering network.

The code of these values at some probe pairs is a least-squares solution with constant weights: one
product with a constant matrix.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import CoatParameters
from urushi.core import microfacet
from urushi.core.namespace import NUMPY, Namespace, arrays, components, stacked_components
from urushi.core.probe_pairs import probe_pairs
from urushi.core.table import MAX_LOG, MIN_LOG
from urushi.nets.basis import Basis
from urushi.nets.code_fit import PRIOR
from urushi.nets.lobe import reflectance_of

#: Nodes of the index between which the bottom's functions are interpolated, and the range of
#: (eta - 1) / (eta + 1), in which they are even.
NODES = 16
LEAST_AMPLITUDE, LARGEST_AMPLITUDE = -1 / 3, 1 / 2

#: Least cosine inside. Beyond the critical angle, directions are refracted to it.
LEAST_COSINE = 0.02

#: Share of the squared slope that an interface turns light by, which is added to the squared width
#: of the bottom's lobe: the half vector is a mean of two directions.
WIDENING = 0.5

#: [1/sr] Added to f, so that its logarithm is finite.
FLOOR = 1e-8


class FirstCrossing(NamedTuple):
    """What the first crossing needs of a basis of K functions, at N pairs."""

    wi: np.ndarray  # float32 (N, 3)
    wo: np.ndarray  # float32 (N, 3)
    rows: np.ndarray  # float32 (`NODES`, 1 + K, N): the functions at the refracted pairs
    mean: np.ndarray  # float32 (N,), of the basis at the pairs
    solution: np.ndarray  # float32 (N, K), from logarithms less the mean to codes

    @classmethod
    def of(cls, basis: Basis, count: int) -> "FirstCrossing":
        """At `count` probe pairs."""
        pairs = probe_pairs(count)
        amplitude = np.linspace(LEAST_AMPLITUDE, LARGEST_AMPLITUDE, NODES)
        rows = []
        for eta in (1 + amplitude) / (1 - amplitude):
            below = (refracted(components(w.astype(np.float64)), eta, NUMPY) for w in pairs)
            wi, wo = (stacked_components(w, np).astype(np.float32) for w in below)
            rows.append(basis.at(wi, wo).T)
        own = basis.at(*pairs).astype(np.float64)
        functions = own[:, 1:]
        normal = functions.T @ functions / count + PRIOR * basis.prior
        solution = np.linalg.solve(normal, functions.T / count).T
        numbers = (np.stack(rows), own[:, 0], solution)
        return cls(*pairs, *(x.astype(np.float32) for x in numbers))

    def codes(self, rest: Any, lobe: Any, coat: CoatParameters) -> Any:
        """The codes (..., K) of bottoms with codes rest (..., K) and lobes (..., 6) under coats.

        The parameters (...) of coats broadcast against the bottoms. The result lacks the lobe.
        """
        wi, wo = components(self.wi), components(self.wo)
        numbers = [lobe[..., k, None] for k in range(lobe.shape[-1])]
        columns = [column[..., None] for column in coat.columns()]
        logs = self.rest_logs(rest, coat.eta)
        logs = crossed_log(logs, numbers, columns, wi, wo, arrays(rest))
        return (logs - self.mean) @ self.solution

    def rest_logs(self, rest: Any, eta: Any) -> Any:
        """ln f (..., N) of codes rest (..., K) at the pairs inside, under indices eta (...)."""
        xp = rest.__array_namespace__()
        share = shares(eta, xp)
        numbers = xp.concat([xp.ones_like(rest[..., :1]), rest], axis=-1)
        product = share[..., None] * numbers[..., None, :]
        every = product.reshape((*product.shape[:-2], -1)) @ self.rows.reshape(-1, len(self.wi))
        return xp.clip(every, MIN_LOG, MAX_LOG)

    def slopes(self, rest: np.ndarray, eta: np.ndarray) -> np.ndarray:
        """Derivatives (R, K + 1, N) of `rest_logs` (R, N) by codes (R, K) and indices (R,)."""
        by_code = np.tensordot(shares(eta, np), self.rows, 1)
        step, place = (LARGEST_AMPLITUDE - LEAST_AMPLITUDE) / (NODES - 1), places(eta)
        low = np.clip(place.astype(int), 0, NODES - 2)
        change = (self.rows[low + 1] - self.rows[low]) / step * (2 / (eta + 1) ** 2)[:, None, None]
        by_eta = change[:, 0] + (rest[:, None] @ change[:, 1:])[:, 0]
        return np.concatenate([by_code[:, 1:], by_eta[:, None]], axis=1).astype(np.float32)


def places(eta: Any) -> Any:
    """The places (...) of indices (...) among the nodes."""
    span = LARGEST_AMPLITUDE - LEAST_AMPLITUDE
    return ((eta - 1) / (eta + 1) - LEAST_AMPLITUDE) * ((NODES - 1) / span)


def shares(eta: Any, xp: Any) -> Any:
    """The shares (..., `NODES`) of the nodes around indices (...)."""
    place = xp.clip(places(eta), 0, NODES - 1)[..., None]
    return xp.maximum(1 - xp.abs(place - xp.arange(NODES, dtype=place.dtype)), 0)


def refracted(w: Any, eta: Any, xp: Namespace) -> Any:
    """The direction inside of a direction w, see the module."""
    x, y = w.x / eta, w.y / eta
    z = xp.sqrt(xp.maximum(1 - x * x - y * y, LEAST_COSINE**2))
    return xp.normalized(type(w)(x, y, z))


def crossed_log(
    rest_log: Any, lobe: Sequence[Any], coat: Sequence[Any], wi: Any, wo: Any, xp: Namespace
) -> Any:
    """ln f of the module's light at a pair wi, wo outside.

    Args:
        rest_log: ln f of the bottom's rest at the refracted pair.
        lobe: the six numbers of the bottom's lobe.
        coat: alpha, eta, albedo, sigma_t and g.
        wi, wo: vectors with components x, y and z.
        xp: see `core.namespace`.
    """
    alpha, eta, albedo, sigma_t, g = coat
    i, o = (refracted(w, eta, xp) for w in (wi, wo))
    turned = (1 - 1 / eta) * alpha
    width = xp.sqrt(lobe[0] * lobe[0] + WIDENING * turned * turned)
    half = microfacet.half_vector(i, o, xp)
    own = microfacet.lobe_shape(width, i, o, half, xp)
    own = own * reflectance_of(lobe[1:], microfacet.facet_cosine(half, xp), xp)
    passed = xp.exp(-sigma_t * (1 / i.z + 1 / o.z))
    between = 1 + g * g + 2 * g * (i.x * o.x + i.y * o.y + i.z * o.z)
    phase = (1 - g * g) / (4 * math.pi) / (between * xp.sqrt(between))
    scattered = albedo * phase * (1 - passed) / (i.z + o.z)
    return xp.log((xp.exp(rest_log) + own) * passed + scattered + FLOOR)
