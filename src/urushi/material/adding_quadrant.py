"""Light transport inside a coat by adding, for BRDFs that are symmetric about the xz and yz plane.

The equations are those of `urushi.material.adding`. Directions are the cells of a map of the
quadrant x, y > 0 to a square (Shirley and Chiu 1997), all of the same solid angle. Light is a sum
of four parts: even in x and y, odd in x, odd in y, odd in both. A symmetric BRDF does not mix them.
It is therefore one matrix per part, where an isotropic one is a matrix per Fourier mode.
"""

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from urushi.checks import Widths
from urushi.core.microfacet import pair
from urushi.core.namespace import Namespace, components
from urushi.core.quadrature import directional_albedos
from urushi.material import adding
from urushi.material.crossing import inner_albedo
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


def coordinates(wi: Any, wo: Any, xp: Namespace) -> tuple[Any, ...]:
    """Coordinates in [0, 1] of pairs in a `table`: of wi in a quadrant, of wo in all of them."""
    near, far = _places(wi, xp), _places(wo, xp)
    half, scale = 0.5 / CELLS, CELLS / (2 * CELLS - 1)
    same = (xp.where(a * b < 0, -1, 1) for a, b in ((wi.x, wo.x), (wi.y, wo.y)))
    whole = (scale * (1 - half + sign * x) for sign, x in zip(same, far, strict=True))
    return (*(x + half for x in near), *whole)


def _places(w: Any, xp: Namespace) -> tuple[Any, Any]:
    """Coordinates in [0, 1] of directions in the square of their quadrant."""
    radius = xp.sqrt(xp.maximum(1 - w.z, 0))
    x, y = xp.absolute(w.x), xp.absolute(w.y)
    other = radius * xp.arctan2(xp.minimum(x, y), xp.maximum(x, y)) * (4 / np.pi)
    return xp.where(x > y, radius, other), xp.where(x > y, other, radius)


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
    albedo = inner_albedo(components(directions()[:, None]), alpha, eta)
    lobe = lobes.of_coat(Widths(*map(np.float32, pair(alpha))), np.float32(1 / eta))
    return parts(lambda *pairs: lobes.f(lobe, *pairs)[:, None], albedo[:, None])[0]


@functools.lru_cache(maxsize=8)
def medium_parts(albedo: float, sigma_t: float, g: float) -> np.ndarray:
    """Light that a medium scatters: float32 (3, 4, Q, Q) of what it reflects, passes, and reflects
    after one event."""
    own = adding.grid()
    once = own.modes(adding.reflected_once_on_grid([(albedo, sigma_t, g)], own))
    return _parts_of_modes([*adding.medium(albedo, sigma_t, g), once])


def _parts_of_modes(several: Sequence[np.ndarray]) -> np.ndarray:
    """The parts float32 (K, 4, Q, Q) of modes (H, N, N) on the grid of `adding`."""
    own, w = adding.grid(), directions().astype(np.float64)
    turn, shares = np.arctan2(w[:, 1], w[:, 0]), own.shares(np.arccos(w[:, 2]))
    result = np.zeros((len(several), 4, len(w), len(w)), np.float32)
    for modes, total in zip(several, result, strict=True):
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
        that reflected once, by the bottom or by the medium.
    """
    albedo, sigma_t, g = medium
    own = weights().astype(np.float32)
    through = np.exp(-np.float32(sigma_t) / directions()[:, 2])
    scatters = albedo * sigma_t > adding.LEAST_SCATTERING
    scattered = medium_parts(albedo, sigma_t, g) if scatters else np.zeros((3, 4, 1, 1))
    more = np.empty_like(bottom)

    def solve(k: int) -> None:
        direct = through[:, None] * bottom[k] * through
        up = direct * own
        if scattered[:2, k].any():  # isotropic scattering is even
            up, _ = adding.covered(bottom[k] * own, through, [x[k] * own for x in scattered[:2]])
        more[k] = adding.enclosed(up, interface[k], own) - direct - scattered[2, k]

    run_all_cores(solve, range(4))
    return np.tensordot(np.float32(PARTS / 4), more, 1)


def table(values: np.ndarray) -> np.ndarray:
    """Values of a BRDF float32 at `coordinates`, from values (4, Q, Q) as of `seen_inside`."""
    n = CELLS
    whole = np.empty((n, n, 2 * n, 2 * n), np.float32)
    for (x, y), image in zip(SIGNS, values.reshape(4, n, n, n, n), strict=True):
        part = image[:, :, :: int(x), :: int(y)]
        whole[:, :, n * (x > 0) :, n * (y > 0) :][:, :, :n, :n] = part
    # Cells beyond the axes are those of the mirrored pair.
    whole = np.concatenate([whole[:1, :, ::-1], whole])
    return np.concatenate([whole[:, :1, :, ::-1], whole], axis=1)
