"""Quadrature for the directional albedo of codes at ten angles, and interpolation between them.

The albedo is smooth in ln(cos + 0.1), and a polynomial interpolates it between the angles. Below an
interface with an index below one, a rest is dark beyond the critical angle. The edge is as sharp as
the interface is smooth, and a polynomial swings there. The polynomial is therefore clipped to the
range of the albedos at the two neighbouring angles.

For anisotropic codes the angles are repeated at several azimuths of wi, in one quadrant, because
these codes are symmetric about the xz and the yz plane.
"""

import functools
from importlib.resources import files
from typing import NamedTuple

import numpy as np

from urushi.core.quadrature import gauss, half_vector_nodes

#: The variable of the interpolating polynomial is ln(cos + this).
COSINE_OFFSET = 0.1

#: Number of cosines, evenly spaced in that variable, at which the polynomial is evaluated.
INTERPOLATED_COSINES = 41

#: Share by which the polynomial may leave the range of the albedos at the two neighbouring angles:
#: the albedo may have its maximum between them.
OVERSHOOT = 0.05


#: Azimuths and cosines of wi in the rule of anisotropic codes.
AZIMUTHS = (0.0, 0.25 * np.pi, 0.5 * np.pi)
ANISOTROPIC_COSINES = (1.0, 0.925, 0.735, 0.51, 0.315, 0.175, 0.09)

#: Nodes of the anisotropic rule for each wi: number in theta_h, number in a quadrant of the
#: azimuth, how strongly they crowd at the quadrant's ends, and least tan(theta_h). Errors of the
#: albedo of white lobes with quotients of widths up to 8 are below 0.006.
POLAR_NODES, QUADRANT_NODES, CROWDING, LEAST_TANGENT = 14, 8, 1.5, 1e-3


class AlbedoRule(NamedTuple):
    """A quadrature of M nodes for the albedo at K angles, and its interpolation to D angles.

    K and D count the angles of all azimuths, one azimuth after the other.
    """

    wi: np.ndarray  # read-only float32 (M, 3)
    wo: np.ndarray  # read-only float32 (M, 3)
    weights: np.ndarray  # (M,), wo's cosine included; the nodes of an angle are contiguous
    first: np.ndarray  # (K,) index of the first node of each angle
    cosines: np.ndarray  # (D,) of the wi at which albedos are interpolated
    polynomial: np.ndarray  # (D, K), from albedos at the angles to the polynomial's at `cosines`
    # (D,) index of the left neighbour among the angles, whose cosines fall; at most K - 2.
    left: np.ndarray

    def albedo(self, f: np.ndarray) -> np.ndarray:
        """Directional albedos (..., D) of BRDFs with values f (..., M) at the nodes."""
        return self.interpolated(self.at_angles(f))

    def at_angles(self, f: np.ndarray) -> np.ndarray:
        """Directional albedos (..., K) at the rule's own angles."""
        return np.add.reduceat(f * self.weights, self.first, axis=-1)

    def interpolated(self, albedos: np.ndarray) -> np.ndarray:
        """Albedos (..., D) at `cosines` from those at the angles (..., K)."""
        left, right = albedos.take(self.left, -1), albedos.take(self.left + 1, -1)
        least = np.minimum(left, right) * (1 - OVERSHOOT)
        return np.clip(
            albedos @ self.polynomial.T, least, np.maximum(left, right) * (1 + OVERSHOOT)
        )


@functools.cache
def albedo_rule(widths: int = 1) -> AlbedoRule:
    """The rule of codes of one GGX width or two.

    `albedo_rule.csv` holds the rule of one width; `benchmarks/albedo_rule.py` makes it.
    """
    return _isotropic_rule() if widths == 1 else _anisotropic_rule()


def _isotropic_rule() -> AlbedoRule:
    """The rule of the file."""
    lines = (files("urushi.material") / "albedo_rule.csv").read_text(encoding="ascii").splitlines()
    cos_i, *wo, weights = np.loadtxt(lines, delimiter=",").T
    first = np.flatnonzero(np.diff(cos_i, prepend=2.0))
    parts = np.split(np.stack(wo, axis=-1), first[1:]), np.split(weights, first[1:])
    return _rule((0.0,), cos_i[first], [*zip(*parts, strict=True)])


def _anisotropic_rule() -> AlbedoRule:
    """Half vectors logarithmic in tan theta_h, dense in azimuth near the xz and the yz plane.

    Lobes of two very different widths are narrow near these planes. The nodes end at the horizon of
    wo, as in `core.quadrature.half_vector_rule`.
    """
    nodes = [_half_vector_nodes(phi, cosine) for phi in AZIMUTHS for cosine in ANISOTROPIC_COSINES]
    return _rule(AZIMUTHS, np.array(ANISOTROPIC_COSINES), nodes)


def _rule(
    azimuths: tuple[float, ...],
    cosines: np.ndarray,
    parts: list[tuple[np.ndarray, np.ndarray]],
) -> AlbedoRule:
    """The rule of angles whose cosines (A,) fall; parts: wo (M, 3) and weights (M,) for each wi."""
    phi, cosine = (x.ravel() for x in np.meshgrid(azimuths, cosines, indexing="ij"))
    sine, counts = np.sqrt(1 - cosine**2), [len(weights) for _, weights in parts]
    incident = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=-1)
    wi = np.repeat(incident, counts, axis=0).astype(np.float32)
    wo = np.concatenate([wo for wo, _ in parts]).astype(np.float32)
    wi.flags.writeable = wo.flags.writeable = False
    angles = np.log(cosines + COSINE_OFFSET)
    between = np.linspace(angles[0], angles[-1], INTERPOLATED_COSINES)
    # The angles fall, and so do those between them.
    left = np.clip(np.searchsorted(-angles, -between, side="right") - 1, 0, len(angles) - 2)
    return AlbedoRule(
        wi,
        wo,
        np.concatenate([weights for _, weights in parts]),
        np.cumsum([0, *counts[:-1]]),
        np.tile(np.exp(between) - COSINE_OFFSET, len(azimuths)),
        np.kron(np.eye(len(azimuths)), _lagrange(angles, between)),
        np.concatenate([left + k * len(angles) for k in range(len(azimuths))]),
    )


def _half_vector_nodes(azimuth: float, cosine: float) -> tuple[np.ndarray, np.ndarray]:
    """Directions wo (M, 3) and weights (M,), their cosines included, for one wi."""
    sine = np.sqrt(1 - cosine * cosine)
    nodes, shares = gauss(QUADRANT_NODES)
    # Gauss's nodes, drawn towards both ends of a quadrant.
    quadrant = 0.25 * np.pi * (1 + np.tanh(CROWDING * nodes) / np.tanh(CROWDING))
    slopes = CROWDING / (np.tanh(CROWDING) * np.square(np.cosh(CROWDING * nodes)))
    phi = np.concatenate([quadrant + k * 0.5 * np.pi for k in range(4)])
    phi_weights = np.tile(0.25 * np.pi * shares * slopes, 4)[:, None]
    wi = np.array([[sine * np.cos(azimuth), sine * np.sin(azimuth), cosine]])
    (wo,), (weights,) = half_vector_nodes(wi, phi, POLAR_NODES, LEAST_TANGENT)
    weights = weights * phi_weights * wo[..., 2]
    above = weights > 0
    return wo[above], weights[above]


def _lagrange(nodes: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The matrix (X, N) that maps values at nodes (N,) to their polynomial's values at x (X,)."""
    columns = []
    for index, node in enumerate(nodes):
        others = np.delete(nodes, index)
        columns.append(np.prod((x[:, None] - others) / (node - others), axis=1))
    return np.stack(columns, axis=1)
