"""The fitted model: a Lambertian part and GGX lobes with Schlick's Fresnel term, in NumPy."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from urushi.measured.hemisphere import evaluate


@dataclass(frozen=True)
class Lobe:
    """One lobe, ks D G F / (4 cos cos).

    Attributes:
        alpha: GGX width, the same in all channels.
        f0: Schlick's (1994) reflectance at normal incidence, the same in all channels.
        weight: (3,) the colour ks that multiplies it.
    """

    alpha: float
    f0: float
    weight: np.ndarray


@dataclass(frozen=True)
class GgxFit:
    """A BRDF of a Lambertian part and lobes.

    Widths and Fresnel terms are shared by the channels and the colours are free, as is customary
    since Ngan et al. 2005 ("Experimental analysis of BRDF models").

    Attributes:
        diffuse: (3,) the reflectance kd.
        lobes: one or two.
    """

    diffuse: np.ndarray
    lobes: tuple[Lobe, ...]

    def f(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """Evaluate: float32 (N, 3) [1/sr], without cosine, zero below the horizon.

        wi, wo: (N, 3) unit vectors.

        Raises:
            ParameterError: wrong shapes, or directions that are not unit vectors.
        """
        return evaluate(self._f, 3, wi, wo)

    def _f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        geometry = Geometry.of(wi, wo)
        result = np.broadcast_to(self.diffuse / np.pi, (len(wi), 3))
        for lobe in self.lobes:
            grey = shape(geometry, lobe.alpha) * schlick(geometry, lobe.f0)
            result = result + grey[:, None] * lobe.weight
        return result


@dataclass(frozen=True)
class Geometry:
    """What lobes depend on, (N,) each.

    Attributes:
        sin2_h, cos2_h: of the half vector's angle to the normal.
        tan2_i, tan2_o: of the directions' angles to it.
        cosines: product of the directions' cosines.
        edge: (1 - cos theta_d)^5.
    """

    sin2_h: np.ndarray
    cos2_h: np.ndarray
    tan2_i: np.ndarray
    tan2_o: np.ndarray
    cosines: np.ndarray
    edge: np.ndarray

    @classmethod
    def of(cls, wi: np.ndarray, wo: np.ndarray) -> "Geometry":
        """wi, wo: float64 (N, 3), unit vectors above the horizon."""
        half = wi + wo
        half /= np.linalg.norm(half, axis=1, keepdims=True)
        x2, y2, z2 = (half**2).T
        tan2_i, tan2_o = ((w[:, 0] ** 2 + w[:, 1] ** 2) / w[:, 2] ** 2 for w in (wi, wo))
        edge = (1 - np.clip(np.sum(half * wi, axis=1), 0, 1)) ** 5
        return cls(x2 + y2, z2, tan2_i, tan2_o, wi[:, 2] * wo[:, 2], edge)


def shape(g: Geometry, alpha: float) -> np.ndarray:
    """D G / (4 cos cos) with separable masking (Walter et al. 2007, equations 33, 34 and 20)."""
    alpha2 = alpha * alpha
    d = alpha2 / (np.pi * (alpha2 * g.cos2_h + g.sin2_h) ** 2)
    i, o = (1 + np.sqrt(1 + alpha2 * tan2) for tan2 in (g.tan2_i, g.tan2_o))
    return d / (i * o * g.cosines)  # G = (2 / i) (2 / o)


def schlick(g: Geometry, f0: float) -> np.ndarray:
    """Schlick's (1994) Fresnel term."""
    return f0 + (1 - f0) * g.edge
