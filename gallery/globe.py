"""The scene "globe": a lacquered globe on gold, with the map in the medium, in a brass ring."""

from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from gallery import noise, stage
from gallery.grids import grid
from gallery.mesh import Mesh, Profile, lathe
from gallery.options import Options
from gallery.stage import Folder, Light, rgb

#: Number of rows of the map; it has twice as many columns.
ROWS = 512
#: Height of the globe's centre above the table, in radii; and tilt of its axis [degrees].
CENTRE, TILT = 1.72, 23.4
#: Longitude that faces the camera [degrees].
FACING = 28.0


def globe(folder: Folder, options: Options) -> dict[str, Any]:
    """Describe the scene for `mi.load_dict`; its files are written into `folder`."""
    albedo, depth = chart(options.texels(ROWS))
    transform = mi.ScalarTransform4d()
    placed = transform.translate([0, 0, CENTRE]) @ transform.rotate([0, 1, 0], TILT)
    parts = {
        "surround": stage.surround(
            folder,
            zenith=(0.40, 0.46, 0.58),
            horizon=(0.26, 0.23, 0.20),
            ground=(0.10, 0.085, 0.07),
            lights=[
                Light((-4.6, -3.6, 3.7), (0.36, 0.36), (10.5, 9.8, 8.8)),
                Light((4.2, 1.8, 1.6), (0.20, 0.55), (8.0, 9.0, 10.6)),
            ],
        ),
        "table": stage.table(5.0, 0.12, 0.085, 0.06),
        "globe": {
            "type": "sphere",
            "to_world": placed @ transform.rotate([0, 0, 1], -90 - FACING),
            "bsdf": options.coated(
                stage.conductor("Au", 0.25),
                alpha=0.03,
                int_ior=1.5,
                albedo=folder.texture("map-albedo", albedo),
                sigma_t=folder.texture("map-depth", depth),
            ),
        },
        "meridian": folder.mesh("meridian", ring(1.09, 0.035, 0.07))
        | {
            "to_world": placed @ transform.rotate([1, 0, 0], 90),
            "bsdf": stage.conductor("Au", 0.18),
        },
        "axis": {
            "type": "cylinder",
            "p0": [0, 0, -1.2],
            "p1": [0, 0, 1.2],
            "radius": 0.022,
            "to_world": placed,
            "bsdf": stage.conductor("Au", 0.15),
        },
        "foot": folder.mesh("foot", lathe(Profile(np.array(FOOT)), 128, 256))
        | {
            "bsdf": options.coated(
                stage.diffuse(0.30, 0.10, 0.05),
                alpha=0.06,
                int_ior=1.5,
                albedo=rgb(0.75, 0.16, 0.06),
                sigma_t=rgb(0.6, 1.2, 1.6),
            )
        },
    }
    view = stage.camera(options, (0, -9.2, 2.6), (0, 0, 1.40), 26)
    return stage.scene(view, parts)


def chart(rows: int) -> tuple[np.ndarray, np.ndarray]:
    """The map: albedo and optical depth of the medium, (rows, 2 rows, 3) each; row 0 is north.

    The medium is thin and warm over land, so that the gold shines through, and deep over seas. The
    lines of the graticule and the coasts are bare gold.
    """
    longitude = 180 / rows * (np.arange(2 * rows) + 0.5)
    latitude = 90 - 180 / rows * (np.arange(rows) + 0.5)
    longitude, latitude = np.meshgrid(longitude, latitude)
    east, across = np.radians(longitude), np.cos(np.radians(latitude))
    north = np.sin(np.radians(latitude))
    points = np.stack([across * np.cos(east), across * np.sin(east), north], axis=-1)
    land = _land(rows)[..., None]
    relief = noise.fractal(points * 5, 5, seed=7, gain=0.6)[..., None]
    north = np.abs(north[..., None])
    ice = stage.smoothstep(0.90, 0.97, north + 0.03 * relief)
    dry = stage.smoothstep(0.15, -0.15, np.abs(north - 0.42) - 0.12 + 0.10 * relief)

    green, sand, white = np.array([[0.42, 0.55, 0.16], [0.93, 0.62, 0.25], [0.97, 0.97, 0.95]])
    ground = green + (sand - green) * dry
    ground = ground + (white - ground) * ice
    ground = np.clip(ground * (1 + 0.25 * relief), 0, 0.98)
    shelf = stage.smoothstep(0, 1, _blur(land[..., 0], rows / 24)[..., None])
    sea = np.array([0.03, 0.13, 0.30]) + np.array([0.10, 0.33, 0.30]) * shelf
    albedo = sea + (ground - sea) * land

    deep = np.array([3.4, 2.6, 2.0]) * (1 - 0.45 * shelf)
    shallow = np.array([0.55, 0.65, 1.0]) * (1 + 2.2 * ice) * (1 + 0.4 * relief)
    depth = deep + (np.maximum(shallow, 0.1) - deep) * land
    gold_share = np.maximum(0.85 * _graticule(longitude, latitude), _coast(land))
    return albedo, depth * (1 - gold_share) + 0.08 * gold_share


def _land(rows: int) -> np.ndarray:
    """The fraction of land (rows, 2 rows) of a map of the Earth from longitude 0 to the east."""
    drawn = mi.Bitmap(str(Path(__file__).with_name("land.png")))
    grey = drawn.convert(mi.Bitmap.PixelFormat.Y, mi.Struct.Type.Float32, srgb_gamma=False)
    return np.clip(np.array(grey.resample([2 * rows, rows])), 0, 1).reshape(rows, -1)


def _graticule(longitude: np.ndarray, latitude: np.ndarray) -> np.ndarray:
    """Thin lines every 15 degrees, whose width on the sphere is the same everywhere."""
    off_latitude = np.abs((latitude + 7.5) % 15 - 7.5)
    off_longitude = np.abs((longitude + 7.5) % 15 - 7.5) * np.cos(np.radians(latitude))
    off_longitude = np.where(np.abs(latitude) < 75.2, off_longitude, np.inf)
    width, soft = 0.16, max(0.12, 90 / len(latitude))
    lines = [stage.smoothstep(width + soft, width - soft, d) for d in (off_latitude, off_longitude)]
    return np.maximum(*lines)[..., None]


def _coast(land: np.ndarray) -> np.ndarray:
    """1 along the borders of the land."""
    return stage.smoothstep(0.25, 0.75, 4 * land * (1 - land))


def _blur(image: np.ndarray, sigma: float) -> np.ndarray:
    """A map (H, W), which repeats in longitude, blurred by a Gaussian of `sigma` texels."""
    edge = len(image) // 4
    padded = np.pad(image, ((edge, edge), (0, 0)), mode="edge")
    v, u = np.fft.fftfreq(padded.shape[0])[:, None], np.fft.rfftfreq(padded.shape[1])
    spectrum = np.fft.rfft2(padded) * np.exp(-2 * (np.pi * sigma) ** 2 * (u**2 + v**2))
    return np.fft.irfft2(spectrum, padded.shape)[edge:-edge]


def ring(radius: float, thick: float, wide: float) -> Mesh:
    """A ring about the z axis, `thick` along the radius and `wide` along z, with rounded edges."""
    across = np.linspace(0, 2 * np.pi, 49)
    cos, sin = np.cos(across), np.sin(across)
    r = radius + thick * np.sign(cos) * np.abs(cos) ** 0.5
    z = wide * np.sign(sin) * np.abs(sin) ** 0.5
    turn = np.linspace(0, 2 * np.pi, 257)[None, :]
    points = np.stack(
        [
            r[:, None] * np.cos(turn),
            r[:, None] * np.sin(turn),
            np.broadcast_to(z[:, None], (49, 257)),
        ],
        axis=-1,
    )
    return grid(points, closed=True)


# The foot's outline (radius and height), from the middle of the underside to the top.
FOOT = [
    (0.00, 0.00), (0.40, 0.00), (0.74, 0.00), (0.80, 0.00), (0.82, 0.03), (0.80, 0.08),
    (0.74, 0.11), (0.62, 0.12), (0.58, 0.14), (0.60, 0.17), (0.56, 0.21), (0.36, 0.26),
    (0.18, 0.33), (0.13, 0.40), (0.17, 0.44), (0.17, 0.47), (0.11, 0.50), (0.10, 0.54),
    (0.14, 0.60), (0.10, 0.64), (0.00, 0.65),
]  # fmt: skip
