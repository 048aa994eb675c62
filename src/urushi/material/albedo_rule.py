"""Quadrature for the directional albedo of codes at some directions.

The nodes are half vectors, logarithmic in tan theta_h. They end at the horizon of wo, as in
`core.quadrature.half_vector_rule`, which has more of them.

Codes of two widths are symmetric about the xz and the yz plane. Their directions wi have several
azimuths in one quadrant. Lobes of two very different widths are narrow near these planes, where the
nodes are dense.
"""

import functools
from typing import NamedTuple

import numpy as np

from urushi.core.quadrature import gauss, half_vector_nodes

#: Cosines of wi, and its azimuths, by the number of GGX widths.
COSINES = {
    1: (1, 0.98, 0.925, 0.84, 0.735, 0.62, 0.51, 0.4, 0.315, 0.24, 0.175, 0.13, 0.09, 0.04, 0.013),
    2: (1, 0.95, 0.84, 0.7, 0.51, 0.36, 0.24, 0.15, 0.09),
}
AZIMUTHS = {1: (0.0,), 2: (0.0, 0.25 * np.pi, 0.5 * np.pi)}

#: Nodes for each wi: number in theta_h, number in a quadrant of the azimuth, how strongly these
#: crowd at the quadrant's ends, and least tan(theta_h). Albedos of lobes are within 0.002, for
#: quotients of widths up to 8.
NODES = {1: (24, 4, 1e-3, 2e-4), 2: (18, 8, 1.0, 2e-4)}


class AlbedoRule(NamedTuple):
    """A quadrature of P nodes for the albedo at each of K directions, one after another."""

    wi: np.ndarray  # read-only float32 (K P, 3)
    wo: np.ndarray  # read-only float32 (K P, 3)
    weights: np.ndarray  # float32 (K, P), the cosines of wo included

    @property
    def directions(self) -> np.ndarray:
        """The directions (K, 3)."""
        return self.wi[:: self.weights.shape[1]]

    def albedo(self, f: np.ndarray) -> np.ndarray:
        """Directional albedos (..., K) of BRDFs with values f (..., K P) at the nodes."""
        values = f.reshape(*f.shape[:-1], *self.weights.shape)
        return np.einsum("...kp,kp->...k", values, self.weights)


@functools.cache
def albedo_rule(widths: int = 1) -> AlbedoRule:
    """The rule of codes of one GGX width or two."""
    polar, count, crowding, least = NODES[widths]
    azimuths, cosines = np.meshgrid(AZIMUTHS[widths], COSINES[widths], indexing="ij")
    azimuth, cosine = azimuths.ravel(), cosines.ravel()
    sine = np.sqrt(1 - cosine * cosine)
    wi = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine], axis=-1)
    nodes, shares = gauss(count)
    # Gauss's nodes, drawn towards both ends of a quadrant.
    quadrant = 0.25 * np.pi * (1 + np.tanh(crowding * nodes) / np.tanh(crowding))
    slopes = crowding / (np.tanh(crowding) * np.square(np.cosh(crowding * nodes)))
    sides = 2 * widths  # with one width, one side of the plane of incidence mirrors the other
    phi = np.concatenate([quadrant + k * 0.5 * np.pi for k in range(sides)])
    phi_weights = np.tile((np.pi / sides) * shares * slopes, sides)[:, None]
    wo, weights = half_vector_nodes(wi, phi, polar, least)
    weights = np.maximum(weights * phi_weights * wo[..., 2], 0).reshape(len(wi), -1)
    pairs = np.repeat(wi, weights.shape[1], axis=0), wo.reshape(-1, 3)
    wi, wo = (w.astype(np.float32) for w in pairs)
    wi.flags.writeable = wo.flags.writeable = False
    return AlbedoRule(wi, wo, weights.astype(np.float32))
