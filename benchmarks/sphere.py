"""Noise-free pictures of a sphere under an environment map, for comparisons of BRDFs.

The sphere is seen by an orthographic camera, so that a pixel's wi depends only on its distance from
the middle. With an isotropic BRDF the picture is then a convolution in azimuth: the light that a
pixel receives from a cell of the environment's grid depends only on the difference of their
azimuths. This *transport* is integrated once per BRDF, at nodes that are the same for all BRDFs,
and gives its picture in every environment.

Where the half angle is large, the nodes are the cells' middles. Around the mirror direction, where
highlights may be far narrower than a cell, they lie on a polar grid of half vectors, dense towards
the normal, and their values are distributed bilinearly to the cells around them. Between the two
regions the weights are blended.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from gallery import stage
from gallery.stage import Light

#: Cells of the grid: elevations from the camera's direction, and azimuths about it.
ELEVATIONS, AZIMUTHS = 96, 192

#: Points per axis of a cell; their mean is the cell's radiance.
FINE = 8

#: Number of rings of pixels: half the pictures' width and height.
RINGS = 64

#: Number of half vectors around the mirror direction along both angles, and the range of half
#: angles where the two kinds of nodes are blended [rad].
HALF_ANGLES, HALF_AZIMUTHS = 40, 96
BLEND = np.radians(4.0), np.radians(10.0)

#: Number of parts in which a BRDF is evaluated at all nodes, to bound the memory.
PARTS = 4

#: Mean radiance of a white Lambertian sphere in `exposed` environments.
WHITE = 0.5

#: f(wi, wo) -> (N, 3) or (N, 1) [1/sr].
Brdf = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Environment:
    """Radiance from all directions, on a grid about the axis that the camera looks along.

    Attributes:
        name: for tables.
        radiance: float64 (`ELEVATIONS`, `AZIMUTHS`, 3), the means over cells. Row k lies between
            the angles pi k / ELEVATIONS and pi (k + 1) / ELEVATIONS to +z, where the camera is;
            column m is centred at the azimuth 2 pi m / AZIMUTHS from +x, the picture's right, to
            +y, its top.
    """

    name: str
    radiance: np.ndarray


@dataclass(frozen=True)
class Nodes:
    """The direction pairs at which a BRDF is integrated, for all rings.

    Attributes:
        wi, wo: float32 (N, 3), both above the horizon, in the frame of the surface.
        cell: (N, 4) flat indices into (RINGS, ELEVATIONS, AZIMUTHS): cells to which a node adds.
        weight: (N, 4) solid angle times cosine of wo times share, for each of these cells.
    """

    wi: np.ndarray
    wo: np.ndarray
    cell: np.ndarray
    weight: np.ndarray


def studio(f: Brdf) -> np.ndarray:
    """The picture (2 RINGS, 2 RINGS, 3) of linear radiance in Urushi's studio."""
    (found,) = render(f, [exposed(own_environments()[0])])
    return found


def render(f: Brdf, environments: Iterable[Environment]) -> list[np.ndarray]:
    """Pictures (2 RINGS, 2 RINGS, 3) of linear radiance, one per environment; black background."""
    transported = transport(f)
    return [picture(transported, environment) for environment in environments]


def transport(f: Brdf) -> np.ndarray:
    """The light that every ring receives from every elevation.

    Args:
        f: a BRDF of one or three channels, isotropic, or symmetric about the xz plane with tangents
            (the x axis) that point away from the middle; its arguments are float32 unit vectors.

    Returns:
        complex64 (RINGS, ELEVATIONS, AZIMUTHS // 2 + 1, 3); the third axis holds Fourier
        coefficients over differences of azimuth.
    """
    rule = nodes()
    # In parts, so that f needs little memory.
    parts = zip(*(np.array_split(w, PARTS) for w in (rule.wi, rule.wo)), strict=True)
    values = np.concatenate([np.asarray(f(wi, wo)) for wi, wo in parts])
    size = RINGS * ELEVATIONS * AZIMUTHS
    shape = RINGS, ELEVATIONS, AZIMUTHS
    channels = []
    for value in np.broadcast_to(values, (len(values), 3)).T.astype(np.float64):
        shared = (value[:, None] * rule.weight).ravel()
        received = np.bincount(rule.cell.ravel(), shared, minlength=size).reshape(shape)
        channels.append(np.fft.rfft(received, axis=2).astype(np.complex64))
    return np.stack(channels, axis=-1)


def picture(transported: np.ndarray, environment: Environment) -> np.ndarray:
    """The picture (2 RINGS, 2 RINGS, 3) of a sphere: a `transport` applied to an environment."""
    light = np.fft.rfft(environment.radiance, axis=1)
    spectrum = np.einsum("kmc,rkmc->rmc", light, transported.conj())
    return _cartesian(np.fft.irfft(spectrum, AZIMUTHS, axis=1))


def mask() -> np.ndarray:
    """The pixels of the sphere: bool (2 RINGS, 2 RINGS)."""
    return np.hypot(*_pixels()) <= RINGS - 0.5


def exposed(environment: Environment) -> Environment:
    """The environment, scaled so that a white Lambertian sphere has the mean luminance `WHITE`."""
    luminance = picture(_white(), environment)[mask()].mean(0) @ [0.2126, 0.7152, 0.0722]
    return replace(environment, radiance=environment.radiance * (WHITE / luminance))


@cache
def _white() -> np.ndarray:
    return transport(lambda wi, wo: np.full((len(wi), 1), 1 / np.pi))


@cache
def nodes() -> Nodes:
    """The nodes of all rings, about 800,000."""
    parts = [part for ring in range(RINGS) for part in (_cells(ring), _half_vectors(ring))]
    wi, wo, cell, weight = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    return Nodes(wi.astype(np.float32), wo.astype(np.float32), cell, weight)


def _cells(ring: int) -> tuple[np.ndarray, ...]:
    """Nodes in the cells' middles; their weight is zero where only half vectors are used."""
    edges = np.cos(np.pi * np.arange(ELEVATIONS + 1) / ELEVATIONS)
    theta = np.pi * (np.arange(ELEVATIONS) + 0.5) / ELEVATIONS
    azimuth = 2 * np.pi * np.arange(AZIMUTHS) / AZIMUTHS
    theta, azimuth = (x.ravel() for x in np.meshgrid(theta, azimuth, indexing="ij"))
    sine = np.sin(theta)
    world = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(theta)], axis=1)
    wi, to_local = _view(ring)
    wo = world @ to_local.T
    solid_angle = np.repeat(edges[:-1] - edges[1:], AZIMUTHS) * (2 * np.pi / AZIMUTHS)
    half = wi + wo
    weight = (
        solid_angle
        * wo[:, 2]
        * (1 - _half_vector_weight(np.arctan2(np.hypot(*half.T[:2]), half[:, 2])))
    )
    kept = np.flatnonzero((wo[:, 2] > 0) & (weight > 0))
    ring_cell = kept + ring * ELEVATIONS * AZIMUTHS
    # Each node belongs to one cell: the other three shares are zero.
    cell = np.repeat(ring_cell[:, None], 4, axis=1)
    shares = weight[kept, None] * np.array([1.0, 0.0, 0.0, 0.0])
    return np.broadcast_to(wi, (len(kept), 3)), wo[kept], cell, shares


def _half_vectors(ring: int) -> tuple[np.ndarray, ...]:
    """Nodes around the mirror direction; the half angle grows with the square of the index."""
    edge = BLEND[1] * (np.arange(HALF_ANGLES + 1) / HALF_ANGLES) ** 2
    theta = BLEND[1] * ((np.arange(HALF_ANGLES) + 0.5) / HALF_ANGLES) ** 2
    azimuth = 2 * np.pi * (np.arange(HALF_AZIMUTHS) + 0.5) / HALF_AZIMUTHS
    area = np.repeat(np.cos(edge[:-1]) - np.cos(edge[1:]), HALF_AZIMUTHS)
    area *= 2 * np.pi / HALF_AZIMUTHS
    theta, azimuth = (x.ravel() for x in np.meshgrid(theta, azimuth, indexing="ij"))
    sine = np.sin(theta)
    half = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(theta)], axis=1)
    wi, to_local = _view(ring)
    cosine = half @ wi
    wo = 2 * cosine[:, None] * half - wi
    weight = (
        4 * cosine * area * wo[:, 2] * _half_vector_weight(theta)
    )  # dwo = 4 (wi.h) dh (Walter et al. 2007)
    kept = (cosine > 0) & (wo[:, 2] > 0) & (weight > 0)
    wo, weight = wo[kept], weight[kept]
    cell, share = _around(wo @ to_local)
    wi = np.broadcast_to(wi, (len(wo), 3))
    return wi, wo, cell + ring * ELEVATIONS * AZIMUTHS, weight[:, None] * share


def _half_vector_weight(half_angle: np.ndarray) -> np.ndarray:
    """Weight of the half vectors at a half angle; it falls smoothly from 1 to 0 over `BLEND`."""
    t = np.clip((BLEND[1] - half_angle) / (BLEND[1] - BLEND[0]), 0, 1)
    return t * t * (3 - 2 * t)


def _around(world: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The four cells around directions (N, 3) and their shares, (N, 4) each."""
    elevation = np.arctan2(np.hypot(world[:, 0], world[:, 1]), world[:, 2])
    v = np.clip(elevation / np.pi * ELEVATIONS - 0.5, 0, ELEVATIONS - 1)
    u = np.arctan2(world[:, 1], world[:, 0]) / (2 * np.pi) * AZIMUTHS
    row, column = np.floor(v).astype(np.intp), np.floor(u).astype(np.intp)
    down, right = v - row, u - column
    below = np.minimum(row + 1, ELEVATIONS - 1)
    left, beside = column % AZIMUTHS, (column + 1) % AZIMUTHS
    cells = [row * AZIMUTHS + left, row * AZIMUTHS + beside]
    cells += [below * AZIMUTHS + left, below * AZIMUTHS + beside]
    shares = [(1 - down) * (1 - right), (1 - down) * right, down * (1 - right), down * right]
    return np.stack(cells, axis=1), np.stack(shares, axis=1)


def _view(ring: int) -> tuple[np.ndarray, np.ndarray]:
    """wi of a ring's pixel at azimuth 0, and the rows of the frame of its surface."""
    sine = (ring + 0.5) / RINGS
    cosine = np.sqrt(1 - sine * sine)
    frame = np.array([[cosine, 0, -sine], [0, 1, 0], [sine, 0, cosine]])
    return frame[:, 2], frame


def _pixels() -> tuple[np.ndarray, np.ndarray]:
    """Coordinates of all pixels from the middle, in pixels: x to the right and y up."""
    along = np.arange(2 * RINGS) + 0.5 - RINGS
    x, y = np.meshgrid(along, -along)
    return x, y


def _cartesian(polar: np.ndarray) -> np.ndarray:
    """A picture (2 RINGS, 2 RINGS, 3) from values by ring and azimuth (RINGS, AZIMUTHS, 3)."""
    x, y = _pixels()
    radius = np.clip(np.hypot(x, y) - 0.5, 0, RINGS - 1)
    turn = np.arctan2(y, x) / (2 * np.pi) * AZIMUTHS
    return periodic_bilinear(polar, radius, turn) * mask()[..., None]


def cell_points() -> np.ndarray:
    """Unit vectors (ELEVATIONS, FINE, AZIMUTHS, FINE, 3) whose values are averaged over cells."""
    fine = (np.arange(FINE) + 0.5) / FINE
    theta = np.pi * np.add.outer(np.arange(ELEVATIONS), fine) / ELEVATIONS
    phi = 2 * np.pi * np.add.outer(np.arange(AZIMUTHS), fine - 0.5) / AZIMUTHS
    theta, phi = theta[:, :, None, None], phi[None, None]
    shape = ELEVATIONS, FINE, AZIMUTHS, FINE
    x, y = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi)
    return np.stack([x, y, np.broadcast_to(np.cos(theta), shape)], axis=-1)


def own_environments() -> list[Environment]:
    """Two environments by code: a studio with softboxes, and a low sun in a clear sky."""
    white, warm, blue = (1.0, 1.0, 1.0), (1.0, 0.85, 0.65), (0.55, 0.75, 1.0)
    studio = (
        Light(towards=(-1.0, -0.6, 0.9), size=(0.35, 0.35), radiance=tuple(9 * c for c in white)),
        Light(towards=(1.2, -0.3, 0.3), size=(0.10, 0.55), radiance=tuple(7 * c for c in warm)),
        Light(towards=(0.2, 1.0, 0.6), size=(0.50, 0.12), radiance=tuple(8 * c for c in blue)),
    )
    sun = Light(towards=(0.9, -0.8, 0.75), size=(0.02, 0.02), radiance=(1800.0, 1500.0, 1100.0))
    return [
        _of_stage("studio", (0.35, 0.36, 0.40), (0.25, 0.24, 0.23), (0.08, 0.07, 0.06), studio),
        _of_stage("sun", (0.35, 0.55, 1.0), (1.0, 0.95, 0.85), (0.20, 0.17, 0.13), (sun,)),
    ]


def _of_stage(
    name: str,
    zenith: stage.Vector,
    horizon: stage.Vector,
    ground: stage.Vector,
    lights: tuple[Light, ...],
) -> Environment:
    """A sky of `stage.radiance`, in whose frame z is up and the camera at negative y."""
    x, y, z = np.moveaxis(cell_points(), -1, 0)
    points = np.stack([x, -z, y], axis=-1)
    return Environment(name, cell_means(stage.radiance(points, zenith, horizon, ground, lights)))


def cell_means(fine: np.ndarray) -> np.ndarray:
    """Means over cells of values at `cell_points`, by solid angle."""
    sine = np.sin(np.pi * (np.arange(ELEVATIONS * FINE) + 0.5) / (ELEVATIONS * FINE))
    weight = sine.reshape(ELEVATIONS, FINE)
    weight = weight / weight.sum(axis=1, keepdims=True)
    return np.einsum("kimjc,ki->kmc", fine, weight) / FINE


def periodic_bilinear(image: np.ndarray, row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Bilinear values (..., C) of an image (H, W, C) whose columns are periodic.

    row (...): in [0, H - 1], pixel centres at whole numbers; column (...): any number, of period W,
    pixel centres at whole numbers.
    """
    rows, columns = image.shape[:2]
    above, left = np.floor(row).astype(np.intp), np.floor(column).astype(np.intp)
    down, right = (row - above)[..., None], (column - left)[..., None]
    below = np.minimum(above + 1, rows - 1)
    left, beside = left % columns, (left + 1) % columns
    upper = image[above, left] * (1 - right) + image[above, beside] * right
    lower = image[below, left] * (1 - right) + image[below, beside] * right
    return upper * (1 - down) + lower * down
