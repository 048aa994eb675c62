"""Averages of BRDFs that are given as latent codes, for the mip pyramid.

The code of an average BRDF is not the average of the codes. `lifted` turns codes into numbers whose
averages give the code of the average (`dropped`).

The rest has the mean of the light that the rests reflect. Its other numbers are averaged with this
light as weights. The light is the mean of f at a few pairs of cosine density.

The lobes (`nets.lobe`) are averaged separately. f is linear in the Fresnel factors, which are
averaged. The albedo of a lobe is nearly linear in the square root of its width. The roots are
averaged with the light that each lobe reflects as weights. A sum of lobes of several widths is not
one lobe: the average keeps the energy, and is less accurate in f.
"""

import functools

import numpy as np

from urushi.core.probe_pairs import even_points
from urushi.nets import decoder
from urushi.nets.features import direction_features
from urushi.nets.lobe import LOBE_NUMBERS, fresnel, reflectance
from urushi.nets.weights import Model

#: Number of pairs whose mean f is the light of a rest, and the least light in a division.
LIGHT_PAIRS, LEAST_LIGHT = 8, 1e-12

#: Numbers of `lifted_lobes`, and the cosines over which a lobe's reflectance is averaged.
LIFTED_LOBE, COSINES = 9, np.array([1.0, 0.8, 0.6, 0.4, 0.2], np.float32)

#: Least weight of a lobe: lobes that do not reflect have an average too.
LEAST_WEIGHT = 1e-6

#: Mean k above which an averaged index counts as a metal's.
LEAST_K = 1e-3


def lifted(model: Model, z: np.ndarray) -> np.ndarray:
    """Numbers float32 (n, K) of codes (n, L): `lifted_lobes`, and light and rests times light."""
    lobe, rest = np.split(z, [model.arch.lobe], axis=1)
    light = _light(model, rest)[:, None]
    return np.concatenate([lifted_lobes(lobe), light, light * rest], axis=1)


def dropped(model: Model, means: np.ndarray) -> np.ndarray:
    """Codes float32 (n, L) of averages (n, K) of `lifted`."""
    count = LIFTED_LOBE + model.arch.lobe - len(LOBE_NUMBERS)
    lobes, light, rest = np.split(means, [count, count + 1], axis=1)
    rest = rest / light
    rest[:, :1] += np.log(light / _light(model, rest)[:, None])  # the gain
    return np.concatenate([dropped_lobes(lobes), rest], axis=1)


def _light(model: Model, rest: np.ndarray) -> np.ndarray:
    """Mean f (n,) of the rests (n, R) of codes at the pairs of cosine density."""
    f = decoder.decode(model.params, model.arch, rest[:, None], _features(model.widths))
    return np.maximum(f.mean(axis=-1), LEAST_LIGHT)


@functools.cache
def _features(widths: int) -> np.ndarray:
    """The decoder's features (N, F) of `LIGHT_PAIRS` even pairs of directions of cosine density."""
    u, v = np.split(even_points(LIGHT_PAIRS, 4), 2, axis=1)
    wi, wo = (
        np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1 - r * r)], axis=-1)
        for r, phi in ((np.sqrt(w[:, 0]), 2 * np.pi * w[:, 1]) for w in (u, v))
    )
    return direction_features(wi.astype(np.float32), wo.astype(np.float32), widths)


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
