"""The scene "car": a small saloon of the fifties in a paint of interference flakes.

All materials are OpenPBR. The flakes are dark metal under a thin film, whose thickness differs from
flake to flake and so does their colour; a clear coat covers them. The panes are dark and opaque.
"""

from functools import cache
from typing import Any

import numpy as np

from gallery import car_fittings, car_shape, stage
from gallery.isosurface import Field, mesh, projected
from gallery.mesh import Mesh, Profile, lathe, merged
from gallery.options import Options
from gallery.stage import Folder, Light, rgb

#: Texels of the paint along a side of its pattern, which covers `TILE` [m] and repeats; and the
#: number of flakes along it.
TEXELS, TILE, FLAKES = 256, 0.6, 90

#: Mean thickness of the flakes' film [micrometres], and the deviation of flakes from it.
FILM, DEVIATION = 0.191, 0.05

#: Boxes around the parts, of which the left half is given, and the edges of their cells [m].
BODY = (-2.2, 0, 0.2), (2.2, 0.9, 1.6)
FINE, FINEST = 0.016, 0.010


def car(folder: Folder, options: Options) -> dict[str, Any]:
    """Describe the scene for `mi.load_dict`; its files are written into `folder`."""
    materials = {
        "body": _paint(folder, options),
        "panes": options.openpbr(
            base_color=rgb(0.004, 0.006, 0.007),
            specular_roughness=0.35,
            coat_weight=1.0,
            coat_roughness=0.1,
            coat_ior=1.55,
        ),
        "chrome": options.openpbr(
            base_metalness=1.0, base_color=rgb(0.62, 0.63, 0.65), specular_roughness=0.2
        ),
        "tyres": _rubber(folder, options),
        "boards": options.openpbr(base_color=rgb(0.02, 0.02, 0.02), specular_roughness=0.5),
        "lamps": options.openpbr(
            base_metalness=1.0,
            base_color=rgb(0.85, 0.86, 0.84),
            specular_roughness=0.4,
            coat_weight=1.0,
            coat_roughness=0.1,
        ),
    }
    parts: dict[str, Any] = {
        "surround": stage.surround(
            folder,
            zenith=(0.20, 0.21, 0.24),
            horizon=(0.24, 0.24, 0.25),
            ground=(0.05, 0.05, 0.05),
            lights=[
                Light((0.6, 1.0, 4.0), (0.34, 0.34), (11.0, 10.8, 10.4)),
                Light((-2.2, -3.4, 2.4), (0.50, 0.20), (9.0, 9.2, 9.6)),
                Light((-5.0, 6.4, 1.25), (0.75, 0.075), (11.0, 11.0, 11.0)),
                Light((7.0, 0.5, 1.6), (0.30, 0.10), (7.0, 7.0, 7.0)),
            ],
        ),
        "table": stage.table(80.0, 0.10, 0.10, 0.105),
    }
    for name, part in meshes().items():
        parts[name] = folder.mesh(name, part) | {"bsdf": materials[name]}
    view = stage.camera(options, (6.3, 5.6, 3.0), (0.02, 0.05, 0.58), 29)
    return stage.scene(view, parts)


@cache
def meshes() -> dict[str, Mesh]:
    """The parts of the car, one for each material; they are computed once in a process."""

    def half(field: Field, spacing: float) -> Mesh:
        return mesh(field, *BODY, spacing, mirror=True)

    def turned(outline: list[tuple[float, float]]) -> Mesh:
        return lathe(Profile(np.array(outline)), 96, 96)

    return {
        "body": projected(half(car_shape.body, FINE), TILE),
        "panes": half(car_shape.panes, FINE),
        "chrome": merged(
            [
                half(car_fittings.trim, FINEST),
                half(car_fittings.guards, FINEST),
                car_fittings.bumper(1),
                car_fittings.bumper(-1),
                car_fittings.on_wheels(turned(car_fittings.RIM)),
                car_fittings.at_lamps(turned(car_fittings.LAMP_RING)),
            ]
        ),
        "tyres": car_fittings.on_wheels(turned(car_fittings.TYRE)),
        "boards": half(car_fittings.boards, FINE),
        "lamps": car_fittings.at_lamps(turned(car_fittings.LAMP_PANE)),
    }


def _paint(folder: Folder, options: Options) -> dict[str, Any]:
    """Flakes of dark metal under a film, and a clear coat over them."""
    rng = np.random.default_rng(11)
    count = options.texels(TEXELS)
    flake = flakes(count, FLAKES, rng)
    thickness = FILM * (1 + DEVIATION * rng.normal(size=FLAKES**2))[flake]
    bright = rng.uniform(0.10, 0.26, size=FLAKES**2)[flake]
    return options.openpbr(
        base_metalness=1.0,
        base_color=folder.texture("flakes-metal", np.repeat(bright[..., None], 3, axis=-1)),
        specular_roughness=0.45,
        thin_film_weight=1.0,
        thin_film_thickness=folder.texture("flakes-film", thickness),
        thin_film_ior=2.3,
        coat_weight=1.0,
        coat_roughness=0.1,
        coat_ior=1.5,
    )


def flakes(texels: int, across: int, rng: np.random.Generator) -> np.ndarray:
    """The number of the flake at each texel (T, T), of `across` squared flakes; it repeats.

    One flake's middle lies at random in each cell of a grid, and the nearest one is seen.
    """
    middles = rng.random((across, across, 2))
    at = (np.arange(texels) + 0.5) * across / texels
    points = np.stack(np.meshgrid(at, at, indexing="ij"), axis=-1)
    cell = np.floor(points).astype(int)
    best, nearest = np.full((texels, texels), np.inf), np.zeros((texels, texels), int)
    for shift in np.ndindex(3, 3):
        there = cell + np.array(shift) - 1
        row, column = np.moveaxis(there % across, -1, 0)
        distance = np.linalg.norm(there + middles[row, column] - points, axis=-1)
        nearest = np.where(distance < best, row * across + column, nearest)
        best = np.minimum(best, distance)
    return nearest


def _rubber(folder: Folder, options: Options) -> dict[str, Any]:
    """Black rubber with a white wall on the outer side."""
    count = options.texels(512)
    outline = Profile(np.array(car_fittings.TYRE))
    radius, height = np.moveaxis(outline((np.arange(count) + 0.5) / count)[0], -1, 0)
    low, high = car_fittings.WHITE_WALL
    white = stage.smoothstep(low - 0.002, low + 0.002, radius) * (height > 0)
    white = white * stage.smoothstep(high + 0.002, high - 0.002, radius)
    color = 0.02 + (0.72 - 0.02) * white
    return options.openpbr(
        base_color=folder.texture("tyre", np.tile(color[:, None, None], (1, 8, 3))),
        specular_roughness=0.55,
    )
