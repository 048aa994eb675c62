"""The scene "teapot": Newell's teapot in many-coloured lacquer, polished flat, over rough silver.

The pattern is that of tsugaru-nuri: layers of many colours over an uneven ground are polished
down, so that they show as contour lines. The shapes are cubic Bézier outlines and tubes of mirrored
bicubic patches (Bézier 1968).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np
import numpy.typing as npt

from gallery import noise, stage
from gallery.grids import grid
from gallery.mesh import Mesh, lathe, surface
from gallery.options import Options
from gallery.stage import Folder, Light


@dataclass(frozen=True)
class Outline:
    """Half of a turned shape's outline: joined cubic segments, as a `mesh.Outline`.

    Attributes:
        control: (3 S + 1, 2) control points (radius, height) of S segments, from the bottom up.
    """

    control: np.ndarray

    def __call__(self, v: npt.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Points and unit tangents, each of v's shape + (2,); segments have equal shares of v."""
        segments = (len(self.control) - 1) // 3
        at = np.asarray(v, float) * segments
        first = np.clip(at.astype(int), 0, segments - 1)
        t = (at - first)[..., None]
        a, b, c, d = (self.control[3 * first + k] for k in range(4))
        points = _curve(a, b, c, d, t)
        tangents = (1 - t) ** 2 * (b - a) + 2 * (1 - t) * t * (c - b) + t**2 * (d - c)
        return points, tangents / np.linalg.norm(tangents, axis=-1, keepdims=True)


@dataclass(frozen=True)
class Tube:
    """A closed tube that is its own mirror image in y, given by its half with y <= 0.

    Attributes:
        control: (3 S + 1, 4, 3): across the tube four control points, from y = 0 round to y = 0;
            along it S joined segments.
    """

    control: np.ndarray

    def __call__(self, u: npt.ArrayLike, v: npt.ArrayLike) -> np.ndarray:
        """Points (..., 3) at u around and v along the tube, both in [0, 1]."""
        u, v = np.broadcast_arrays(np.asarray(u, float), np.asarray(v, float))
        segments = (len(self.control) - 1) // 3
        at = v * segments
        first = np.clip(at.astype(int), 0, segments - 1)
        t = (at - first)[..., None]
        s = np.where(u < 0.5, 2 * u, 2 - 2 * u)[..., None]
        a, b, c, d = (self.control[3 * first + k] for k in range(4))
        across = np.moveaxis(_curve(a, b, c, d, t[..., None]), -2, 0)
        points = _curve(across[0], across[1], across[2], across[3], s)
        return points * np.where(u[..., None] < 0.5, 1, [1, -1, 1])


def _curve(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray, t: np.ndarray) -> np.ndarray:
    """A cubic Bézier curve at t."""
    s = 1 - t
    return s**3 * a + 3 * s**2 * t * b + 3 * s * t**2 * c + t**3 * d


#: Texels around the body; half as many along it, and fewer on the other parts.
TEXELS = 1024


def teapot(folder: Folder, options: Options) -> dict[str, Any]:
    """Describe the scene for `mi.load_dict`; its files are written into `folder`."""
    transform = mi.ScalarTransform4d()
    turned = transform.rotate([0, 0, 1], -28)
    parts: dict[str, Any] = {
        "surround": stage.surround(
            folder,
            zenith=(0.42, 0.48, 0.60),
            horizon=(0.30, 0.285, 0.27),
            ground=(0.13, 0.12, 0.11),
            lights=[
                Light((-7, -5.5, 7.1), (0.38, 0.38), (7.6, 7.2, 6.5)),
                Light((7, 3.5, 3.6), (0.20, 0.50), (6.0, 6.7, 8.0)),
            ],
        ),
        "table": stage.table(8.0, 0.26, 0.23, 0.20),
    }
    for name, (mesh, place) in pieces(options).items():
        albedo, depth = lacquer(place)
        parts[name] = folder.mesh(name, mesh) | {
            "to_world": turned,
            "bsdf": options.coated(
                stage.conductor("Ag", 0.3),
                alpha=0.03,
                int_ior=1.5,
                albedo=folder.texture(f"{name}-albedo", albedo),
                sigma_t=folder.texture(f"{name}-depth", depth),
            ),
        }
    view = stage.camera(options, (0, -13.5, 6.2), (0.05, 0, 1.38), 29)
    return stage.scene(view, parts)


def pieces(options: Options) -> dict[str, tuple[Mesh, np.ndarray]]:
    """The meshes of the teapot, with the positions of their textures' texels (H, W, 3)."""
    texels = options.texels(TEXELS)
    body, lid = Outline(np.array(BODY)), Outline(np.array(LID))
    handle, spout = (Tube(np.add(control, [0, 0, 0.15])) for control in (HANDLE, SPOUT))

    def turned(outline: Outline) -> Callable:
        return lambda u, v: surface(outline, u, v)[0]

    return {
        "body": (lathe(body, 192, 160), _texels(turned(body), texels, texels // 2)),
        "lid": (lathe(lid, 128, 96), _texels(turned(lid), texels // 2, texels // 4)),
        "handle": (_tube(handle), _texels(handle, texels // 4, texels // 2)),
        "spout": (_tube(spout), _texels(spout, texels // 4, texels // 2)),
    }


def _tube(tube: Tube) -> Mesh:
    u, v = np.meshgrid(np.linspace(0, 1, 65), np.linspace(0, 1, 129))
    return grid(tube(u, v), closed=True)


def _texels(place: Callable, width: int, height: int) -> np.ndarray:
    """Positions (height, width, 3) of the centres of a texture's texels."""
    u, v = (np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height
    return place(u[None, :], v[:, None])


def lacquer(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Albedo and optical depth of the medium at points (..., 3): (..., 3) each."""
    drift = noise.fractal(points * 0.7, 2, seed=11)[..., None] * 0.5
    level = noise.fractal(points * 1.25 + drift, 3, seed=3, gain=0.45)
    layer = np.clip((level + 0.75) / 1.5, 0, 1) * (len(LAYERS) - 1)
    stack = np.array(LAYERS)
    index = np.minimum(layer.astype(int), len(stack) - 2)
    edge = stage.smoothstep(0.42, 0.58, layer - index)[..., None]
    mixed = stack[index] + (stack[index + 1] - stack[index]) * edge
    return mixed[..., :3], np.exp(mixed[..., 3:])


_DARK, _BARE = np.log([3.2, 3.0, 2.8]), np.log([0.10, 0.16, 0.30])
_RED, _TEAL = np.log([1.2, 2.6, 3.0]), np.log([2.6, 1.5, 1.4])

#: Layers from the ground up: albedo, and the logarithm of the optical depth.
LAYERS = [
    (*colour, *depth)
    for colour, depth in [
        ((0.03, 0.10, 0.12), _DARK),
        ((0.05, 0.34, 0.36), _TEAL),
        ((0.03, 0.10, 0.12), _DARK),
        ((0.90, 0.80, 0.55), _BARE),
        ((0.80, 0.20, 0.08), _RED),
        ((0.03, 0.08, 0.10), _DARK),
        ((0.80, 0.20, 0.08), _RED),
        ((0.90, 0.80, 0.55), _BARE),
        ((0.05, 0.34, 0.36), _TEAL),
        ((0.03, 0.10, 0.12), _DARK),
        ((0.80, 0.62, 0.20), np.log([0.6, 1.0, 2.2])),
    ]
]

# Martin Newell's control points (University of Utah, 1975), in the form with a bottom.
BODY = [
    (0.0, 0.0), (1.425, 0.0), (1.5, 0.075), (1.5, 0.15), (1.5, 0.225), (2.0, 0.45), (2.0, 0.9),
    (2.0, 1.35), (1.75, 1.875), (1.5, 2.4), (1.4375, 2.53125), (1.3375, 2.53125), (1.4, 2.4),
]  # fmt: skip
LID = [
    (1.3, 2.4), (1.3, 2.55), (0.4, 2.55), (0.2, 2.7), (0.0, 2.85), (0.8, 3.15), (0.0, 3.15),
]  # fmt: skip
HANDLE = [
    [(-1.6, 0, 1.875), (-1.6, -0.3, 1.875), (-1.5, -0.3, 2.1), (-1.5, 0, 2.1)],
    [(-2.3, 0, 1.875), (-2.3, -0.3, 1.875), (-2.5, -0.3, 2.1), (-2.5, 0, 2.1)],
    [(-2.7, 0, 1.875), (-2.7, -0.3, 1.875), (-3, -0.3, 2.1), (-3, 0, 2.1)],
    [(-2.7, 0, 1.65), (-2.7, -0.3, 1.65), (-3, -0.3, 1.65), (-3, 0, 1.65)],
    [(-2.7, 0, 1.425), (-2.7, -0.3, 1.425), (-3, -0.3, 1.2), (-3, 0, 1.2)],
    [(-2.5, 0, 1.125), (-2.5, -0.3, 1.125), (-2.65, -0.3, 0.9375), (-2.65, 0, 0.9375)],
    [(-2, 0, 0.9), (-2, -0.3, 0.9), (-1.9, -0.3, 0.6), (-1.9, 0, 0.6)],
]
SPOUT = [
    [(1.7, 0, 1.425), (1.7, -0.66, 1.425), (1.7, -0.66, 0.6), (1.7, 0, 0.6)],
    [(2.6, 0, 1.425), (2.6, -0.66, 1.425), (3.1, -0.66, 0.825), (3.1, 0, 0.825)],
    [(2.3, 0, 2.1), (2.3, -0.25, 2.1), (2.4, -0.25, 2.025), (2.4, 0, 2.025)],
    [(2.7, 0, 2.4), (2.7, -0.25, 2.4), (3.3, -0.25, 2.4), (3.3, 0, 2.4)],
    [(2.8, 0, 2.475), (2.8, -0.25, 2.475), (3.525, -0.25, 2.49375), (3.525, 0, 2.49375)],
    [(2.9, 0, 2.475), (2.9, -0.15, 2.475), (3.45, -0.15, 2.5125), (3.45, 0, 2.5125)],
    [(2.8, 0, 2.4), (2.8, -0.15, 2.4), (3.2, -0.15, 2.4), (3.2, 0, 2.4)],
]
