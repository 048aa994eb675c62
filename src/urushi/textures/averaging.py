"""Averages of BRDFs that are given as latent codes, for the mip pyramid.

The code of an average BRDF is not the average of the codes. An average of codes z is computed in
four steps, with the decoder D at the encoder's probe pairs and the encoder E:

1. Average the values: f = mean D(z).
2. Encode: E(f).
3. Add the mean residual, mean(z - E(D(z))), so that equal codes keep their code exactly.
4. Take two damped Gauss-Newton steps towards f (`material.correction`). They bring the decoded
   values five times closer to f.

These steps apply to the rests of the codes (`textures.averaging_rest`). The lobes (`nets.lobe`) are
averaged separately. f is linear in the Fresnel factors, which are averaged. The albedo of a lobe is
nearly linear in the square root of its width. The roots are averaged with the light that each lobe
reflects as weights. A sum of lobes of several widths is not one lobe: the average keeps the energy,
and is less accurate in f.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from urushi.nets.lobe import LOBE_NUMBERS, fresnel, reflectance
from urushi.nets.weights import Model
from urushi.textures.averaging_rest import DecodedSpace, RegressionSpace, rest_space


def averaging_space(
    model: Model, read: Callable[[np.ndarray], np.ndarray], count: int
) -> "LobedSpace":
    """The space in which the codes of one texture are averaged.

    Args:
        model: the networks.
        read: from indices below `count` to codes (n, L).
        count: number of codes in the texture.

    The seed of the sample is fixed.
    """
    networks = model.networks
    lobe = networks.arch.lobe
    return LobedSpace(lobe, rest_space(networks, lambda index: read(index)[:, lobe:], count))


class LobedSpace(NamedTuple):
    """Codes with lobes: numbers of the lobes together with the points of the rest.

    Attributes:
        lobe: how many numbers a lobe has.
        rest: the space of the numbers that follow the lobe.
    """

    lobe: int
    rest: DecodedSpace | RegressionSpace

    def lift(self, z: np.ndarray) -> np.ndarray:
        """`lifted_lobes` of the lobes, side by side with the lifted rest."""
        lobe, rest = np.split(z, [self.lobe], axis=1)
        return np.concatenate([lifted_lobes(lobe), self.rest.lift(rest)], axis=1)

    def drop(self, means: np.ndarray) -> np.ndarray:
        """The lobes, and the codes of the rest."""
        lobes, rest = np.split(means, [LIFTED_LOBE + self.lobe - len(LOBE_NUMBERS)], axis=1)
        return np.concatenate([dropped_lobes(lobes), self.rest.drop(rest)], axis=1)


#: Numbers of a lobe in `LobedSpace`, and the cosines over which its reflectance is averaged.
LIFTED_LOBE, COSINES = 9, np.array([1.0, 0.8, 0.6, 0.4, 0.2], np.float32)

#: Least weight of a lobe: lobes that do not reflect have an average too.
LEAST_WEIGHT = 1e-6

#: Mean k above which an averaged index counts as a metal's.
LEAST_K = 1e-3


def lifted_lobes(lobe: np.ndarray) -> np.ndarray:
    """Numbers float32 (n, 9) of lobes (n, 6) whose averages give the lobe of an average.

    A second width, of lobes (n, 7), gives a tenth number.
    """
    alpha, normal, grazing, exact, eta, k, *across = lobe.T
    bright = reflectance(lobe[:, None], COSINES).mean(axis=-1) + LEAST_WEIGHT
    indexed = exact + LEAST_WEIGHT
    head_on = fresnel(np.float32(1.0), eta, k)
    weighted = [bright, bright * np.sqrt(alpha), indexed, *(indexed * x for x in (eta, k, head_on))]
    weighted += [bright * np.sqrt(width) for width in across]
    return np.stack([normal, grazing, exact, *weighted], axis=-1).astype(np.float32)


def dropped_lobes(means: np.ndarray) -> np.ndarray:
    """Lobes float32 (n, 6 or 7) of averages (n, 9 or 10) of `lifted_lobes`.

    The averaged index has the mean reflectance at normal incidence. A dielectric's index is on the
    same side of one as the mean index; a metal has the mean eta.
    """
    normal, grazing, exact, bright, root_width, indexed, *others = means.astype(np.float64).T
    eta, k, head_on = (x / indexed for x in others[:3])
    across = [np.square(root / bright) for root in others[3:]]
    head_on = np.clip(head_on, 0, 0.999)
    root = np.sqrt(head_on) * np.where(eta >= 1, 1, -1)
    squared = (head_on * (1 + eta) ** 2 - (1 - eta) ** 2) / (1 - head_on)
    metal = k > LEAST_K
    eta = np.where(metal, eta, (1 + root) / (1 - root))
    k = np.where(metal, np.sqrt(np.maximum(squared, 0)), 0)
    alpha = np.square(root_width / bright)
    return np.stack([alpha, normal, grazing, exact, eta, k, *across], axis=-1).astype(np.float32)
