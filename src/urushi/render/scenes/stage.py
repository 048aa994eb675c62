"""What the scenes share: their options, camera, backdrop, lights, and the coat under study."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mitsuba as mi
import numpy as np

from urushi.errors import ParameterError
from urushi.nets import shipped
from urushi.render.scenes.folder import Folder
from urushi.render.scenes.mesh import Mesh, grid

Vector = Sequence[float]

#: The plugins that a scene's coats can be made of, the networks first.
COATS = ("neural_layered", "layered")


@dataclass(frozen=True)
class Options:
    """How a scene is to be rendered.

    Attributes:
        coat: plugin of all coats, "neural_layered" or "layered".
        weights: networks of "neural_layered": "base", "small" or a weights file.
        width, height: of the film [pixels].
        spp: samples a pixel.
        detail: scale of the sizes of textures; below 1 the scene loads faster and looks coarser.
    """

    coat: str = COATS[0]
    weights: str = "base"
    width: int = 640
    height: int = 480
    spp: int = 64
    detail: float = 1.0

    def __post_init__(self):
        if self.coat not in COATS:
            raise ParameterError(f"coat is '{self.coat}'; choose one of {', '.join(COATS)}")
        for name in ("width", "height", "spp"):
            if getattr(self, name) < 1:
                raise ParameterError(f"{name} is {getattr(self, name)}; it must be at least 1")
        if not 0 < self.detail <= 4:
            raise ParameterError(f"detail is {self.detail:g}; it must be above 0 and at most 4")

    def texels(self, count: int) -> int:
        """Texels along a side that has `count` at full detail."""
        return max(8, round(count * self.detail))

    def coated(self, bottom: dict[str, Any], **parameters: Any) -> dict[str, Any]:
        """The coat with these parameters over `bottom`; only what differs from defaults is said.

        So one word is all that tells the network's scene from its reference's.
        """
        named = self.coat == COATS[0] and self.weights != shipped.NAMES[0]
        weights = {"weights": self.weights} if named else {}
        return {"type": self.coat, **parameters, **weights, "bottom": bottom}


def rgb(*value: float) -> dict[str, Any]:
    """A colour."""
    return {"type": "rgb", "value": list(value)}


def conductor(material: str, alpha: float) -> dict[str, Any]:
    """A rough metal, by the name of its measured index."""
    return {
        "type": "roughconductor",
        "distribution": "ggx",
        "material": material,
        "alpha": alpha,
    }


def diffuse(*value: float) -> dict[str, Any]:
    """A Lambertian surface."""
    return {"type": "diffuse", "reflectance": rgb(*value)}


def scene(options: Options, camera: dict[str, Any], parts: dict[str, Any]) -> dict[str, Any]:
    """The whole scene: integrator, camera and parts, ready for `mi.load_dict`."""
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 6},
        "sensor": camera,
        **parts,
    }


def camera(options: Options, origin: Vector, target: Vector, fov: float) -> dict[str, Any]:
    """A perspective camera, z up; fov is across the larger side [degrees]."""
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


def softbox(origin: Vector, target: Vector, size: Vector, radiance: Vector) -> dict[str, Any]:
    """A light: a one-sided black rectangle of half sizes `size`, facing `target`."""
    transform = mi.ScalarTransform4d()
    return {
        "type": "rectangle",
        "to_world": transform.look_at(origin=origin, target=target, up=[0, 0, 1])
        @ transform.scale([*size, 1]),
        "emitter": {"type": "area", "radiance": rgb(*radiance)},
        "bsdf": diffuse(0, 0, 0),
    }


def sky(folder: Folder, zenith: Vector, horizon: Vector, ground: Vector) -> dict[str, Any]:
    """A dim surround that fades from the zenith's radiance to the horizon's, and the ground's."""
    up = np.cos(np.linspace(0, np.pi, 64))[:, None, None]
    above = np.asarray(horizon) + np.subtract(zenith, horizon) * np.clip(up, 0, 1) ** 0.5
    below = np.asarray(horizon) + np.subtract(ground, horizon) * np.clip(-4 * up, 0, 1)
    radiance = np.where(up >= 0, above, below)
    return folder.environment("sky", np.broadcast_to(radiance, (64, 128, 3)))


def sweep(
    depth: float = 5.0, radius: float = 2.5, height: float = 8.0, width: float = 30.0
) -> Mesh:
    """A photographer's backdrop: the floor z = 0, curving up into a wall behind, at y = depth.

    u goes across (x), v from the front over the floor up the wall.
    """
    front = 12.0
    bend = np.linspace(0, np.pi / 2, 33)
    y = np.concatenate([[-front], depth - radius + radius * np.sin(bend), [depth]])
    z = np.concatenate([[0], radius - radius * np.cos(bend), [height]])
    x = np.array([-width / 2, width / 2])
    points = np.zeros((len(y), 2, 3))
    points[..., 0] = x
    points[..., 1], points[..., 2] = y[:, None], z[:, None]
    return grid(points)
