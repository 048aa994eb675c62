"""The neck of a violin: heel, pegbox and scroll of maple; fingerboard, nut and pegs of ebony.

Lengths are millimetres in the frame of `violin_shape`.
"""

import numpy as np
import numpy.typing as npt

from gallery.grids import grid
from gallery.mesh import Mesh, Profile, lathe
from gallery.solids import curve, loft, merged, moved, section, turned
from gallery.violin_shape import LENGTH

#: Where the strings leave the nut.
NUT = LENGTH + 129.0
#: Radius of the fingerboard and of the bridge across the strings.
ROUND = 42.0
#: Pegs of the strings from g to e'': y, and the side of the head.
PEGS: list[tuple[float, int]] = [(499.0, -1), (525.0, -1), (536.0, 1), (510.0, 1)]
#: Centre (y, z) of the scroll, its outer radius at the start, and how it shrinks with the angle.
SCROLL, SCROLL_RADIUS, SHRINK, SCROLL_END = (569.5, -24.0), 23.0, 0.086, 5.6 * np.pi


def board_height(y: npt.ArrayLike) -> np.ndarray:
    """Height of the fingerboard's middle."""
    return 18.5 - 0.1255 * (np.asarray(y) - LENGTH)


def drop(x: npt.ArrayLike) -> np.ndarray:
    """How much lower the fingerboard and the bridge are at x than in the middle."""
    return ROUND - np.sqrt(ROUND**2 - np.square(x))


def board_width(y: npt.ArrayLike) -> np.ndarray:
    """Half of the fingerboard's width."""
    return np.interp(np.asarray(y, float), [214, NUT], [21.2, 12.0])


def maple_parts() -> list[Mesh]:
    """Neck with its heel, pegbox and scroll; v runs along them."""
    return [neck(), pegbox(), *scroll()]


def fingerboard() -> Mesh:
    """Round above and flat below."""
    return _board(np.array([213.5, 214.0, 215.0, 300, 400, NUT]), 0.0, [0.5, 0.2, 0.0, 0, 0, 0])


def nut() -> Mesh:
    """The block at the end of the fingerboard over which the strings run."""
    return _board(np.array([NUT + 0.05, NUT + 1.0, NUT + 3.5, NUT + 4.5]), 0.9, [0, 0, 0.2, 1.0])


def _board(y: np.ndarray, raised: float, inset: list[float]) -> Mesh:
    sections = []
    for at, less in zip(y, inset, strict=True):
        w = board_width(at) - less
        x = np.linspace(-w, w, 33)
        top = np.stack([x, board_height(at) + raised - less - drop(x)], axis=1)
        side = board_height(at) - drop(w) - 4.6
        sections.append(section([*top, (w, side), (-w, side)], at, 4))
    return loft(np.array(sections))


def neck() -> Mesh:
    """From the heel at the body to the nut, under the fingerboard."""
    below = np.array(
        [
            (LENGTH - 4, -35.2),
            (LENGTH + 1.5, -35.0),
            (LENGTH + 4.5, -31),
            (LENGTH + 8, -24.5),
            (LENGTH + 12, -18),
            (LENGTH + 17, -12.2),
            (LENGTH + 23, -8.4),
            (LENGTH + 31, -6.6),
            (LENGTH + 60, -8.6),
            (LENGTH + 100, -12.6),
            (NUT + 5, -16.6),
        ]
    )
    y = np.concatenate([np.linspace(below[0, 0], LENGTH + 30, 48), np.linspace(390, NUT + 5, 24)])
    bottom = curve(below, y)
    sections = []
    for at, low in zip(y, bottom, strict=True):
        top = board_height(at) - drop(board_width(at)) - 4.6
        w = board_width(at) - 0.05
        heel = np.clip((LENGTH + 28 - at) / 22, 0, 1)
        part = np.sin(np.linspace(0, np.pi / 2, 17))  # from the fingerboard down
        power = 2.1 + 5 * heel
        half = w * (1 - 0.34 * heel * part) * (1 - part**power) ** 0.5
        right = np.stack([half, top + (low - top) * part], axis=1)
        left = right[::-1] * [-1, 1]
        sections.append(section([*right[:-1], *left], at, 1, start=left[-1]))
    return loft(np.array(sections))


def pegbox() -> Mesh:
    """The open box for the pegs, which ends inside the scroll."""
    back = np.array([(NUT + 0.5, -16.2), (500, -18.8), (515, -25), (530, -32.5), (548, -41.8)])
    back = np.vstack([back, [(558, -45.6), (SCROLL[0], SCROLL[1] - SCROLL_RADIUS)]])
    front = np.array([(NUT + 0.5, -4.2), (500, -6.6), (525, -14.6), (545, -23.0)])
    front = np.vstack([front, [(556, -27.0), (SCROLL[0], -30)]])
    sections = []
    for at in np.linspace(NUT + 4, SCROLL[0], 64):
        low, high = curve(back, at), curve(front, at)
        w = np.interp(at, [NUT, 548, SCROLL[0]], [12.4, 9.6, 9.2])
        inner = w - np.interp(at, [NUT, 548], [4.8, 3.9])
        open_ = np.clip(min(at - NUT - 5, 551 - at) / 6, 0, 1)
        floor = high + (low + 4.5 - high) * open_ * (2 - open_)
        right = [(inner, floor), (inner, high), (w - 0.6, high), (w, high - 0.6)]
        # The back's corners are round where the neck goes over into the box.
        turn = np.linspace(0, np.pi / 2, 7)
        wide, deep = (np.interp(at, [NUT + 4, NUT + 22], ends) for ends in ([10, 2], [11, 2]))
        right += [
            (w - wide * (1 - c), low + deep * (1 - s))
            for c, s in zip(np.cos(turn), np.sin(turn), strict=True)
        ]
        left = [(-x, z) for x, z in right[::-1]]
        sections.append(section([*left, *right], at, 5))
    return loft(np.array(sections))


def scroll() -> list[Mesh]:
    """A band that winds inwards and becomes wider with every turn, and its eyes."""
    angles = np.linspace(0, SCROLL_END, 260)
    half = np.interp(
        angles / np.pi,
        [0, 0.35, 0.8, 1.2, 1.6, 2.0, 2.5, 3.2, 4.2, 5.6],
        [9.2, 7.6, 6.0, 6.4, 8.0, 10.2, 12.6, 15.6, 18.6, 20.6],
    )
    sections = []
    for angle, w in zip(angles, half, strict=True):
        outer = SCROLL_RADIUS * np.exp(-SHRINK * angle)
        inner = 0.9 * SCROLL_RADIUS * np.exp(-SHRINK * min(angle + 2 * np.pi, SCROLL_END))
        bevel = 0.07 * outer
        right = [(w, inner), (w, outer - bevel), (w - bevel, outer)]
        grooves = [(0.5 * w, outer - 0.45 * bevel), (0.1 * w, outer)]
        right += grooves
        left = [(-x, r) for x, r in right[::-1]]
        flat = section([*left, *right], 0.0, 4)
        x, r = flat[:, 0], flat[:, 2]
        sections.append(
            np.stack(
                [x, SCROLL[0] + r * np.sin(angle), SCROLL[1] - r * np.cos(angle)],
                axis=-1,
            )
        )
    r = SCROLL_RADIUS * np.exp(-SHRINK * SCROLL_END) + 0.4
    eye = lathe(Profile(np.array(turned([(r, 0), (r, 41.6), (0.8 * r, 42.6)]))), 48, 48)
    return [
        loft(np.array(sections)),
        moved(eye, [(0, 1, 0), (0, 0, 1), (1, 0, 0)], (-21.3, *SCROLL)),
    ]


def peg(y: float, side: int) -> Mesh:
    """A tuning peg through the pegbox; side: that of the head, 1 or -1."""
    shank = [(3.1, 0), (3.6, 24), (3.6, 28.5), (4.9, 29.2), (4.9, 31.2), (3.1, 32), (3.0, 36)]
    parts = [lathe(Profile(np.array(turned(shank))), 32, 96)]
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 49), np.linspace(0, np.pi, 33))
    wide = np.sin(v) ** 0.8
    thumb = np.stack([10.6 * wide * np.cos(u), 3.1 * wide * np.sin(u), -8.2 * np.cos(v)], axis=-1)
    thumb[..., 1] *= 0.62 + 0.38 * (thumb[..., 2] / 8.2) ** 2
    parts.append(moved(grid(thumb, closed=True), np.eye(3), (0, 0, 41.5)))
    parts.append(moved(lathe(Profile(np.array(KNOB)), 24, 24), np.eye(3), (0, 0, 49.0)))
    angle = 0.9 + 2.1 * y  # every peg is turned by another angle
    across = np.array([0, np.cos(angle), np.sin(angle)])
    along = np.array([float(side), 0, 0])
    return moved(merged(parts), [np.cross(along, across), across, along], peg_place(y, side))


#: The small ball at the end of a peg.
KNOB = [(0, -1), (1.5, -1), (2.0, 0.4), (1.5, 1.6), (0, 1.8)]


def peg_place(y: float, side: int) -> tuple[float, float, float]:
    """Where a peg begins, inside the far wall."""
    depth = np.interp(y, [NUT, 500, 525, 545], [-9.5, -12.0, -21.0, -31.0])
    return (-side * 12.5, y, float(depth))
