"""The pictures of the page "Anisotropy": python anisotropy.py [FOLDER] [--size N] [--spp N]"""

import argparse
from pathlib import Path

import mitsuba as mi
import numpy as np

import urushi  # noqa: F401 (registers the plugins)

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("folder", type=Path, nargs="?", default=Path())
parser.add_argument("--size", type=int, default=480)
parser.add_argument("--spp", type=int, default=256)
options = parser.parse_args()
mi.set_variant("llvm_ad_rgb")

# [brushed]
steel = {"type": "roughconductor", "material": "Cr", "distribution": "ggx"}
hairline = {
    "type": "neural_layered",
    "alpha": 0.02,
    "bottom": {**steel, "alpha_u": 0.06, "alpha_v": 0.3},
}
# [end brushed]

# [turned]
v, u = (np.mgrid[0:256, 0:256] + 0.5) / 256 - 0.5
around = np.degrees(np.arctan2(v, u)) + 90  # the tangent of a lathe, round the middle of uv
copper = {"type": "roughconductor", "material": "Cu", "distribution": "ggx"}
turned = {
    "type": "neural_layered",
    "alpha": 0.05,
    "sigma_t": {"type": "rgb", "value": [0.05, 0.25, 0.9]},
    "rotation": {
        "type": "bitmap",
        "bitmap": mi.Bitmap(around[..., None].astype(np.float32)),
        "raw": True,
        "filter_type": "nearest",
    },
    "bottom": {**copper, "alpha_u": 0.06, "alpha_v": 0.3},
}
# [end turned]

satin = {
    "type": "neural_layered",
    "alpha_u": 0.35,
    "alpha_v": 0.06,
    "albedo": {"type": "rgb", "value": [0.8, 0.1, 0.05]},
    "sigma_t": 2.0,
    "bottom": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.5, 0.05, 0.03]}},
}

to_world = mi.ScalarTransform4f()
scene = {
    "type": "scene",
    "integrator": {"type": "path", "max_depth": 6},
    "sensor": {
        "type": "perspective",
        "fov": 43,
        "to_world": to_world.look_at([0, -8.5, 3.0], [0.05, 0, 0.85], [0, 0, 1]),
        "film": {"type": "hdrfilm", "width": options.size, "height": options.size // 3},
        "sampler": {"type": "independent", "sample_count": options.spp},
    },
    "sky": {"type": "constant", "radiance": 0.12},
    "lamp": {
        "type": "rectangle",
        "to_world": to_world.look_at([-3, -5, 6], [0, 0, 0.8], [0, 0, 1]).scale([0.9, 0.9, 1]),
        "emitter": {"type": "area", "radiance": 22.0},
    },
    "window": {
        "type": "rectangle",
        "to_world": to_world.look_at([5, 1, 4], [0, 0, 0.8], [0, 0, 1]).scale([0.6, 2.0, 1]),
        "emitter": {"type": "area", "radiance": 9.0},
    },
    "floor": {
        "type": "rectangle",
        "to_world": to_world.scale([20, 20, 1]),
        "bsdf": {"type": "diffuse", "reflectance": 0.18},
    },
    "cylinder": {
        "type": "cylinder",
        "p0": [-2.1, 0, 0],
        "p1": [-2.1, 0, 1.8],
        "radius": 0.8,
        "bsdf": hairline,
    },
    "plate": {
        "type": "rectangle",
        "to_world": to_world.translate([0, 0, 0.95]).rotate([1, 0, 0], 62).scale(0.95),
        "bsdf": turned,
    },
    "ball": {"type": "sphere", "center": [2.1, 0, 0.95], "radius": 0.95, "bsdf": satin},
}
rows = []
for plugin in ("neural_layered", "layered"):
    for shape in ("cylinder", "plate", "ball"):
        scene[shape]["bsdf"]["type"] = plugin
    rows.append(np.array(mi.render(mi.load_dict(scene))))
mi.util.write_bitmap(str(options.folder / "anisotropy.png"), np.concatenate(rows))
