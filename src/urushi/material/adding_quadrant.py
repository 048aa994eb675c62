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
from urushi.core.microfacet import pair
from urushi.core.quadrature import directional_albedos
from urushi.core.table import linear_at
from urushi.material import adding
from urushi.material.crossing import facet_points, mirrored_from
from urushi.material.stretched_values import f_of
from urushi.nets import lobe as lobes
from urushi.parallel import run_all_cores

#: Cells along a side of the square, and for each cell with an albedo of its own.
CELLS, COARSE = 24, 3

#: Signs of x and y of the images of a direction, and the factors of a part (row) at each image.
SIGNS = np.array([(1, 1), (-1, 1), (1, -1), (-1, -1)], np.float32)
PARTS = np.array([(1, 1, 1, 1), (1, -1, 1, -1), (1, 1, -1, -1), (1, -1, -1, 1)])

#: Of the images: half a turn about the normal, to which a mirror reflects.
TURNED = 3

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


@functools.cache
def _triangle() -> tuple[np.ndarray, np.ndarray]:
    """The pairs i <= j of Q cells, and the place (Q, Q) of each pair of cells among them."""
    upper = np.triu_indices(CELLS**2)
    place = np.empty((CELLS**2, CELLS**2), np.intp)
    place[upper] = place[upper[::-1]] = np.arange(len(upper[0]))
    return np.stack(upper), place


def parts(f: adding.Brdf, albedo: np.ndarray) -> np.ndarray:
    """The parts float32 (C, 4, Q, Q) of a BRDF of albedos (Q, C), as `adding.Grid.brdf_modes`.

    f is evaluated at half of the pairs. The other half follow by reciprocity: mirroring both
    directions of a pair leaves f as it is, so that either may have the signs of an image.
    """
    w, own = directions(), weights()
    count, ((first, second), place) = len(w), _triangle()
    wi = w.take(first, axis=0)
    wo = w.take(second, axis=0)
    images = [f(wi, wo * np.append(sign, np.float32(1))) for sign in SIGNS]
    images[TURNED][first == second] = 0  # lobes are narrow there
    diagonal, result = np.arange(count), []
    for channel, known in enumerate(albedo.T):
        columns = np.stack([image[:, channel] for image in images])
        even = columns.sum(axis=0).take(place)
        factors, missing = adding.albedo_factors(even, own, known)
        scaled = columns * (factors.take(first) * factors.take(second)).astype(np.float32)
        every = (PARTS.astype(np.float32) @ scaled).take(place, axis=1)
        every[:, diagonal, diagonal] += PARTS[:, TURNED, None] * (missing / own)
        result.append(every)
    return np.stack(result)


def bottom_parts(f: adding.Brdf) -> np.ndarray:
    """The parts (C, 4, Q, Q) of a BRDF. Albedos above 1 count as 1."""
    w, side = directions(), CELLS // COARSE
    some = w.reshape(side, COARSE, side, COARSE, 3)[:, COARSE // 2, :, COARSE // 2].reshape(-1, 3)
    albedo = directional_albedos(f, some, anisotropic=True, azimuths=AZIMUTHS)
    albedo = albedo.reshape(side, side, -1).repeat(COARSE, axis=0).repeat(COARSE, axis=1)
    return parts(f, np.minimum(albedo, 1).reshape(len(w), -1))


@functools.lru_cache(maxsize=8)
def interface_parts(alpha: float | Widths, eta: float) -> np.ndarray:
    """The parts (4, Q, Q) of the reflection of an interface from below; eta: below over above."""
    if eta == 1:
        return np.zeros((4, CELLS**2, CELLS**2), np.float32)
    outside = tuple(directions()[:, k, None] for k in range(3))
    albedo = mirrored_from(outside, alpha, 1 / eta, facet_points(256))[1].mean(axis=1)
    widths = Widths(*(np.asarray([x], np.float32) for x in pair(alpha)))
    lobe = lobes.of_coat(widths, np.asarray([1 / eta], np.float32))
    return parts(functools.partial(f_of, lobe), albedo[:, None])[0]


@functools.lru_cache(maxsize=8)
def medium_parts(albedo: float, sigma_t: float, g: float) -> np.ndarray:
    """Reflection and transmission float32 (2, 4, Q, Q) of the light that a medium scatters."""
    own, w = adding.grid(), directions().astype(np.float64)
    turn, shares = np.arctan2(w[:, 1], w[:, 0]), own.shares(np.arccos(w[:, 2]))
    result = np.zeros((2, 4, len(w), len(w)), np.float32)
    for modes, total in zip(adding.medium(albedo, sigma_t, g, own), result, strict=True):
        orders = np.arange(len(modes))
        scales = np.where((orders == 0) | (orders == orders[-1]), 4, 8) / (2 * np.pi)
        # cos m (phi_i - phi_o) is a sum of two products, and the sum over m one of matrices.
        for part, (wave, odd) in enumerate(((np.cos, 0), (np.cos, 1), (np.sin, 1), (np.sin, 0))):
            chosen = orders[odd::2]
            chosen = chosen[modes[chosen].any(axis=(1, 2))]
            waves = wave(chosen[:, None, None] * turn[:, None]) * shares
            left = waves @ (modes[chosen] * scales[chosen, None, None])
            sides = (x.astype(np.float32).swapaxes(0, 1) for x in (left, waves))
            rows, columns = (x.reshape(len(w), -1) for x in sides)
            total[part] = rows @ columns.T
    return result


def seen_inside(bottom: np.ndarray, interface: np.ndarray, medium: Sequence[float]) -> np.ndarray:
    """BRDF of a bottom and a medium below an interface that reflects from below.

    Args:
        bottom, interface: parts (4, Q, Q).
        medium: albedo, sigma_t and g, which the grid resolves (`adding.resolved`).

    Returns:
        Values float32 (4, Q, Q) [1/sr], at the images of the second direction, of all light except
        that reflected once by the bottom and not scattered by the medium.
    """
    albedo, sigma_t, g = medium
    own = weights().astype(np.float32)
    through = np.exp(-np.float32(sigma_t) / directions()[:, 2])
    scatters = albedo * sigma_t > adding.LEAST_SCATTERING
    scattered = medium_parts(albedo, sigma_t, g) if scatters else np.zeros((2, 4, 1, 1))
    more = np.empty_like(bottom)

    def solve(k: int) -> None:
        direct = through[:, None] * bottom[k] * through
        up = direct * own
        if scattered[:, k].any():  # isotropic scattering is even
            up, _ = adding.covered(bottom[k] * own, through, [x[k] * own for x in scattered])
        more[k] = adding.enclosed(up, interface[k], own) - direct

    run_all_cores(solve, range(4))
    return np.tensordot(np.float32(PARTS / 4), more, 1)


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
        self._values = np.concatenate([whole[:, :1, :, ::-1], whole], axis=1)

    def at(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """Values float32 (M, C) of pairs float32 (M, 3)."""
        (a, b), (c, d) = places(wi), places(wo)
        c, d = np.copysign(np.float32(1), a) * c, np.copysign(np.float32(1), b) * d
        half, scale = np.float32(0.5 / CELLS), np.float32(CELLS / (2 * CELLS - 1))
        near, far = (np.abs(x) + half for x in (a, b)), ((1 + x - half) * scale for x in (c, d))
        return linear_at(self._values, *near, *far)
