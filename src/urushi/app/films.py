"""Metals under a thin film, which the page offers: their f is a table in closed form.

Descriptions have no films, and networks are trained on surfaces without one. The reflectance is
that of `openpbr_surface.thin_film` for the three channels. A coat on the page lies over the code of
a metal of the mean reflectance.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from urushi.material import Material, encode
from urushi.material.table import node_pairs, table_of_values
from urushi.nets import lobe as lobes
from urushi.nets.weights import Model
from urushi.openpbr_surface import thin_film
from urushi.walk import conductor


class FilmedMetal(NamedTuple):
    """A rough metal under a film, in air.

    Attributes:
        alpha: GGX width.
        eta, k: complex index of the metal, of red, green and blue.
        ior: index of the film.
        thickness: of the film [um].
    """

    alpha: float
    eta: tuple[float, float, float]
    k: tuple[float, float, float]
    ior: float
    thickness: float

    def reflectance(self, cosine: np.ndarray) -> np.ndarray:
        """Reflectance (N, 3) of a facet at cosines (N,)."""
        film = thin_film.Film(self.ior, self.ior, self.thickness)
        below = map(thin_film.Below, self.eta, self.k)
        columns = zip(below, thin_film.RGB, strict=True)
        return np.stack([thin_film.reflectance(cosine, film, *pair) for pair in columns], axis=-1)

    def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """The BRDF (N, 3) [1/sr] of directions (N, 3) above the horizon."""
        white = np.array([self.alpha, 1, 1, 0, 1.5, 0], np.float32)
        cosine = 0.5 * np.linalg.norm(wi + wo, axis=-1)
        return lobes.f(white, wi, wo)[:, None] * self.reflectance(np.minimum(cosine, 1))

    def material(self, model: Model) -> Material:
        """Codes and table."""
        mean = tuple(self.reflectance(np.array([MEAN_COSINE]))[0])
        return replace(
            encode(conductor(self.alpha, r0=mean), model),
            table=table_of_values(self.f(*node_pairs())),
        )


#: Cosine at which a reflectance is about its mean over the facets that diffuse light meets.
MEAN_COSINE = 0.66

#: Niobium as Mitsuba has it in its RGB variants.
_NIOBIUM = (3.42, 2.79, 2.396), (3.441, 2.738, 2.58)

#: By name: anodised niobium, the metal of coins and jewellery, whose oxide has an index of 2.3.
FILMS = {
    "anodised niobium, blue": FilmedMetal(0.15, *_NIOBIUM, ior=2.3, thickness=0.06),
    "anodised niobium, magenta": FilmedMetal(0.15, *_NIOBIUM, ior=2.3, thickness=0.16),
}
