"""Writes a texture of codes: `texture.py FILE`.

Blue and clear stripes of lacquer with spots on gold, over the whole of uv.
"""

import sys

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")

import urushi  # noqa: E402, F401  (registers the plugins)

WIDTH, HEIGHT = 256, 128


def bitmap(values: np.ndarray) -> dict:
    return {"type": "bitmap", "data": mi.TensorXf(values.astype(np.float32)), "raw": True}


u, v = np.meshgrid((np.arange(WIDTH) + 0.5) / WIDTH, (np.arange(HEIGHT) + 0.5) / HEIGHT)
stripe = 0.5 + 0.5 * np.sin(2 * np.pi * (3 * u + 2 * v))[..., None]
spot = (np.sin(24 * np.pi * u) * np.sin(12 * np.pi * v) > 0.6)[..., None]
lacquer = mi.load_dict(
    {
        "type": "neural_layered",
        "alpha": bitmap(0.04 + 0.1 * stripe),
        "sigma_t": bitmap(np.where(spot, 0.05, 0.2 + 1.5 * stripe * (1.0, 0.6, 0.2))),
        "albedo": bitmap(np.where(spot, 0.0, (0.1, 0.25, 0.7) * np.ones_like(stripe))),
        "bottom": {
            "type": "roughconductor",
            "distribution": "ggx",
            "material": "Au",
            "alpha": 0.2,
        },
    }
)
lacquer.save(sys.argv[1])
