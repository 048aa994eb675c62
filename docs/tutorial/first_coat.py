"""The code of the tutorial "Your first coat": python first_coat.py [FOLDER] [--size N] [--spp N]

Renders the tutorial's pictures into FOLDER, by default the working folder.
"""

import argparse
from pathlib import Path

# [start]
import mitsuba as mi

import urushi

mi.set_variant("llvm_ad_rgb")  # or "cuda_ad_rgb"
# [end start]

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("folder", type=Path, nargs="?", default=Path())
parser.add_argument("--size", type=int, default=320, help="width and height [pixels]")
parser.add_argument("--spp", type=int, default=128, help="samples per pixel")
arguments = parser.parse_args()
folder, size, spp = arguments.folder, arguments.size, arguments.spp

# [scene]
T = mi.ScalarTransform4d


def softbox(origin, scale, radiance):
    """A rectangle of light that looks at the ball."""
    to_ball = T().look_at(origin=origin, target=[0, 0, 1], up=[0, 0, 1])
    return {
        "type": "rectangle",
        "to_world": to_ball.scale(scale),
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": radiance}},
    }


def render(bsdf, name):
    """Render a ball of this material on a floor."""
    view = T().look_at(origin=[0, -9, 3.2], target=[0, 0, 0.95], up=[0, 0, 1])
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 6},
            "camera": {
                "type": "perspective",
                "fov": 17,
                "to_world": view,
                "film": {"type": "hdrfilm", "width": size, "height": size},
                "sampler": {"type": "independent", "sample_count": spp},
            },
            "sky": {"type": "constant", "radiance": 0.25},
            "key": softbox([-4, -4, 5], 1.8, [14, 13, 12]),
            "strip": softbox([5, -1, 3], [0.6, 2, 1], [10, 12, 14]),
            "floor": {"type": "disk", "to_world": T().scale(50)},
            "ball": {"type": "sphere", "center": [0, 0, 1], "bsdf": bsdf},
        }
    )
    mi.util.write_bitmap(str(folder / name), mi.render(scene), write_async=False)


# [end scene]

# [metal]
copper = {
    "type": "roughconductor",
    "material": "Cu",
    "distribution": "ggx",
    "alpha": 0.25,
}
render(copper, "metal.png")
# [end metal]

# [clear]
clear = {
    "type": "neural_layered",
    "alpha": 0.02,
    "bottom": copper,
}
render(clear, "clear.png")
# [end clear]

# [tinted]
tinted = {
    "type": "neural_layered",
    "alpha": 0.02,
    "sigma_t": {"type": "rgb", "value": [0.1, 0.6, 0.3]},
    "bottom": copper,
}
render(tinted, "tinted.png")
# [end tinted]

# [milky]
milky = {
    "type": "neural_layered",
    "alpha": 0.02,
    "albedo": {"type": "rgb", "value": [0.3, 0.9, 0.8]},
    "sigma_t": 1.5,
    "bottom": copper,
}
render(milky, "milky.png")
# [end milky]

# [texture]
checks = {
    "type": "checkerboard",
    "color0": 0.02,
    "color1": 0.4,
    "to_uv": T().scale([8, 4, 1]),
}
render({**tinted, "alpha": checks}, "texture.png")
# [end texture]

# [nested]
inner = {**milky, "alpha": 0.3, "int_ior": 1.6}
outer = {
    "type": "neural_layered",
    "alpha": 0.01,
    "int_ior": 1.4,
    "bottom": inner,
}
render(outer, "nested.png")
# [end nested]

# [reference]
render({**milky, "type": "layered"}, "reference.png")
# [end reference]

# [python]
copper = urushi.conductor(alpha=0.25, r0=(0.96, 0.64, 0.54))
material = urushi.encode(copper)
lacquer = urushi.layer(
    urushi.dielectric(alpha=0.02, eta=1.5), material, albedo=(0.3, 0.9, 0.8), sigma_t=1.5
)
lacquer.save(folder / "lacquer.safetensors")
# [end python]

# [saved]
saved = {
    "type": "neural_brdf",
    "filename": str(folder / "lacquer.safetensors"),
}
render(saved, "saved.png")
# [end saved]
