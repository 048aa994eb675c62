"""The scenes of benchmarks: the demo's, the gallery's and one variation, by methods and lights.

Methods are weights of `neural_layered` (a name or a file) or of Fan et al. (`PAPER`),
`WALK`, the plugins of `RIVALS`, and `PRINCIPLED`: Mitsuba's principled BSDF in the place of every
coat, with as many textures. It looks different, and shows what an ordinary material costs in the
same scene.
"""

import hashlib
import re
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fan2022  # noqa: F401  (registers the plugins)
import mitsuba as mi
import numpy as np
from gallery import export, noise
from gallery.options import COATS, Options
from gallery.scenes import SCENES as GALLERY
from gallery.stage import Folder, smoothstep
from research.rivals import plugins

from urushi.nets import weights as networks

SCENES = tuple(GALLERY)
#: Before the file of weights of the system of Fan et al. (2022), where others are a name or a file.
PAPER = "fan2022:"
#: The still life with textures of the coats' alpha and index, as in Figure 1 of Fan et al. (2022);
#: their ranges, and texels along a side.
TEXTURED = "textured-still-life"
RANGES, TEXELS = {"alpha": (0.03, 0.45), "int_ior": (1.3, 1.9)}, 512
WALK, PRINCIPLED = "layered", "principled"
#: Models of other authors, which take the parameters of `WALK`.
RIVALS = ("layered_belcour", "layered_weidlich")
plugins.register()

#: Kinds of light: the scene's own; one point light; a cloudless sky with the sun.
OWN, POINT, SKY = LIGHTS = ("own", "point", "sky")
#: The scene's own light and the point light together.
BOTH = "both"

#: Direction to the sun, and the scale of its and the sky's radiance.
SUN, EXPOSURE = (-0.5, -0.6, 0.6), 4.0

#: The point light's place beside and above the camera, in distances of the camera from the origin,
#: near which the subject of every scene is.
BESIDE = (0.35, 0.5)


@dataclass(frozen=True)
class View:
    """A scene as it is rendered."""

    scene: str  # one of `SCENES`, or `TEXTURED`
    light: str = OWN  # one of `LIGHTS`, or `BOTH`
    width: int = 96  # of the picture [pixels]; the height is 3/4 of it
    detail: float = 0.25  # factor on the size of the textures
    depth: int = 6  # longest path, in segments; 2: direct light alone, which has no caustics

    @property
    def name(self) -> str:
        return f"{self.scene}-{self.light}-{self.width}-{self.depth}"

    def described(self, method: str, folder: Path) -> dict[str, Any]:
        """The scene for `mi.load_dict`, with meshes and textures in a folder.

        method: weights by name or file, `WALK`, one of `RIVALS`, or `PRINCIPLED`.
        """
        kind = WALK if method == WALK or method in RIVALS else COATS[0]
        size = {"width": self.width, "height": self.width * 3 // 4}
        options = Options(coat=kind, detail=self.detail, **size)
        name = "still-life" if self.scene == TEXTURED else self.scene
        scene = export.build(GALLERY[name], folder, options)
        if self.scene == TEXTURED:
            scene = _textured(scene, folder, options)
        if self.light == BOTH:
            scene["point"] = _light(POINT, scene["sensor"])
        elif self.light != OWN:
            nodes = {key: node for key, node in scene.items() if isinstance(node, dict)}
            for key, node in nodes.items():
                if node["type"] == "envmap" or "emitter" in node:
                    del scene[key]
            scene["light"] = _light(self.light, scene["sensor"])
        scene["integrator"] = {"type": "path", "max_depth": self.depth}
        return _with_method(scene, method)

    def load(self, method: str) -> tuple[Any, str]:
        """The scene for `mi.render`, and its `digest`."""
        with tempfile.TemporaryDirectory(prefix="urushi-") as folder:
            scene = self.described(method, Path(folder))
            return mi.load_dict(scene), digest(scene, Path(folder))


def digest(scene: dict[str, Any], folder: Path) -> str:
    """The hash of everything that a scene's picture depends on, its files in a folder included."""
    text = str(scene)
    parts = [mi.__version__.encode(), text.replace(str(folder.resolve()), "").encode()]
    parts += [path.read_bytes() for path in sorted(folder.iterdir())]
    if f"'{COATS[0]}'" in text:
        models = networks.default_model(), networks.anisotropic_model()
        parts += [model.fingerprint.encode() for model in models]
    for file in map(Path, re.findall(r"'weights': '([^']*)'", text)):
        parts.append(file.read_bytes() if file.is_file() else b"")
    return hashlib.sha256(b"\0".join(parts)).hexdigest()


def _light(kind: str, sensor: dict[str, Any]) -> dict[str, Any]:
    """The point light, which gives a facing surface at the origin irradiance pi, or the sky."""
    if kind == SKY:
        scales = {"sun_scale": EXPOSURE, "sky_scale": EXPOSURE}
        return {"type": "sunsky", "sun_direction": list(SUN), **scales}
    left, up, _, origin = np.array(sensor["to_world"].matrix, float)[:3].T
    distance = np.linalg.norm(origin)
    position = origin + distance * (BESIDE[0] * left + BESIDE[1] * up)
    intensity = float(np.pi * position @ position)
    return {
        "type": "point",
        "position": position.tolist(),
        "intensity": {"type": "rgb", "value": [intensity] * 3},
    }


def _with_coats(node: dict[str, Any], change: Callable[[dict], dict]) -> dict[str, Any]:
    """The description with another node in the place of every coat."""
    if node.get("type") in COATS or node.get("reference") == COATS[0]:
        return change(node)
    return {k: _with_coats(v, change) if isinstance(v, dict) else v for k, v in node.items()}


def _with_method(node: dict[str, Any], method: str) -> dict[str, Any]:
    """The description with the method's material in the place of every coat."""
    if method in RIVALS:
        # Coats nest: of another type, they are searched too.
        return _with_coats(node, lambda own: _with_method(own | {"type": method}, method))
    # Without weights a coat chooses the shipped networks that its surfaces need.
    if method in (WALK, networks.DEFAULT):
        return node
    return _with_coats(node, _principled if method == PRINCIPLED else lambda x: x | coat(method))


def coat(plugin: str) -> dict[str, str]:
    """The type and the weights of a coat by `WALK`, by one of `RIVALS`, or by weights."""
    if plugin in (WALK, *RIVALS):
        return {"type": plugin}
    if plugin.startswith(PAPER):
        return {"type": "fan2022_layered", "weights": plugin.removeprefix(PAPER)}
    return {"type": COATS[0], "weights": plugin}


def _textured(scene: dict[str, Any], folder: Path, options: Options) -> dict[str, Any]:
    """The scene "still-life" with textures of alpha and index on vase, plate, bowl, table, beads.

    Crystals in the glaze, bands on the plate, stripes on the beads, wear on bowl and table.
    """
    files, side = Folder(folder), options.texels(TEXELS)
    v, u = np.meshgrid(*[(np.arange(side) + 0.5) / side] * 2, indexing="ij")
    around = np.stack([np.cos(2 * np.pi * u), np.sin(2 * np.pi * u), 3 * v], axis=-1)
    spots = smoothstep(-0.1, 0.15, noise.fractal(2 * around, 3, seed=31))
    wear = smoothstep(-0.3, 0.5, noise.fractal(around * 4, 4, seed=32))
    bands = smoothstep(-0.25, 0.25, np.sin(2 * np.pi * 10 * v))
    stripes = smoothstep(-0.25, 0.25, np.sin(2 * np.pi * 4 * u))
    patterns = {
        "vase": (spots, 1 - spots),
        "plate": (wear, bands),
        "bowl": (wear, spots),
        "table": (wear, wear),
        **{f"bead-{index}": (stripes, spots) for index in range(3)},
    }

    result = dict(scene)
    for name, shares in patterns.items():
        textures = {
            parameter: files.texture(f"{name}-{parameter}", low * (high / low) ** share)
            for (parameter, (low, high)), share in zip(RANGES.items(), shares, strict=True)
        }
        result[name] = _with_coats(scene[name], lambda node, own=textures: node | own)
    return result


def _principled(node: dict[str, Any]) -> dict[str, Any]:
    """A principled BSDF with as many textures as a coat and its bottom have, at most three."""
    maps = list(_bitmaps(node))
    colours = [other for other in maps if other is not node.get("sigma_t")][:1] * len(maps)
    colour = node.get("albedo", node.get("base_color", 0.5))
    constant = {"base_color": colour, "metallic": 0.5, "clearcoat": 1.0}
    return {
        "type": PRINCIPLED,
        "roughness": node.get("alpha", node.get("coat_roughness", 0.3)),
        **constant,
        **dict(zip(("base_color", "metallic", "clearcoat"), colours, strict=False)),
    }


def _bitmaps(node: dict[str, Any]) -> Iterator[dict[str, Any]]:
    if node.get("type") == "bitmap":
        yield node
    for value in node.values():
        if isinstance(value, dict):
            yield from _bitmaps(value)
