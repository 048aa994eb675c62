"""What is mounted on the car's body: chrome, bumpers, wheels and lamps; see `car_shape`."""

import numpy as np

from gallery.car_shape import AXLES, LAMP, LAMP_AXIS, WHEEL, skin, windows
from gallery.grids import grid
from gallery.implicit import common, ellipsoid, segment, superellipsoid, tube, union
from gallery.mesh import Mesh, merged, moved

#: The middle of the tyres along y, and the radii of the white ring on their outer side.
TRACK, WHITE_WALL = 0.665, (0.235, 0.290)


def trim(p: np.ndarray) -> np.ndarray:
    """Chrome on the body, left half: frames of the windows, strips, handles, mirrors, wipers."""
    x, y, z = p.T
    surface = skin(p)
    frames = tube(windows(p) + 0.002, surface + 0.004, 0.0135)
    flank = tube(z - (0.795 - 0.03 * x * x), surface, 0.011)
    flank = common(flank, np.maximum(x - 0.74, -1.12 - x), 0.01)
    crest = common(tube(y, surface - 0.004, 0.014), np.maximum(0.93 - x, 0.62 - z), 0.01)
    handle = superellipsoid(p, (-0.24, 0.745, 0.735), (0.085, 0.016, 0.016))
    root = ellipsoid(p, (-0.29, 0.72, 0.735), (0.02, 0.03, 0.016))
    mirror = ellipsoid(p, (0.50, 0.86, 0.955), (0.030, 0.075, 0.052))
    stalk = segment(np.stack([y, z], axis=-1), (0.68, 0.87), (0.82, 0.94))
    stalk = tube(stalk, x - 0.50, 0.010)
    wiper = segment(np.stack([y, z], axis=-1), (0.06, 1.035), (0.38, 1.075))
    wiper = np.maximum(tube(wiper, surface - 0.004, 0.008), 0.25 - x)
    return np.minimum.reduce(
        [frames, flank, crest, union(handle, root, 0.02), union(mirror, stalk, 0.02), wiper]
    )


def guards(p: np.ndarray) -> np.ndarray:
    """The guards on the bumpers, left half."""
    return np.minimum(
        *(superellipsoid(p, (x, 0.34, 0.42), (0.04, 0.032, 0.125)) for x in (2.045, -2.045))
    )


def boards(p: np.ndarray) -> np.ndarray:
    """The running boards."""
    box = superellipsoid(p, (0.0, 0.62, 0.285), (0.90, 0.135, 0.035))
    return common(box, np.maximum(p[:, 0] - 0.80, -0.80 - p[:, 0]), 0.02)


def sweep(path: np.ndarray, across: np.ndarray, size: tuple[float, float]) -> Mesh:
    """A bar of an oval section along a path (N, 3), with round ends.

    across: (N, 3) unit vectors, along which the section has the half width size[0]; size[1]: half
    height, along z.
    """
    length = np.linspace(0, 1, len(path))
    ends = np.minimum(length, 1 - length) / 0.03
    scale = np.sqrt(1 - np.maximum(1 - ends, 0) ** 2)[:, None, None]
    angle = np.linspace(0, 2 * np.pi, 49)
    wide = np.sign(np.cos(angle)) * np.abs(np.cos(angle)) ** 0.8
    tall = np.sign(np.sin(angle)) * np.abs(np.sin(angle)) ** 0.8
    section = wide[:, None] * size[0] * across[:, None] + tall[:, None] * size[1] * [0.0, 0.0, 1.0]
    return grid(path[:, None] + scale * section, closed=True)


def bumper(end: float) -> Mesh:
    """The front bumper, end = 1, or the rear one, end = -1."""
    angle = np.linspace(-1.25, 1.25, 121)
    x = 1.62 + 0.43 * np.cos(angle) ** (2 / 3)
    y = 0.80 * np.sign(angle) * np.abs(np.sin(angle)) ** (2 / 3)
    fine = np.cumsum(np.append(0, np.hypot(np.diff(x), np.diff(y))))
    even = np.linspace(0, fine[-1], 161)
    path = np.stack([np.interp(even, fine, x), np.interp(even, fine, y), 0 * even + 0.40], axis=-1)
    ahead = np.gradient(path, axis=0)
    across = np.cross(ahead, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    bar = sweep(path[::-1], across[::-1], (0.024, 0.062))
    return moved(bar, np.diag([end, 1, 1]))


def on_wheels(part: Mesh) -> Mesh:
    """Four of a turned part, its outside towards +z, at the wheels."""
    return merged(
        [
            moved(part, [(side, 0, 0), (0, 0, 1), (0, side, 0)], (x, side * TRACK, WHEEL))
            for x in AXLES
            for side in (1, -1)
        ]
    )


def at_lamps(part: Mesh) -> Mesh:
    """Two of a turned part, its outside towards +z, at the lamps."""
    ahead = LAMP_AXIS / np.linalg.norm(LAMP_AXIS)
    left = np.array([0.0, 1.0, 0.0])
    axes = [np.cross(left, ahead), left, ahead]
    return merged([moved(part, axes, np.multiply(LAMP, (1, side, 1))) for side in (1, -1)])


#: Outlines (radius, height) of turned parts, their outside up.
TYRE = [
    (0.0, -0.07), (0.10, -0.07), (0.195, -0.07), (0.205, -0.085), (0.25, -0.098), (0.295, -0.095),
    (0.324, -0.077), (0.332, -0.06), (0.333, -0.02), (0.333, 0.02), (0.332, 0.06), (0.324, 0.077),
    (0.295, 0.095), (0.25, 0.098), (0.210, 0.088), (0.195, 0.06), (0.10, 0.03), (0.0, 0.03),
]  # fmt: skip
RIM = [
    (0.0, 0.0), (0.10, 0.0), (0.190, 0.0), (0.212, 0.05), (0.214, 0.090), (0.209, 0.099),
    (0.201, 0.097), (0.196, 0.085), (0.185, 0.066), (0.165, 0.058), (0.140, 0.060), (0.128, 0.068),
    (0.124, 0.083), (0.116, 0.096), (0.09, 0.108), (0.055, 0.114), (0.045, 0.116), (0.040, 0.122),
    (0.025, 0.127), (0.0, 0.128),
]  # fmt: skip
LAMP_RING = [
    (0.0, -0.03), (0.07, -0.03), (0.127, -0.03), (0.137, -0.015), (0.138, 0.0), (0.134, 0.012),
    (0.124, 0.017), (0.114, 0.012), (0.110, 0.0), (0.08, 0.0), (0.0, 0.0),
]  # fmt: skip
LAMP_PANE = [
    (0.0, -0.01), (0.05, -0.01), (0.105, -0.01), (0.113, 0.0), (0.105, 0.014), (0.08, 0.028),
    (0.05, 0.037), (0.0, 0.041),
]  # fmt: skip
