"""The quadrature by which the directional albedo of codes is measured at ten angles and between.

The albedo is smooth in ln(cos + 0.1), and a polynomial interpolates it between the angles. A rest
below an interface of an index below one is dark beyond the critical angle, with an edge as sharp as
the interface is smooth, where a polynomial swings. Its values are therefore clipped to those at the
two angles beside them.

For anisotropic codes the angles are repeated at several azimuths of wi, in one quadrant, because
these codes are symmetric about the xz and the yz plane.
"""

import functools
from importlib.resources import files
from typing import NamedTuple

import numpy as np

from urushi.geometry.half_vector import turned
from urushi.nets.features import direction_features

#: The variable of the interpolating polynomial is ln(cos + this).
COSINE_OFFSET = 0.1

#: Number of cosines, evenly spaced in that variable, at which the polynomial is evaluated.
INTERPOLATED_COSINES = 41

#: Share by which the polynomial may leave the range of the values at the two angles beside it: the
#: albedo may have its maximum between them.
OVERSHOOT = 0.05


#: Azimuths of wi in the rule of anisotropic codes, evenly spaced from 0 to 90 degrees.
AZIMUTHS = 4


class AlbedoRule(NamedTuple):
    """A quadrature for the directional albedo at K angles of M nodes in all, and between them.

    K and D count the angles of all azimuths, one azimuth after the other.

    Attributes:
        wi, wo: read-only float32 (M, 3).
        features: float32 (M, F), the decoder's input features of wi and wo.
        weights: (M,), wo's cosine included; the nodes of an angle are contiguous.
        first: (K,) index of the first node of each angle.
        cosines: (D,) of the wi at which albedos are interpolated.
        polynomial: (D, K), from the albedos at the angles to those of the polynomial at `cosines`.
        left: (D,) index of the last angle whose cosine is not below that of `cosines`; K - 2 at
            the last.
    """

    wi: np.ndarray
    wo: np.ndarray
    features: np.ndarray
    weights: np.ndarray
    first: np.ndarray
    cosines: np.ndarray
    polynomial: np.ndarray
    left: np.ndarray

    def albedo(self, f: np.ndarray) -> np.ndarray:
        """Directional albedos (..., D) of BRDFs with values f (..., M) at the nodes."""
        return self.interpolated(self.at_angles(f))

    def at_angles(self, f: np.ndarray) -> np.ndarray:
        """Directional albedos (..., K) at the rule's own angles."""
        return np.add.reduceat(f * self.weights, self.first, axis=-1)

    def interpolated(self, albedos: np.ndarray) -> np.ndarray:
        """Albedos (..., D) at `cosines` from those at the angles (..., K)."""
        least, most = self._bounds(albedos)
        return np.clip(albedos @ self.polynomial.T, least, most)

    def interpolated_slopes(self, albedos: np.ndarray, index: int) -> np.ndarray:
        """Derivatives (K,) of `interpolated` at one of the cosines by the albedos (K,)."""
        value, slopes = self.polynomial[index] @ albedos, np.zeros(len(albedos))
        least, most = (bound[index] for bound in self._bounds(albedos))
        left = self.left[index]
        beside = albedos[left : left + 2]
        if value > most:
            slopes[left + beside.argmax()] = 1 + OVERSHOOT
        elif value < least:
            slopes[left + beside.argmin()] = 1 - OVERSHOOT
        else:
            slopes[:] = self.polynomial[index]
        return slopes

    def _bounds(self, albedos: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The range of `interpolated`, each (..., D)."""
        left, right = albedos[..., self.left], albedos[..., self.left + 1]
        return np.minimum(left, right) * (1 - OVERSHOOT), np.maximum(left, right) * (1 + OVERSHOOT)


@functools.cache
def albedo_rule(widths: int = 1) -> AlbedoRule:
    """The rule of codes of one GGX width or two.

    That of one is in `albedo_rule.csv`; `benchmarks/quality/albedo_rule.py` makes and measures it.
    """
    return _isotropic_rule() if widths == 1 else _anisotropic_rule()


def _isotropic_rule() -> AlbedoRule:
    """The rule of the file."""
    lines = (files("urushi.material") / "albedo_rule.csv").read_text(encoding="ascii").splitlines()
    cos_i, x, y, z, weights = np.loadtxt(lines, delimiter=",").T
    wi = np.stack([np.sqrt(1 - cos_i**2), np.zeros_like(cos_i), cos_i], axis=-1).astype(np.float32)
    wo = np.stack([x, y, z], axis=-1).astype(np.float32)
    wi.flags.writeable = wo.flags.writeable = False
    first = np.flatnonzero(np.diff(cos_i, prepend=2.0))
    angles = np.log(cos_i[first] + COSINE_OFFSET)
    between = np.linspace(angles[0], angles[-1], INTERPOLATED_COSINES)
    # The angles fall, and so do those between them.
    left = np.clip(np.searchsorted(-angles, -between, side="right") - 1, 0, len(angles) - 2)
    features = direction_features(wi, wo)
    return AlbedoRule(
        wi,
        wo,
        features,
        weights,
        first,
        np.exp(between) - COSINE_OFFSET,
        _lagrange(angles, between),
        left,
    )


def _anisotropic_rule() -> AlbedoRule:
    """The rule of the file at every azimuth; its nodes are on one side of the plane of wi."""
    rule = albedo_rule()
    mirrored = rule.wo * np.array([1, -1, 1], np.float32)
    counts = np.diff(rule.first, append=len(rule.weights))
    order = np.concatenate(
        [
            np.concatenate([k, k + len(rule.weights)])
            for k in np.split(np.arange(len(rule.weights)), rule.first[1:])
        ]
    )
    wi, wo = np.tile(rule.wi, (2, 1))[order], np.concatenate([rule.wo, mirrored])[order]
    turns = np.linspace(0, 0.5 * np.pi, AZIMUTHS)
    wi, wo = (
        np.concatenate([turned(w, np.full(len(w), turn)) for turn in turns]).astype(np.float32)
        for w in (wi.astype(np.float64), wo.astype(np.float64))
    )
    wi.flags.writeable = wo.flags.writeable = False
    angles = len(counts)
    return AlbedoRule(
        wi,
        wo,
        direction_features(wi, wo, 2),
        np.tile(0.5 * np.tile(rule.weights, 2)[order], AZIMUTHS),
        np.cumsum(np.concatenate([[0], 2 * np.tile(counts, AZIMUTHS)[:-1]])),
        np.tile(rule.cosines, AZIMUTHS),
        np.kron(np.eye(AZIMUTHS), rule.polynomial),
        np.concatenate([rule.left + k * angles for k in range(AZIMUTHS)]),
    )


def _lagrange(nodes: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The matrix (X, N) from values at nodes (N,) to those of their polynomial at x (X,)."""
    columns = []
    for index, node in enumerate(nodes):
        others = np.delete(nodes, index)
        columns.append(np.prod((x[:, None] - others) / (node - others), axis=1))
    return np.stack(columns, axis=1)
