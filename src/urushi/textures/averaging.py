"""Averaging BRDFs that are given as latent codes, for the mip pyramid.

The code of an average BRDF is not the average of the codes. Averages are therefore taken of values
at the encoder's probe pairs, and encoded again: E(mean D(z)), where D decodes a code z at the probe
pairs and E is the encoder. E(D(z)) differs slightly from z. The mean of this *residual* z - E(D(z))
is added, so that an area of equal codes keeps its code exactly. Two damped Gauss-Newton steps
(`material.correction`) then bring the code five times closer to the averaged values.

This is done for the rests of the codes (`textures.averaging_rest`); their lobes (`nets.lobe`) are
averaged separately. The Fresnel factors of the lobes are averaged linearly, because f is linear in
them. The square roots of their widths are weighted by the light that each lobe reflects, because
the albedo of a lobe is nearly linear in the root. One lobe cannot represent a sum of several
widths, so f of an average is less accurate than its energy.
"""

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np

from urushi.nets.lobe import LOBE_NUMBERS, fresnel, reflectance
from urushi.nets.networks import UrushiNetworks
from urushi.nets.weights import Model
from urushi.textures.averaging_rest import DecodedSpace, RegressionSpace, rest_space


class AveragingSpace(Protocol):
    """A linear space in which BRDFs are averaged."""

    def lift(self, z: np.ndarray) -> np.ndarray:
        """Points (n, K) of latent codes (n, L)."""

    def drop(self, means: np.ndarray) -> np.ndarray:
        """Latent codes (n, L) of averaged points (n, K)."""

    def fits(self, z: np.ndarray) -> bool:
        """Whether the space is valid for codes (n, L) other than those it was fitted to."""


def averaging_space(
    model: Model, read: Callable[[np.ndarray], np.ndarray], count: int
) -> AveragingSpace:
    """The space in which the codes of one texture are averaged.

    Args:
        model: the networks. Codes of other systems than Urushi's own are averaged themselves.
        read: from indices below `count` to codes (n, L).
        count: number of codes in the texture.

    The seed of the sample is fixed.
    """
    networks = model.networks
    if not isinstance(networks, UrushiNetworks):
        return LatentSpace()
    lobe = networks.arch.lobe
    return LobedSpace(lobe, rest_space(networks, lambda index: read(index)[:, lobe:], count))


class LatentSpace:
    """Averages of the codes themselves, as in Fan et al. (2022)."""

    def lift(self, z: np.ndarray) -> np.ndarray:
        """The codes."""
        return z

    def drop(self, means: np.ndarray) -> np.ndarray:
        """The averaged codes."""
        return means

    def fits(self, z: np.ndarray) -> bool:
        """Always."""
        return True


class LobedSpace(NamedTuple):
    """Codes with lobes: numbers of the lobes together with the points of the rest.

    Attributes:
        lobe: how many numbers a lobe has.
        rest: the space of the numbers after those of the lobe.
    """

    lobe: int
    rest: DecodedSpace | RegressionSpace

    def lift(self, z: np.ndarray) -> np.ndarray:
        """Factors, reflectance, and products with what they weigh, side by side with the rest."""
        lobe, rest = np.split(z, [self.lobe], axis=1)
        return np.concatenate([lifted_lobes(lobe), self.rest.lift(rest)], axis=1)

    def drop(self, means: np.ndarray) -> np.ndarray:
        """The lobes, and the codes of the rest."""
        lobes, rest = np.split(means, [LIFTED_LOBE + self.lobe - len(LOBE_NUMBERS)], axis=1)
        return np.concatenate([dropped_lobes(lobes), self.rest.drop(rest)], axis=1)

    def fits(self, z: np.ndarray) -> bool:
        """Whether it holds for the rest."""
        return self.rest.fits(z[:, self.lobe :])


#: Numbers of a lobe in `LobedSpace`, and the cosines over which its reflectance is averaged.
LIFTED_LOBE, COSINES = 9, np.array([1.0, 0.8, 0.6, 0.4, 0.2], np.float32)

#: Weights of a lobe that does not reflect, lest the numbers of many such have no average.
LEAST_WEIGHT = 1e-6

#: Mean k above which an averaged index is that of a metal.
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

    The index reflects as much at normal incidence as the averaged ones do: that of a dielectric is
    above one if their mean is, and a metal has their mean eta.
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
