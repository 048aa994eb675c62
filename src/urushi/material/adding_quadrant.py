"""Light transport inside a coat by adding, for BRDFs that are symmetric about the xz and yz plane.

The equations are those of `urushi.material.adding`, and so is its grid of elevations, with azimuths
between those of the grid in the quadrant x, y > 0. Light is a sum of four parts: even in x and y,
odd in x, odd in y, odd in both. A symmetric BRDF does not mix them. It is therefore one matrix per
part, where an isotropic one is a matrix per Fourier mode.
"""

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from urushi.checks import Widths
from urushi.core.microfacet import of_widths
from urushi.core.namespace import Namespace, components
from urushi.core.table import linear_at
from urushi.material import adding
from urushi.material.albedo_rule import COSINES, albedo_rule
from urushi.material.crossing import inner_albedo
from urushi.nets import lobe as lobes

#: Azimuths of the quadrant.
ACROSS = 8

#: Sizes of a `table`: of wi in a quadrant, of wo in all of them.
TABLE = adding.ELEVATIONS, ACROSS + 2, adding.ELEVATIONS, 4 * ACROSS + 2

#: Signs of x and y of the images of a direction, and the factors of a part (row) at each image.
SIGNS = np.array([(1, 1), (-1, 1), (1, -1), (-1, -1)], np.float32)
PARTS = np.array([(1, 1, 1, 1), (1, -1, 1, -1), (1, 1, -1, -1), (1, -1, -1, 1)])

#: Of the images: half a turn about the normal, to which a mirror reflects.
TURNED = 3


@functools.cache
def directions() -> np.ndarray:
    """The directions float32 (Q, 3) of the quadrant, azimuths in the fastest axis."""
    phi = (np.arange(ACROSS) + 0.5) * (0.5 * np.pi / ACROSS)
    theta = adding.grid().angles[:, None]
    x, y, z = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi
    return np.stack([x, y, z], axis=-1, dtype=np.float32).reshape(-1, 3)


def coordinates(wi: Any, wo: Any, xp: Namespace) -> tuple[Any, ...]:
    """Coordinates in [0, 1] of pairs in a `table`."""
    # Both directions are mirrored so that wi is in the quadrant.
    x, y = (xp.where(a < 0, -b, b) for a, b in ((wi.x, wo.x), (wi.y, wo.y)))
    near = xp.arctan2(xp.absolute(wi.y), xp.absolute(wi.x)) * (2 / np.pi)
    far = xp.arctan2(y, x) * (2 / np.pi) + 2
    first, second = (
        (quarters * ACROSS + 0.5) / (size - 1)
        for quarters, size in ((near, TABLE[1]), (far, TABLE[3]))
    )
    return _elevation(wi.z, xp), first, _elevation(wo.z, xp), second


def _elevation(z: Any, xp: Namespace) -> Any:
    """The coordinate in [0, 1] of cosines among the angles of the grid.

    Those are roots of a Legendre polynomial, here within 0.002 of their distance (Tricomi 1950).
    """
    turn = xp.minimum(xp.maximum(1 - xp.arccos(xp.minimum(z, 1)) * (4 / np.pi), -1), 1)
    place = xp.arccos(turn) * ((adding.ELEVATIONS + 0.5) / np.pi) - 0.75
    return place * (1 / (adding.ELEVATIONS - 1))


@functools.cache
def weights() -> np.ndarray:
    """Weights (Q,) that integrate over the cosine times the solid angle in a quadrant."""
    return np.repeat(adding.grid().weights, ACROSS) * (0.5 * np.pi / ACROSS)


def parts(f: adding.Brdf, albedo: np.ndarray) -> np.ndarray:
    """The parts float32 (C, 4, Q, Q) of a BRDF of albedos (Q, C), as `adding.Grid.brdf_modes`."""
    w, own = directions(), weights()
    diagonal = np.arange(len(w))
    wi, wo = (x.reshape(-1, 3) for x in np.broadcast_arrays(w[:, None], w))
    images = np.stack([f(wi, wo * np.append(sign, np.float32(1))) for sign in SIGNS])
    images = np.moveaxis(images.reshape(4, len(w), len(w), -1), -1, 0)
    images[:, TURNED, diagonal, diagonal] = 0  # lobes are narrow there
    result = []
    for seen, known in zip(images, albedo.T, strict=True):
        factors, missing = adding.albedo_factors(seen.sum(axis=0), own, known)
        scaled = seen * np.outer(factors, factors).astype(np.float32)
        every = np.tensordot(PARTS.astype(np.float32), scaled, 1)
        every[:, diagonal, diagonal] += PARTS[:, TURNED, None] * (missing / own)
        result.append(every)
    return np.stack(result)


def bottom_parts(f: adding.Brdf) -> np.ndarray:
    """The parts (C, 4, Q, Q) of a BRDF; albedos above its `adding.ceilings` count as these."""
    rule, angles, (x, y, z) = albedo_rule(2), np.arccos(COSINES[2]), directions().T
    known = rule.albedo(f(rule.wi, rule.wo).T).T
    known = known.reshape(-1, len(angles), known.shape[1])
    places = np.interp(np.arccos(z), angles, np.linspace(0, 1, len(angles)))
    albedo = linear_at(known, np.arctan2(y, x) * (2 / np.pi), places)
    return parts(f, np.minimum(albedo, adding.ceilings(f)))


@functools.lru_cache(maxsize=8)
def interface_parts(alpha: Widths, eta: float) -> np.ndarray:
    """The parts (4, Q, Q) of the reflection of an interface from below; eta: below over above."""
    if eta == 1:
        return np.zeros((4, *2 * weights().shape), np.float32)
    albedo = inner_albedo(components(directions()[:, None]), alpha, eta)
    lobe = lobes.of_coat(of_widths(np.float32, alpha), np.float32(1 / eta))
    return parts(lambda *pairs: lobes.f(lobe, *pairs)[:, None], albedo[:, None])[0]


@functools.lru_cache(maxsize=8)
def medium_parts(albedo: float, sigma_t: float, g: float) -> np.ndarray:
    """Light that a medium scatters: float32 (3, 4, Q, Q) of what it reflects, passes, and reflects
    after one event."""
    own = adding.grid()
    once = own.modes(adding.reflected_once_on_grid([(albedo, sigma_t, g)], own))
    modes = np.stack([*adding.medium(albedo, sigma_t, g), once])
    phi, orders = np.arctan2(*directions()[:ACROSS, 1::-1].T), np.arange(modes.shape[1])
    scales = np.where((orders == 0) | (orders == orders[-1]), 4, 8) / (2 * np.pi)
    result = []
    for wave, odd in ((np.cos, 0), (np.cos, 1), (np.sin, 1), (np.sin, 0)):
        # cos m (phi_i - phi_o) is a sum of two products.
        waves = wave(orders[odd::2, None] * phi)
        around = scales[odd::2, None, None] * waves[:, :, None] * waves[:, None]
        part = np.einsum("kmab,mij->kaibj", modes[:, odd::2], around, optimize=True)
        result.append(part.reshape(len(modes), *2 * weights().shape))
    return np.stack(result, axis=1, dtype=np.float32)


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
    direct = through[:, None] * bottom * through
    if albedo * sigma_t > adding.LEAST_SCATTERING:
        *scattered, once = medium_parts(albedo, sigma_t, g)
        up, _ = adding.covered(bottom * own, through, [x * own for x in scattered])
    else:
        up, once = direct * own, np.float32(0)
    more = adding.enclosed(up, interface, own) - direct - once
    return np.tensordot(np.float32(PARTS / 4), more, 1)


def table(values: np.ndarray) -> np.ndarray:
    """Values of a BRDF float32 at `coordinates`, from values (4, Q, Q) as of `seen_inside`."""
    count, n = adding.ELEVATIONS, ACROSS
    first, second, third, fourth = values.reshape(4, count, n, count, n)
    # Azimuths of wo ascend from -pi to pi.
    whole = np.concatenate([fourth, third[..., ::-1], first, second[..., ::-1]], axis=-1)
    # Azimuths of wi beyond the quadrant are those of the pair mirrored at an axis.
    before, after = whole[:, :1, :, ::-1], np.roll(whole[:, -1:, :, ::-1], 2 * n, axis=-1)
    whole = np.concatenate([before, whole, after], axis=1)
    return np.concatenate([whole[..., -1:], whole, whole[..., :1]], axis=-1)
