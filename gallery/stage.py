"""Parts that the scenes share: files, options, materials, camera, light and table."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from gallery.mesh import Mesh, write_ply
from gallery.options import Options
from urushi.files import atomic_write, new_folder


class Folder:
    """The folder of a scene's files; it writes meshes and textures, and returns their nodes."""

    def __init__(self, path: Path):
        """Use the folder `path`, and make it if it is missing; FileError if it cannot be made."""
        self.path = new_folder(path).resolve()

    def mesh(self, name: str, mesh: Mesh) -> dict[str, Any]:
        """The shape of a mesh, which is written as a PLY file."""
        file = self.path / f"{name}.ply"
        write_ply(mesh, file)
        return {"type": "ply", "filename": str(file)}

    def texture(self, name: str, values: np.ndarray) -> dict[str, Any]:
        """A texture of (H, W) or (H, W, 3) values without colour conversion; row 0 is at v = 0."""
        return {"type": "bitmap", "filename": self._image(name, values), "raw": True}

    def environment(self, name: str, radiance: np.ndarray) -> dict[str, Any]:
        """An environment map (H, W, 3): row 0 is +z; columns run from +y through +x to +y again."""
        turned = mi.ScalarTransform4d().rotate([1, 0, 0], 90)
        return {"type": "envmap", "filename": self._image(name, radiance), "to_world": turned}

    def _image(self, name: str, values: np.ndarray) -> str:
        """Write an EXR file of half floats; returns its path."""
        pixels = np.ascontiguousarray(values, dtype=np.float16)
        file = self.path / f"{name}.exr"
        with atomic_write(file) as temporary:
            mi.Bitmap(pixels if pixels.ndim == 3 else pixels[..., None]).write(str(temporary))
        return str(file)


Vector = Sequence[float]


def rgb(*value: float) -> dict[str, Any]:
    """A colour of linear RGB values."""
    return {"type": "rgb", "value": list(value)}


def conductor(material: str, alpha: float | tuple[Any, Any]) -> dict[str, Any]:
    """A rough metal.

    material: Mitsuba's name of its index of refraction; alpha: its GGX width, or its widths along
    the tangent and across it, numbers or textures.
    """
    both = {"alpha_u": alpha[0], "alpha_v": alpha[1]} if isinstance(alpha, tuple) else None
    widths = {"alpha": alpha} if both is None else both
    return {"type": "roughconductor", "distribution": "ggx", "material": material, **widths}


def diffuse(*value: float) -> dict[str, Any]:
    """A Lambertian surface."""
    return {"type": "diffuse", "reflectance": rgb(*value)}


def scene(camera: dict[str, Any], parts: dict[str, Any]) -> dict[str, Any]:
    """The whole scene: integrator, camera and parts, ready for `mi.load_dict`."""
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 6},
        "sensor": camera,
        **parts,
    }


def camera(options: Options, origin: Vector, target: Vector, fov: float) -> dict[str, Any]:
    """A perspective camera with z up; fov: field of view along the larger side [degrees]."""
    return {
        "type": "perspective",
        "fov": fov,
        "fov_axis": "larger",
        "to_world": mi.ScalarTransform4d().look_at(origin=origin, target=target, up=[0, 0, 1]),
        "film": {
            "type": "hdrfilm",
            "width": options.width,
            "height": options.height,
            "rfilter": {"type": "gaussian"},
            "pixel_format": "rgb",
            "component_format": "float32",
        },
        "sampler": {"type": "independent", "sample_count": options.spp},
    }


@dataclass(frozen=True)
class Light:
    """A softbox far away: a square patch of the sky with soft edges.

    Attributes:
        towards: direction from the scene to it; z is up.
        size: half of its width and half of its height [rad].
        radiance: linear RGB in its middle.
    """

    towards: Vector
    size: tuple[float, float]
    radiance: Vector


def surround(
    folder: Folder, zenith: Vector, horizon: Vector, ground: Vector, lights: Sequence[Light]
) -> dict[str, Any]:
    """The only emitter: a smooth sky of three radiances, with lights in it.

    Samples of one environment map have less noise than samples of several lamps.
    """
    theta, phi = np.pi * (np.arange(256) + 0.5) / 256, 2 * np.pi * (np.arange(512) + 0.5) / 512
    up = np.broadcast_to(np.cos(theta)[:, None], (256, 512))
    across = np.sin(theta)[:, None]
    points = np.stack([across * np.sin(phi), across * np.cos(phi), up], axis=-1)
    return folder.environment("surround", radiance(points, zenith, horizon, ground, lights))


def radiance(
    points: np.ndarray, zenith: Vector, horizon: Vector, ground: Vector, lights: Sequence[Light]
) -> np.ndarray:
    """Radiance (..., 3) of the sky and its lights towards unit vectors (..., 3); z is up."""
    up = points[..., 2]
    above = np.asarray(horizon) + np.subtract(zenith, horizon) * smoothstep(0, 0.6, up)[..., None]
    result = above + (ground - above) * smoothstep(-0.02, -0.35, up)[..., None]
    for light in lights:
        axis = np.asarray(light.towards, float) / np.linalg.norm(light.towards)
        side = np.cross(axis, [0.0, 0.0, 1.0])
        side /= np.linalg.norm(side)
        ahead = points @ axis
        beside, over = (
            np.abs(points @ along) / (np.maximum(ahead, 1e-3) * np.tan(size))
            for along, size in zip((side, np.cross(side, axis)), light.size, strict=True)
        )
        edge = smoothstep(1.15, 0.85, beside) * smoothstep(1.15, 0.85, over) * (ahead > 0)
        result = result + edge[..., None] * np.asarray(light.radiance)
    return result


def smoothstep(low: float, high: float, x: np.ndarray) -> np.ndarray:
    """0 below `low`, 1 above `high`, a smooth cubic between."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def table(radius: float, *reflectance: float) -> dict[str, Any]:
    """A round table with its top at z = 0; it is matt, so that only the coats cause noise."""
    return {
        "type": "disk",
        "to_world": mi.ScalarTransform4d().scale(radius),
        "bsdf": diffuse(*reflectance),
    }
