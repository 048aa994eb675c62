"""What is fitted to a violin's body: bridge, tailpiece, fine tuners, saddle, end pin, strings.

Lengths are millimetres in the frame of `violin_shape`.
"""

from itertools import pairwise

import numpy as np

from gallery.grids import grid
from gallery.mesh import Mesh, Profile, lathe
from gallery.solids import (
    cut,
    loft,
    merged,
    moved,
    section,
    signed_distance,
    tube,
    turned,
    wall,
)
from gallery.violin_neck import (
    NUT,
    PEGS,
    board_height,
    drop,
    fingerboard,
    nut,
    peg,
    peg_place,
)
from gallery.violin_shape import LENGTH, Arching

#: Where the strings cross the bridge, and its height above the belly.
BRIDGE, BRIDGE_HEIGHT = LENGTH - 195.0, 33.5
#: Strings from g to e'': x at the nut, at the bridge, at the tailpiece; radius.
STRINGS: list[tuple[float, float, float, float]] = [
    (-8.2, -17.0, -13.2, 0.50),
    (-2.75, -5.7, -4.4, 0.46),
    (2.75, 5.7, 4.4, 0.42),
    (8.2, 17.0, 13.2, 0.36),
]


def ebony_parts() -> list[Mesh]:
    """Fingerboard, nut, pegs, tailpiece with its gut, saddle and end pin."""
    gut = [(5.0, 14, 8.0), (5.0, 6, 8.3), (5.0, -1, 8.0), (4.5, -3.6, 5.5), (3.0, -4.2, -12)]
    mirrored = [(-x, y, z) for x, y, z in gut]
    return [
        fingerboard(),
        nut(),
        *(peg(*place) for place in PEGS),
        tailpiece(),
        saddle(),
        end_pin(),
        tube(gut, 0.9),
        tube(mirrored, 0.9),
    ]


def metal_parts(arching: Arching) -> list[Mesh]:
    """Strings and fine tuners."""
    return [*(string(number, arching) for number in range(4)), *(tuner(s[2]) for s in STRINGS)]


def tailpiece() -> Mesh:
    """A long shield, wide at the strings."""
    y = np.array([1.5, 1.8, 3, 8, 20, 40, 60, 80, 96, 104, 108.5, 111, 112.2, 112.6])
    w = np.array([8.6, 9.6, 10.4, 10.9, 11.2, 12.6, 14.9, 17.8, 20.4, 21.0, 20.2, 18.4, 16.6, 15.8])
    thick = np.array([1.5, 2.6, 3.6, 4.4, 4.8, 5, 5, 5, 5, 4.8, 4.4, 3.4, 2.2, 1.2])
    sections = []
    for at, half, high in zip(y, w, thick, strict=True):
        x = half * np.sin(np.linspace(-np.pi / 2, np.pi / 2, 33))
        arch = tailpiece_height(at) - 5 + high - 0.011 * x**2 - 0.9 * (x / half) ** 6
        low = tailpiece_height(at) - 5 - 0.011 * half**2
        sections.append(section([*np.stack([x, arch], axis=1), (half, low), (-half, low)], at, 2))
    return loft(np.array(sections))


def tailpiece_height(y: float) -> float:
    """Height of the tailpiece's middle."""
    return 11.5 + 0.222 * (y - 2)


def saddle() -> Mesh:
    """The block at the edge of the body that carries the tailpiece's gut."""
    sections = []
    for at, less in [(-0.8, 1.2), (-0.2, 0.2), (0.8, 0), (5.5, 0), (6.6, 0.4), (7, 2)]:
        x = np.linspace(-17 + less, 17 - less, 25)
        top = 7.6 - less - 2.4 * np.abs(x / 17) ** 3
        sections.append(section([*np.stack([x, top], axis=1), (x[-1], 1.5), (x[0], 1.5)], at, 3))
    return loft(np.array(sections))


def end_pin() -> Mesh:
    """The button at the lower end."""
    shape = [(6.6, 0), (6.8, 3), (5.0, 5), (4.6, 8), (6.6, 11), (7.0, 14), (5.6, 17), (2, 18)]
    pin = lathe(Profile(np.array(turned(shape))), 40, 64)
    return moved(pin, [(1, 0, 0), (0, 0, 1), (0, -1, 0)], (0, 3.0, -14.0))


def bridge(arching: Arching) -> Mesh:
    """The bridge, cut from a flat piece of maple that becomes thin towards the strings."""
    x, z = np.meshgrid(np.linspace(-22, 22, 111), np.linspace(-0.5, BRIDGE_HEIGHT + 0.5, 86))
    flat = grid(np.stack([x, z, 0 * x], axis=-1))
    points = np.stack([np.abs(flat.positions[:, 0]), flat.positions[:, 1]], axis=-1)
    shape = -signed_distance(points, np.array(BRIDGE_SIDE))
    for hole in BRIDGE_HOLES:
        shape = np.minimum(shape, signed_distance(points, np.array(hole)))
    face, line = cut(flat, shape)
    x, z = face.positions[:, 0], face.positions[:, 1]
    half = np.interp(z, [0, BRIDGE_HEIGHT], [2.2, 0.75])
    face.positions[:, 2] = half
    back = moved(face, np.diag([1, 1, -1]))
    sides = wall(face, line, np.stack([0 * half, 0 * half, -2 * half], axis=-1))
    mesh = merged([face, back, sides])
    x, z = mesh.positions[:, 0], mesh.positions[:, 1]
    belly = arching(np.stack([x, np.full_like(x, BRIDGE)], axis=-1).astype(float))
    part = np.clip(z / 12, 0, 1)
    foot = belly + (arching.height - belly) * part
    uv = np.stack([0.5 + x / 44, (z + 0.5) / 35], axis=-1).astype(np.float32)
    placed = moved(mesh, [(1, 0, 0), (0, 0, 1), (0, -1, 0)], (0, BRIDGE, 0))
    placed.positions[:, 2] += foot.astype(np.float32)
    return Mesh(placed.positions, placed.normals, uv, placed.faces)


#: The right half of the bridge, its heart, and the holes above the feet.
BRIDGE_SIDE = [
    (-1, 11.0),
    (0, 11.0),
    (4.2, 10.4),
    (7.4, 8.4),
    (9.2, 5.6),
    (9.3, 3.6),
    (8.2, 1.4),
    (8.0, -0.3),
    (20.9, -0.3),
    (20.9, 1.3),
    (18.6, 2.9),
    (16.4, 5.0),
    (15.6, 7.6),
    (16.2, 9.6),
    (17.8, 11.4),
    (17.2, 12.6),
    (15.0, 12.2),
    (12.6, 12.4),
    (11.0, 13.8),
    (10.4, 16.0),
    (11.0, 18.2),
    (12.8, 19.4),
    (15.0, 18.9),
    (16.6, 17.4),
    (17.8, 17.6),
    (19.0, 20.0),
    (19.4, 23.0),
    (18.9, 26.0),
    (18.2, 28.2),
    (18.2, 29.6),
    *[(x, BRIDGE_HEIGHT - float(drop(x))) for x in (17.0, 14, 11, 8, 5, 2, 0)],
    (-1, BRIDGE_HEIGHT),
]
BRIDGE_HOLES = [
    [
        (-1, 15.6),
        (0, 15.8),
        (1.0, 17.0),
        (3.0, 18.4),
        (4.4, 20.4),
        (4.0, 22.6),
        (2.2, 23.4),
        (0.8, 22.4),
        (0, 21.0),
        (-1, 21.0),
    ],
    [(5.2, 14.0), (6.8, 14.2), (7.2, 15.8), (6.0, 16.8), (4.8, 15.6)],
]


def string(number: int, arching: Arching) -> Mesh:
    """A string from the tailpiece over bridge and nut to its peg."""
    at_nut, at_bridge, at_tail, radius = STRINGS[number]
    y, side = PEGS[number]
    x, _, depth = peg_place(y, side)
    top = arching.height + BRIDGE_HEIGHT - float(drop(at_bridge)) + 0.3
    over = float(board_height(NUT)) + 0.9 - float(drop(at_nut)) + 0.2
    path = [
        (at_tail, 103.0, tailpiece_height(103) - 0.011 * at_tail**2 + 1.6),
        (at_bridge, BRIDGE, top),
        (at_nut, NUT + 0.5, over),
        (at_nut * 0.98, NUT + 4.6, over - 0.5),
        (0.45 * at_nut + 0.12 * x, y, depth + 3.6),
    ]
    fine = [np.linspace(a, b, 12)[:-1] for a, b in pairwise(np.array(path))]
    return tube(np.concatenate([*fine, path[-1:]]), radius, 10)


def tuner(x: float) -> Mesh:
    """A fine tuner on the tailpiece: a screw with a knurled head, and its lever."""
    profile = [(1.2, 0), (1.2, 3.5), (3.3, 3.9), (3.5, 6.5), (3.1, 7.2), (1.0, 7.4)]
    screw = lathe(Profile(np.array(turned(profile))), 36, 48)
    height = tailpiece_height(86) - 0.011 * x**2
    tilt = np.array([(1, 0, 0), (0, 0.976, 0.217), (0, -0.217, 0.976)])
    lever = [
        section([(-a, 0.2), (-a, b), (a, b), (a, 0.2)], y, 4)
        for y, a, b in [(-2, 1.2, 1.8), (0, 1.9, 2.6), (10, 1.7, 2.6), (17, 1.5, 2.2), (18, 1, 1)]
    ]
    return moved(merged([screw, loft(np.array(lever))]), tilt, (x, 86.0, height - 0.4))
