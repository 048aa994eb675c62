"""Blends of latent codes, whose reflected light is linear in the blend weight.

The Fresnel factors of the lobes (`urushi.nets.lobe`) are blended linearly. Their widths are
weighted by the light that each lobe reflects, because the width of a lobe that reflects nothing is
meaningless. Indices are weighted by the light of the exact Fresnel term; its factor is then set so
that its light is the linear blend of the two. The numbers of the rests are weighted by the light of
each rest; the gain is then set in the same way, from the mean albedo of the rest over the angles.
"""

import numpy as np

from urushi.material import energy
from urushi.nets import lobe as lobes
from urushi.nets.weights import Model

#: Cosines over which the reflectance of a lobe is averaged.
COSINES = np.array([1.0, 0.8, 0.6, 0.4, 0.2])


def blend_codes(model: Model, a: np.ndarray, b: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Codes (C, L) between a and b (C, L); share: (C,) of b, in [0, 1]."""
    networks, size = model.networks, model.arch.latent
    count = networks.arch.lobe
    codes = np.empty((len(share), size), np.float32)
    codes[:, :count] = blend_lobes(a[:, :count], b[:, :count], share)
    light = [energy.rest_albedos(model, z).mean(axis=-1) for z in (a, b)]
    wanted = (1.0 - share) * light[0] + share * light[1]
    part = (share * light[1] / wanted)[:, None]
    codes[:, count:] = (1.0 - part) * a[:, count:] + part * b[:, count:]
    found = energy.rest_albedos(model, codes).mean(axis=-1)
    return networks.rest_scaled(codes, wanted / found)


def blend_lobes(a: np.ndarray, b: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Lobes (C, N) between a and b (C, N); share: (C,) of b, in [0, 1]."""
    light = [lobes.reflectance(lobe[:, None], COSINES).mean(axis=-1) for lobe in (a, b)]
    exact = [_exact_reflectance(lobe) for lobe in (a, b)]
    of_width = _share_of_b(light[0], light[1], share)
    of_index = _share_of_b(a[:, 3] * exact[0], b[:, 3] * exact[1], share)
    others = [of_width] * (a.shape[-1] - len(lobes.LOBE_NUMBERS))
    shares = np.stack([of_width, *[share] * 3, of_index, of_index, *others], axis=-1)
    blend = (1.0 - shares) * a + shares * b
    own = np.maximum(_exact_reflectance(blend), 1e-30)
    factor = (1.0 - share) * a[:, 3] * (exact[0] / own) + share * b[:, 3] * (exact[1] / own)
    # Never more than the linear blend, so that no light is gained at grazing angles.
    blend[:, 3] = np.minimum(blend[:, 3], factor)
    return blend


def _exact_reflectance(lobe: np.ndarray) -> np.ndarray:
    """Mean (C,) over the cosines of the exact Fresnel term of lobes (C, N), for a factor of one."""
    return lobes.fresnel(COSINES, lobe[:, None, 4], lobe[:, None, 5]).mean(axis=-1)


def _share_of_b(size_a: np.ndarray, size_b: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Shares (C,) of b in proportion to sizes (C,); `share` itself where both sizes are zero."""
    total = (1.0 - share) * size_a + share * size_b
    return np.where(total > 0, share * size_b / np.maximum(total, 1e-30), share)
