"""Noise-free pictures of a sphere under an environment map, for comparisons of BRDFs.

The sphere is seen by an orthographic camera, so that a pixel's wi depends only on its distance from
the middle. With an isotropic BRDF the picture is then a convolution in azimuth: the light that a
pixel receives from a cell of the environment's grid depends only on the difference of their
azimuths. This *transport* is integrated once per BRDF, at nodes that are the same for all BRDFs,
and gives its picture in every environment.

The nodes lie on a polar grid of half vectors, dense towards the normal: highlights may be far
narrower than a cell. Their values are distributed bilinearly to the cells around them.
"""

from functools import cache

import numpy as np
from benchmarks.measures import Brdf
from gallery import stage
from gallery.stage import Light

#: Cells of the grid: elevations from the camera's direction, and azimuths about it.
ELEVATIONS, AZIMUTHS = 96, 192
#: Points per axis of a cell; their mean is the cell's radiance.
FINE = 8
#: Number of rings of pixels: half the pictures' width and height.
RINGS = 64
#: Number of half vectors along both angles.
HALF_ANGLES, HALF_AZIMUTHS = 120, 192
#: Number of parts in which a BRDF is evaluated at all nodes, to bound the memory.
PARTS = 4
#: Mean luminance of a white Lambertian sphere in the studio.
WHITE = 0.5
#: The studio: zenith, horizon and ground, and softboxes.
SKY = (0.35, 0.36, 0.40), (0.25, 0.24, 0.23), (0.08, 0.07, 0.06)
LIGHTS = (
    Light(towards=(-1.0, -0.6, 0.9), size=(0.35, 0.35), radiance=(9.0, 9.0, 9.0)),
    Light(towards=(1.2, -0.3, 0.3), size=(0.10, 0.55), radiance=(7.0, 7 * 0.85, 7 * 0.65)),
    Light(towards=(0.2, 1.0, 0.6), size=(0.50, 0.12), radiance=(8 * 0.55, 8 * 0.75, 8.0)),
)


def studio(f: Brdf) -> np.ndarray:
    """The picture (2 RINGS, 2 RINGS, 3) of linear radiance in Urushi's studio."""
    return picture(transport(f), radiance())


def transport(f: Brdf) -> np.ndarray:
    """The light that every ring receives from every elevation.

    Args:
        f: a BRDF of one or three channels, isotropic, or symmetric about the xz plane with tangents
            (the x axis) that point away from the middle; its arguments are float32 unit vectors.

    Returns:
        complex64 (RINGS, ELEVATIONS, AZIMUTHS // 2 + 1, 3); the third axis holds Fourier
        coefficients over differences of azimuth.
    """
    wi, wo, cell, weight = nodes()
    # In parts, so that f needs little memory.
    parts = zip(*(np.array_split(w, PARTS) for w in (wi, wo)), strict=True)
    values = np.concatenate([np.asarray(f(*pairs)) for pairs in parts])
    shape = RINGS, ELEVATIONS, AZIMUTHS
    channels = []
    for value in np.broadcast_to(values, (len(values), 3)).T.astype(np.float64):
        shared = (value[:, None] * weight).ravel()
        received = np.bincount(cell.ravel(), shared, minlength=np.prod(shape)).reshape(shape)
        channels.append(np.fft.rfft(received, axis=2).astype(np.complex64))
    return np.stack(channels, axis=-1)


def picture(transported: np.ndarray, radiance: np.ndarray) -> np.ndarray:
    """The picture (2 RINGS, 2 RINGS, 3) of a sphere: a `transport` applied to an environment.

    radiance: (`ELEVATIONS`, `AZIMUTHS`, 3), means over cells. Row k lies between the angles
        pi k / ELEVATIONS and pi (k + 1) / ELEVATIONS to +z, where the camera is; column m is
        centred at the azimuth 2 pi m / AZIMUTHS from +x, the picture's right, to +y, its top.
    """
    spectrum = np.einsum("kmc,rkmc->rmc", np.fft.rfft(radiance, axis=1), transported.conj())
    polar = np.fft.irfft(spectrum, AZIMUTHS, axis=1)
    x, y = _pixels()
    turn = np.arctan2(y, x) / (2 * np.pi) * AZIMUTHS
    cell, share = _around(np.clip(np.hypot(x, y) - 0.5, 0, RINGS - 1), turn, RINGS)
    return (polar.reshape(-1, 3)[cell] * share[..., None]).sum(-2) * mask()[..., None]


def mask() -> np.ndarray:
    """The pixels of the sphere: bool (2 RINGS, 2 RINGS)."""
    return np.hypot(*_pixels()) <= RINGS - 0.5


@cache
def radiance() -> np.ndarray:
    """The studio, scaled so that a white Lambertian sphere has the mean luminance `WHITE`."""
    angle = np.pi * (np.arange(ELEVATIONS * FINE) + 0.5) / (ELEVATIONS * FINE)
    azimuth = 2 * np.pi * np.add.outer(np.arange(AZIMUTHS), (np.arange(FINE) + 0.5) / FINE - 0.5)
    x, y, z = np.moveaxis(_vectors(angle, azimuth.ravel() / AZIMUTHS), -1, 0)
    # In the stage's frame z is up, and the camera at negative y.
    fine = stage.radiance(np.stack([x, -z, y], axis=-1), *SKY, LIGHTS)
    weight = np.sin(angle).reshape(ELEVATIONS, FINE)
    weight /= FINE * weight.sum(axis=1, keepdims=True)
    fine = fine.reshape(ELEVATIONS, FINE, AZIMUTHS, FINE, 3)
    means = np.einsum("kimjc,ki->kmc", fine, weight)
    white = picture(transport(lambda wi, wo: np.full((len(wi), 1), 1 / np.pi)), means)
    return means * WHITE / (white[mask()].mean(0) @ [0.2126, 0.7152, 0.0722])


@cache
def nodes() -> tuple[np.ndarray, ...]:
    """The pairs at which a BRDF is integrated, for all rings: about a million nodes.

    Returns:
        wi, wo: float32 (N, 3), both above the horizon, in the frame of the surface.
        cell: (N, 4) flat indices into (RINGS, ELEVATIONS, AZIMUTHS): cells to which a node adds.
        weight: (N, 4) solid angle times cosine of wo times share, for each of these cells.
    """
    wi, wo, cell, weight = (
        np.concatenate(arrays) for arrays in zip(*map(_half_vectors, range(RINGS)), strict=True)
    )
    return wi.astype(np.float32), wo.astype(np.float32), cell, weight


def _half_vectors(ring: int) -> tuple[np.ndarray, ...]:
    """The nodes of a ring; the half angle grows with the square of the index."""
    edge = np.cos(0.5 * np.pi * (np.arange(HALF_ANGLES + 1) / HALF_ANGLES) ** 2)
    theta = 0.5 * np.pi * ((np.arange(HALF_ANGLES) + 0.5) / HALF_ANGLES) ** 2
    azimuth = 2 * np.pi * (np.arange(HALF_AZIMUTHS) + 0.5) / HALF_AZIMUTHS
    area = (edge[:-1] - edge[1:]) * 2 * np.pi / HALF_AZIMUTHS
    half, (wi, to_local) = _vectors(theta, azimuth), _view(ring)
    cosine = half @ wi
    wo = 2 * cosine[:, None] * half - wi
    # dwo = 4 (wi.h) dh (Walter et al. 2007)
    weight = 4 * cosine * wo[:, 2] * np.repeat(area, HALF_AZIMUTHS)
    kept = (cosine > 0) & (wo[:, 2] > 0)
    wo, weight = wo[kept], weight[kept]
    x, y, z = (wo @ to_local).T
    row = np.clip(np.arctan2(np.hypot(x, y), z) / np.pi * ELEVATIONS - 0.5, 0, ELEVATIONS - 1)
    cell, share = _around(row, np.arctan2(y, x) / (2 * np.pi) * AZIMUTHS, ELEVATIONS)
    wi = np.broadcast_to(wi, (len(wo), 3))
    return wi, wo, cell + ring * ELEVATIONS * AZIMUTHS, weight[:, None] * share


def _vectors(theta: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """Unit vectors (T A, 3) of angles to +z (T,) and azimuths (A,) [rad]."""
    theta, azimuth = (x.ravel() for x in np.meshgrid(theta, azimuth, indexing="ij"))
    sine = np.sin(theta)
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(theta)], axis=-1)


def _around(row: np.ndarray, column: np.ndarray, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """The four cells of a grid (rows, AZIMUTHS) around places (...), and shares: (..., 4) each.

    row: in [0, rows - 1]; column: any number, of period AZIMUTHS.
    """
    above, left = np.floor(row).astype(np.intp), np.floor(column).astype(np.intp)
    down, right = row - above, column - left
    cells, shares = [], []
    for i, vertical in ((above, 1 - down), (np.minimum(above + 1, rows - 1), down)):
        for j, horizontal in ((left, 1 - right), (left + 1, right)):
            cells.append(i * AZIMUTHS + j % AZIMUTHS)
            shares.append(vertical * horizontal)
    return np.stack(cells, axis=-1), np.stack(shares, axis=-1)


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
