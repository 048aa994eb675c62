"""The code of the page "Textures": python textures.py [FOLDER]; files are written to FOLDER."""

import sys
from pathlib import Path

import mitsuba as mi
import numpy as np

import urushi  # noqa: F401 (registers the plugins)

mi.set_variant("llvm_ad_rgb")

folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path()
texels = np.random.default_rng(0).random((8, 8, 3), np.float32)
lacquer = {
    "type": "neural_layered",
    "albedo": {"type": "bitmap", "bitmap": mi.Bitmap(texels), "raw": True},
    "sigma_t": 1.0,
    "bottom": {"type": "diffuse"},
}
scene = mi.load_dict({"type": "scene", "object": {"type": "sphere", "bsdf": lacquer}})
pixels = mi.TensorXf(1 - texels)
path = str(folder / "lacquer.safetensors")

# [edit]
parameters = mi.traverse(scene)
parameters["object.bsdf.albedo.data"] = pixels
parameters.update()
# [end edit]

# [save]
scene.shapes()[0].bsdf().save(path)
saved = mi.load_dict({"type": "neural_brdf", "filename": path})
# [end save]

print(saved)
