"""Mip levels of latent textures: their error by level, and a receding plane with and without them.

    python -m figures.mipmaps.compute

The errors of levels are those of `benchmarks.quality.mipmap`. The plane is lacquered gold with a
pattern in all of the coat's parameters. `DRAWS` samples in the middle of each pixel, each of which
draws a texel, read the first level (no filter), averages of codes as in Fan et al. (2022), or those
of Urushi; the reference has `SAMPLES` samples of the first level all over the pixel. The light is a
set of directions, so that nothing but the texture has to be filtered.
"""

import contextlib
import functools
import json
import os
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest import mock

import drjit as dr
import mitsuba as mi
import numpy as np
from benchmarks.quality import mipmap
from gallery import stage

import urushi  # noqa: F401  (registers the plugins)
from figures import results
from urushi.core import error_metrics as metrics
from urushi.nets.weights import default_model
from urushi.textures import cache, mip_pyramid

FOLDER = Path(__file__).parent
PARTS = results.parts_folder("mipmaps")
KINDS = ("alpha, smooth", "albedo, smooth", "all, smooth", "all, noise")
METHODS = ("no filter", "averages of codes", "Urushi")
#: Picture, samples along a side of a pixel of the reference, and texels of the pattern's side.
WIDTH, HEIGHT, SUPER, TEXELS = 320, 192, 24, 128
#: How often the pattern repeats along a side of the plane, and half of this side.
REPEATS, HALF = 48.0, 24.0
SAMPLES = SUPER**2
#: Samples along a side of the middle of a pixel, and the size of this middle in pixels.
DRAWN, SPOT = 4, 0.01
DRAWS = DRAWN**2
#: Seed of the samples.
SEED = 3


def main() -> None:
    """Compute what is missing and write results.json."""
    mi.set_variant("llvm_ad_rgb")
    parts: dict[str, Any] = {kind: functools.partial(levels, kind) for kind in KINDS}
    found = results.collect(PARTS, parts | {"plane": plane})
    head = {"weights": default_model().fingerprint}
    text = {"levels": {kind: found[kind] for kind in KINDS}, "plane": found["plane"]}
    results.write(FOLDER / "results.json", {**head, **json.loads(json.dumps(text))})


def levels(kind: str) -> list[list[float]]:
    """E of levels 1, 2, ... (rows): averages of codes, and Urushi's levels."""
    return results.rounded(np.array(mipmap.errors(default_model(), kind))[:, :2])


def plane(
    width: int = WIDTH, height: int = HEIGHT, side: int = SUPER, folder: Path = PARTS
) -> dict[str, Any]:
    """`differences` of the middles of pixels; the pictures are written as plane.npz."""
    pictures = {}
    for name in METHODS:
        with codes_averaged() if name == "averages of codes" else contextlib.nullcontext():
            scene, lights = loaded(mipmaps=name != "no filter")
        pictures[name] = radiance(scene, lights, width, height, DRAWN, SPOT)
        if name == "no filter":
            pictures["reference"] = radiance(scene, lights, width, height, side)
    results.write_pictures(folder / "plane.npz", pictures)
    return differences(pictures)


def differences(pictures: dict[str, np.ndarray]) -> dict[str, Any]:
    """Differences of each method's picture (H, W, 3) from the reference, below the horizon.

    Returns:
        Of each method the relative mean squared `error`, the relative difference of mean radiance
        `light`, and by row from the horizon down the relative root mean squared error `rows`.
    """
    # As stored, so that the pictures that are shown have these errors.
    pictures = {name: np.float16(x).astype(np.float64) for name, x in pictures.items()}
    reference, found = pictures["reference"], {}
    # A row that the plane covers in part is lit in the reference alone.
    lit = pictures["no filter"].sum(axis=(1, 2)) > 0
    reference = reference[lit]
    for name in METHODS:
        image = pictures[name][lit]
        squared, mean = (x.mean(axis=(1, 2)) for x in ((image - reference) ** 2, reference**2))
        found[name] = {
            "error": float(f"{metrics.relative_mse(image, reference):.4g}"),
            "light": float(f"{image.sum() / reference.sum() - 1:.4g}"),
            "rows": results.rounded(np.sqrt(squared / mean), 3),
        }
    return found


@contextlib.contextmanager
def codes_averaged() -> Iterator[None]:
    """Mip levels are averages of the codes themselves, while the context lasts; none is kept."""
    same = {"lifted": lambda model, z: z, "dropped": lambda model, means: means}
    with (
        mock.patch.multiple(mip_pyramid, **same),
        mock.patch.dict(os.environ, {cache.VARIABLE: "off"}),
    ):
        yield


def loaded(mipmaps: bool) -> tuple[Any, list[tuple[np.ndarray, float]]]:
    """The plane before its camera, and the light: directions towards it, and irradiance of each."""
    transform = mi.ScalarTransform4f()
    with TemporaryDirectory() as name:
        bsdf = material(stage.Folder(Path(name))) | {"mipmaps": mipmaps}
        scene = mi.load_dict(
            {
                "type": "scene",
                "plane": {
                    "type": "rectangle",
                    "to_world": transform.translate([0, HALF - 1, 0]).scale(HALF),
                    "bsdf": bsdf,
                },
                "sensor": {
                    "type": "perspective",
                    "fov": 50,
                    "to_world": transform.look_at([0, -2.4, 1.6], [0, 3.2, 0], [0, 0, 1]),
                    "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT},
                },
            }
        )
    lights = []
    for up, power in ((0.25, 0.05), (0.5, 0.08), (0.9, 0.12), (2.0, 0.3)):
        for across in (-1.0, -0.6, -0.2, 0.2, 0.6, 1.0):
            towards = np.array([across, 0.8, up])
            lights.append((towards / np.linalg.norm(towards), power))
    return scene, lights


def material(folder: stage.Folder) -> dict[str, Any]:
    """Gold under a coat whose alpha, albedo and optical depth have dots, stripes and lines."""
    x, y = np.meshgrid(*[(np.arange(TEXELS) + 0.5) / TEXELS] * 2)
    dots = stage.smoothstep(0.36, 0.32, np.hypot(x - 0.5, y - 0.5))
    stripes = stage.smoothstep(-0.2, 0.2, np.sin(2 * np.pi * 8 * (x + y)))
    bare = np.clip(dots * stripes + stage.smoothstep(0.06, 0.04, np.minimum(x, y)), 0, 1)[..., None]
    red, clear = np.array([0.95, 0.25, 0.1]), np.array([0.9, 0.8, 0.6])
    return {
        "type": "neural_layered",
        "alpha": folder.texture("alpha", 0.3 * 0.4 ** bare[..., 0]),
        "albedo": folder.texture("albedo", red + (clear - red) * bare),
        "sigma_t": folder.texture("depth", 5.0 * 0.01**bare * np.ones(3)),
        "bottom": stage.conductor("Au", 0.25),
    } | {"int_ior": 1.5}


def radiance(
    scene: Any, lights: list, width: int, height: int, side: int, size: float = 1.0
) -> np.ndarray:
    """The picture (height, width, 3) with side x side samples per pixel, jittered within a grid.

    size: side of the grid about the middle of a pixel [pixels].
    """
    sensor, total = scene.sensors()[0], np.zeros((height, width, 3))
    rng = np.random.default_rng(SEED)
    row, column, across = np.indices((height, width, side)).reshape(3, -1)
    for down in range(side):
        u, v = rng.random((2, len(row)))
        x, y = (size * ((k + w) / side - 0.5) + 0.5 for k, w in ((across, u), (down, v)))
        place = mi.Point2f(mi.Float((column + x) / width), mi.Float((row + y) / height))
        ray, _ = sensor.sample_ray_differential(0, 0.5, place, 0.5)
        ray.scale_differential(WIDTH / width)
        si = scene.ray_intersect(ray)
        si.compute_uv_partials(ray)
        si.uv = si.uv * REPEATS
        si.duv_dx, si.duv_dy = si.duv_dx * REPEATS, si.duv_dy * REPEATS
        value = mi.Color3f(0)
        for towards, power in lights:
            wo = si.to_local(mi.Vector3f(*map(float, towards)))
            value += power * si.shape.bsdf().eval(mi.BSDFContext(), si, wo, si.is_valid())
        values = np.array(dr.select(si.is_valid(), value, 0)).T
        total += values.reshape(height, width, side, 3).mean(axis=2)
    return total / side


if __name__ == "__main__":
    main()
