"""Light transport inside a coat by adding, for BRDFs that are symmetric about the xz and yz plane.

The equations are those of `urushi.material.adding`. Directions are the cells of a map of the
quadrant x, y > 0 to a square (Shirley and Chiu 1997), all of the same solid angle. Light is a sum
of four parts: even in x and y, odd in x, odd in y, odd in both. A symmetric BRDF does not mix them.
It is therefore one matrix per part, where an isotropic one is a matrix per Fourier mode.
"""

import functools
from collections.abc import Sequence

import numpy as np

from urushi.checks import Widths
from urushi.core.microfacet import of_widths
from urushi.core.quadrature import half_vector_rule
from urushi.core.table import corner_steps
from urushi.material import adding
from urushi.material.crossing import facet_points, mirrored_from
from urushi.nets import lobe as lobes

#: Cells along a side of the square, and for each cell with an albedo of its own.
CELLS, COARSE = 24, 3

#: Signs of x and y of the images of a direction, and the factors of a part (row) at each image.
SIGNS = np.array([(1, 1), (-1, 1), (1, -1), (-1, -1)], np.float32)
PARTS = np.array([(1, 1, 1, 1), (1, -1, 1, -1), (1, 1, -1, -1), (1, -1, -1, 1)])

#: Of the images: half a turn about the normal, to which a mirror reflects.
TURNED = 3

#: Pairs at which a BRDF is evaluated at once.
BLOCK = 1 << 14

#: Azimuths of the quadrature of albedos, see `half_vector_rule`.
AZIMUTHS = 8


@functools.cache
def directions() -> np.ndarray:
    """The centres float32 (Q, 3) of the cells."""
    side = (np.arange(CELLS) + 0.5) / CELLS
    a, b = (x.ravel() for x in np.meshgrid(side, side, indexing="ij"))
    radius = np.maximum(a, b)
    turn = np.minimum(a, b) / radius * (np.pi / 4)
    phi = np.where(a > b, turn, np.pi / 2 - turn)
    z = 1 - radius * radius
    sine = np.sqrt(1 - z * z)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=-1).astype(np.float32)


def places(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates (M,) in [-1, 1] of directions (M, 3) in four such squares."""
    radius = np.sqrt(np.maximum(1 - w[:, 2], 0))
    x, y = np.abs(w[:, 0]), np.abs(w[:, 1])
    other = radius * np.arctan2(np.minimum(x, y), np.maximum(x, y)) * np.float32(4 / np.pi)
    a, b = np.where(x > y, radius, other), np.where(x > y, other, radius)
    return np.copysign(a, w[:, 0]), np.copysign(b, w[:, 1])


@functools.cache
def weights() -> np.ndarray:
    """Weights (Q,) that integrate over the cosine times the solid angle of a cell."""
    return directions()[:, 2].astype(np.float64) * (0.5 * np.pi / CELLS**2)


def parts(f: adding.Brdf, albedo: np.ndarray) -> np.ndarray:
    """The parts (C, 4, Q, Q) of a BRDF of albedos (Q, C), as `adding.Grid.brdf_modes`."""
    w, own = directions(), weights()
    count, every = len(w), []
    wi, cells = np.repeat(w, count, axis=0), np.arange(count)
    for sign in SIGNS:
        wo = np.tile(w * np.append(sign, np.float32(1)), (count, 1))
        blocks = [slice(k, k + BLOCK) for k in range(0, len(wi), BLOCK)]
        every.append(np.concatenate([f(wi[block], wo[block]) for block in blocks]))
    values = np.stack(every).reshape(4, count, count, -1)
    values[TURNED, cells, cells] = 0  # lobes are narrow there
    result = []
    for images, known in zip(np.moveaxis(values, -1, 0), albedo.T, strict=True):
        even = images.sum(axis=0, dtype=np.float64)
        factors = np.ones(count)
        for _ in range(3):
            sums = factors * (even @ (own * factors))
            factors *= np.sqrt(np.minimum(known / np.maximum(sums, 1e-30), 1))
        missing = np.maximum(known - factors * (even @ (own * factors)), 0)
        mirror = PARTS[:, TURNED, None, None] * np.diag(missing / own)
        result.append(np.tensordot(PARTS, images * (factors[:, None] * factors), 1) + mirror)
    return np.stack(result)


def bottom_parts(f: adding.Brdf) -> np.ndarray:
    """The parts (C, 4, Q, Q) of a BRDF. Albedos above 1 count as 1."""
    w, side = directions(), CELLS // COARSE
    some = w.reshape(side, COARSE, side, COARSE, 3)[:, COARSE // 2, :, COARSE // 2].reshape(-1, 3)
    wo, weight = half_vector_rule(some, anisotropic=True, azimuths=AZIMUTHS)
    wi = np.repeat(some, weight.shape[1], axis=0)
    values = f(wi, wo.reshape(-1, 3).astype(np.float32)).reshape(*weight.shape, -1)
    albedo = np.einsum("nmc,nm->nc", values.astype(np.float64), weight * wo[..., 2])
    albedo = albedo.reshape(side, side, -1).repeat(COARSE, axis=0).repeat(COARSE, axis=1)
    return parts(f, np.minimum(albedo, 1).reshape(len(w), -1))


@functools.lru_cache(maxsize=8)
def interface_parts(alpha: float | Widths, eta: float) -> np.ndarray:
    """The parts (4, Q, Q) of the reflection of an interface from below; eta: below over above."""
    if eta == 1:
        return np.zeros((4, CELLS**2, CELLS**2))
    outside = tuple(directions()[:, k, None] for k in range(3))
    albedo = mirrored_from(outside, alpha, 1 / eta, facet_points(256))[1].mean(axis=1)
    lobe = lobes.of_coat(of_widths(np.float32, alpha), np.float32(1 / eta))
    return parts(lambda wi, wo: lobes.f(lobe, wi, wo)[:, None], albedo[:, None])[0]


@functools.lru_cache(maxsize=8)
def medium_parts(albedo: float, sigma_t: float, g: float) -> np.ndarray:
    """Reflection and transmission (2, 4, Q, Q) of the light that a medium scatters."""
    own, w = adding.grid(), directions().astype(np.float64)
    turn, shares = np.arctan2(w[:, 1], w[:, 0]), own.shares(np.arccos(w[:, 2]))
    result = np.zeros((2, 4, len(w), len(w)))
    for modes, total in zip(adding.medium(albedo, sigma_t, g, own), result, strict=True):
        last = len(modes) - 1
        for m, mode in enumerate(modes):  # cos m (phi_i - phi_o), a sum of two products
            between = shares @ mode @ shares.T * ((4 if m in (0, last) else 8) / (2 * np.pi))
            odd = m % 2
            for part, wave in ((odd, np.cos(m * turn)), (3 - odd, np.sin(m * turn))):
                total[part] += wave[:, None] * between * wave
    return result


def seen_inside(bottom: np.ndarray, interface: np.ndarray, medium: Sequence[float]) -> np.ndarray:
    """BRDF of a bottom and a medium below an interface that reflects from below.

    Args:
        bottom, interface: parts (4, Q, Q).
        medium: albedo, sigma_t and g, which the grid resolves (`adding.resolved`).

    Returns:
        Values (4, Q, Q) [1/sr], at the images of the second direction, of all light except that
        reflected once by the bottom and not scattered by the medium.
    """
    albedo, sigma_t, g = medium
    own, one = weights(), np.eye(CELLS**2)
    through = np.exp(-sigma_t / directions()[:, 2].astype(np.float64))
    scatters, more = albedo * sigma_t > adding.LEAST_SCATTERING, []
    for k in range(4):
        up = bottom[k] * own
        if scatters:
            reflected, passed = (part[k] * own for part in medium_parts(albedo, sigma_t, g))
            once = np.diag(through) + passed
            up = once @ up @ np.linalg.solve(one - reflected @ up, once) + reflected
        else:
            up = through[:, None] * up * through
        every = np.linalg.solve(one - up @ (interface[k] * own), up / own)
        more.append(every - through[:, None] * bottom[k] * through)
    return np.tensordot(PARTS, np.stack(more), 1) / 4


class Table:
    """Values of a BRDF between pairs of cells, linear in the coordinates of `places`."""

    def __init__(self, values: np.ndarray):
        """values: (4, Q, Q, C), as of `seen_inside`."""
        n = CELLS
        whole = np.empty((n, n, 2 * n, 2 * n, values.shape[-1]), np.float32)
        for (x, y), image in zip(SIGNS, values.reshape(4, n, n, n, n, -1), strict=True):
            part = image[:, :, :: int(x), :: int(y)]
            whole[:, :, n * (x > 0) :, n * (y > 0) :][:, :, :n, :n] = part
        # Cells beyond the axes are those of the mirrored pair.
        whole = np.concatenate([whole[:1, :, ::-1], whole])
        whole = np.concatenate([whole[:, :1, :, ::-1], whole], axis=1)
        self._shape, self._rows = whole.shape[:4], whole.reshape(-1, whole.shape[-1])

    def at(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """Values float32 (M, C) of pairs float32 (M, 3)."""
        (a, b), (c, d) = places(wi), places(wo)
        c, d = np.copysign(np.float32(1), a) * c, np.copysign(np.float32(1), b) * d
        first, shares = np.zeros(len(wi), np.intp), []
        at = np.abs(a), np.abs(b), c + np.float32(1), d + np.float32(1)
        for place, offset, count in zip(at, (0.5, 0.5, -0.5, -0.5), self._shape, strict=True):
            scaled = np.clip(place * np.float32(CELLS) + np.float32(offset), 0, count - 1)
            index = np.minimum(scaled.astype(np.intp), count - 2)
            first = first * count + index
            shares.append((scaled - index).astype(np.float32)[:, None])
        steps = corner_steps(self._shape)
        values = [self._rows.take(first + step, axis=0) for step in steps]
        for share in reversed(shares):
            pairs = zip(values[::2], values[1::2], strict=True)
            values = [low + (high - low) * share for low, high in pairs]
        return values[0]
