"""The body of a small saloon of the fifties, in metres, as implicit surfaces.

x points forward, y to the left, z up; the ground is z = 0. Fields are those of the left half.
"""

import numpy as np

from gallery.implicit import Loft, common, ellipsoid, polygon, superellipsoid, tube, union

#: Where the axles are along x, and the height of the wheels' middle.
AXLES, WHEEL = (1.21, -1.20), 0.33

#: Height of the body's underside, and radius of the wheel arches.
FLOOR, ARCH = 0.27, 0.385

#: The middle of a front lamp, and where it looks.
LAMP, LAMP_AXIS = (1.79, 0.575, 0.665), np.array([0.93, 0.0, 0.367], np.float32)

#: Bonnet, flanks and tail; and what is above them.
HULL = Loft(
    span=(2.02, -2.0),
    middle=0.58,
    below=0.36,
    width=(
        *(-0.2, 0.26, 0.40, 0.47, 0.54, 0.62, 0.70),
        *(0.735, 0.745, 0.73, 0.69, 0.62, 0.51, 0.36, -0.2),
    ),
    height=(
        *(-0.131, 0.17, 0.262, 0.335, 0.38, 0.40, 0.40),
        *(0.39, 0.38, 0.38, 0.37, 0.34, 0.26, 0.16, -0.089),
    ),
)
CABIN = Loft(
    span=(1.02, -1.98),
    middle=0.76,
    below=0.30,
    width=(-0.2, 0.58, 0.655, 0.69, 0.70, 0.695, 0.675, 0.64, 0.58, 0.48, 0.32, -0.2),
    height=(-0.1, 0.36, 0.60, 0.715, 0.755, 0.755, 0.72, 0.65, 0.54, 0.39, 0.20, -0.1),
)

#: Windows of door and quarter, and the outline of the door, by -x and z.
DOOR = [(-0.62, 0.90), (0.34, 0.90), (0.28, 1.385), (-0.30, 1.345), (-0.60, 0.93)]
QUARTER = [(0.42, 0.90), (1.02, 0.90), (1.06, 1.05), (0.80, 1.325), (0.36, 1.38)]
LEAF = [(-0.70, 0.33), (0.405, 0.33), (0.36, 1.42), (-0.40, 1.42), (-0.70, 0.88)]

#: Windscreen and rear window, by y and z; the bonnet's outline by x and y.
SCREEN = [(-0.50, 0.985), (0.50, 0.985), (0.405, 1.36), (-0.405, 1.36)]
REAR = [(-0.36, 1.08), (0.36, 1.08), (0.33, 1.30), (-0.33, 1.30)]
LID = [
    *((0.80, -0.9), (2.5, -0.9), (2.5, 0.29)),
    *((1.85, 0.30), (1.05, 0.50), (0.86, 0.50), (0.80, 0.44)),
]


def body(p: np.ndarray) -> np.ndarray:
    """The painted body: panes are set in, and gaps surround doors and bonnet."""
    x, y, z = p.T
    bare = skin(p)
    outside = common(union(bare, fenders(p), 0.07), FLOOR - z, 0.03)
    wheels = np.minimum(*(np.hypot(x - axle, z - WHEEL) - ARCH for axle in AXLES))
    result = common(outside, -common(wheels, 0.42 - y, 0.05), 0.02)
    result = common(result, -common(windows(p), -(bare + 0.035), 0.01), 0.02)
    return common(result, -tube(gaps(p), outside, 0.0085), 0.012)


def skin(p: np.ndarray) -> np.ndarray:
    """Hull and cabin without fenders and openings."""
    return union(HULL(p), CABIN(p), 0.09)


def fenders(p: np.ndarray) -> np.ndarray:
    """The fenders, with the front lamp's housing."""
    front = superellipsoid(p, (1.20, 0.555, 0.36), (0.66, 0.265, 0.475))
    lamp = ellipsoid(p, (1.52, 0.57, 0.645), (0.46, 0.153, 0.155))
    lamp = common(lamp, (p - np.array(LAMP, np.float32)) @ LAMP_AXIS, 0.02)
    front = union(front, lamp, 0.16)
    trail = superellipsoid(p, (0.72, 0.55, 0.26), (0.45, 0.20, 0.28))
    rear = superellipsoid(p, (-1.20, 0.535, 0.37), (0.68, 0.275, 0.46))
    lead = superellipsoid(p, (-0.72, 0.55, 0.26), (0.42, 0.20, 0.26))
    return np.minimum(union(front, trail, 0.2), union(rear, lead, 0.2))


def windows(p: np.ndarray) -> np.ndarray:
    """The outlines of all windows, extruded across the car."""
    x, y, z = p.T
    sides = np.minimum(polygon(-x, z, DOOR, 0.05), polygon(-x, z, QUARTER, 0.12))
    return np.minimum.reduce(
        [
            common(sides, 0.3 - y, 0.02),
            common(polygon(y, z, SCREEN, 0.09), 0.25 - x, 0.02),
            common(polygon(y, z, REAR, 0.16), x + 0.6, 0.02),
        ]
    )


def gaps(p: np.ndarray) -> np.ndarray:
    """A field that is zero on the outlines of doors and bonnet."""
    x, y, z = p.T
    door = np.abs(polygon(-x, z, LEAF, 0.12)) + np.maximum(0.3 - y, 0)
    bonnet = np.abs(polygon(x, y, LID, 0.10)) + np.maximum(0.5 - z, 0)
    return np.minimum(door, bonnet)


def panes(p: np.ndarray) -> np.ndarray:
    """The panes, a little below the skin."""
    inside = skin(p) + 0.018
    return common(common(inside, windows(p) - 0.02, 0.005), -(inside + 0.05), 0.005)
