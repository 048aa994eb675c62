"""The mip pyramid of a latent texture: codes of BRDFs averaged over areas, level by level.

Each level is averaged from the level below, in bands of rows, on all cores. The code of an average
BRDF is not the average of the codes. `lifted` turns codes into numbers whose averages give the code
of the average (`dropped`).

The rest has the mean of the light that the rests reflect. Its other numbers are averaged with this
light as weights. The light is the mean of f at a few pairs of cosine density.

The lobes (`nets.lobe`) are averaged separately. f is linear in the Fresnel factors, which are
averaged. The albedo of a lobe is nearly linear in the square root of its width. The roots are
averaged with the light that each lobe reflects as weights. A sum of lobes of several widths is not
one lobe: the average keeps the energy, and is less accurate in f.
"""

import functools
import itertools
from collections.abc import Callable

import numpy as np

from urushi import parallel
from urushi.core.probe_pairs import even_points
from urushi.nets.lobe import LOBE_NUMBERS, fresnel, reflectance
from urushi.nets.weights import Model

#: Number of texels that are averaged at once, in whole rows: their numbers stay in a core's cache.
BAND_TEXELS = 1 << 10

#: From indices (n,) of texels to their codes (n, channels, size).
ReadCodes = Callable[[np.ndarray], np.ndarray]


def coarse_levels(model: Model, width: int, height: int, read: ReadCodes) -> np.ndarray:
    """Codes float32 (n, channels, size) of all levels but the first, from the finest.

    width, height: of the first level. read: reads codes of the first level, from several threads.
    """

    def first(index: np.ndarray) -> np.ndarray:
        return _of_each_code(lambda z: lifted(model, z), read(index).astype(np.float32))

    numbers: Callable[[np.ndarray], np.ndarray] = first
    levels = [read(np.arange(0)).astype(np.float32)]  # none if the first level is one texel
    for finer, (_, h) in itertools.pairwise(level_sizes(width, height)):
        means = _means(numbers, finer, h)
        codes = np.empty((len(means), means.shape[1], model.arch.latent), np.float32)
        parallel.fill_blocks(codes, lambda x: _of_each_code(lambda m: dropped(model, m), x), means)
        levels.append(codes)
        numbers = means.__getitem__
    return np.concatenate(levels)


def _means(
    numbers: Callable[[np.ndarray], np.ndarray], finer: tuple[int, int], height: int
) -> np.ndarray:
    """Averages (n, channels, K) for a level of this height, from numbers of the finer level."""
    from_w, from_h = finer
    bands = np.array_split(np.arange(height), max(from_w * from_h // BAND_TEXELS, 1))
    bands = [band for band in bands if len(band)]
    parts: list[np.ndarray] = [np.empty(0)] * len(bands)

    def average(index: int) -> None:
        top, bottom = bands[index][0], bands[index][-1] + 1
        rows = source_rows(top, bottom, from_h)
        of_rows = numbers(np.arange(rows.start * from_w, rows.stop * from_w))
        of_rows = of_rows.reshape(len(rows), from_w, *of_rows.shape[1:])
        means = half_resolution(of_rows, top, from_h)
        parts[index] = means.reshape(-1, *means.shape[2:])

    parallel.run_all_cores(average, range(len(bands)))
    return np.concatenate(parts)


def _of_each_code(function: Callable[[np.ndarray], np.ndarray], rows: np.ndarray) -> np.ndarray:
    """A function of rows (n, K), for texels (n, channels, K)."""
    return function(rows.reshape(-1, rows.shape[-1])).reshape(*rows.shape[:2], -1)


def level_sizes(width: int, height: int) -> list[tuple[int, int]]:
    """Width and height of all levels, from the given one to a single texel."""
    levels = [(width, height)]
    while levels[-1] != (1, 1):
        width, height = (max(side // 2, 1) for side in levels[-1])
        levels.append((width, height))
    return levels


def source_rows(top: int, bottom: int, height: int) -> range:
    """Rows of a level of the given height that rows `top` to `bottom` of the next level average."""
    return range(2 * top, 2 * bottom + height % 2) if height > 1 else range(1)


def half_resolution(values: np.ndarray, top: int, height: int) -> np.ndarray:
    """Averages (h, w, ...) over areas of a level's values (H, W, ...): rows of the next level.

    values: of the rows that `source_rows` gives. top: first row. height: of the whole level.
    """
    halved = _half(values, top, height).swapaxes(0, 1)
    return _half(halved, 0, values.shape[1]).swapaxes(0, 1)


def _half(values: np.ndarray, first: int, count: int) -> np.ndarray:
    """Averages along the first axis: of two values, or of three by area if `count` is odd."""
    if count == 1:
        return values
    half = len(values) // 2
    parts = [values[start : start + 2 * half - 1 : 2] for start in (0, 1)]
    if count % 2 == 0:
        return 0.5 * (parts[0] + parts[1])
    parts.append(values[2 : 2 * half + 1 : 2])
    index = np.arange(first, first + half, dtype=np.float32)
    index = index.reshape(-1, *[1] * (values.ndim - 1))
    whole = count // 2
    weights = (whole - index) / count, np.float32(whole / count), (index + 1) / count
    return sum(weight * part for weight, part in zip(weights, parts, strict=True))


#: Number of pairs whose mean f is the light of a rest, and the least light in a division.
LIGHT_PAIRS, LEAST_LIGHT = 32, 1e-12

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
    whole = np.pad(rest[:, None], [(0, 0), (0, 0), (model.arch.lobe, 0)])
    f = model.networks.rest(whole, _features(model))
    return np.maximum(f.mean(axis=-1), LEAST_LIGHT)


@functools.lru_cache(maxsize=4)
def _features(model: Model) -> np.ndarray:
    """What rests need of `LIGHT_PAIRS` even pairs of directions of cosine density."""
    u, v = np.split(even_points(LIGHT_PAIRS, 4), 2, axis=1)
    wi, wo = (
        np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1 - r * r)], axis=-1)
        for r, phi in ((np.sqrt(w[:, 0]), 2 * np.pi * w[:, 1]) for w in (u, v))
    )
    return model.networks.features(wi.astype(np.float32), wo.astype(np.float32))


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
