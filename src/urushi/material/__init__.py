"""Materials as latent codes: encode a BRDF, coat it, blend it, evaluate and sample it in NumPy."""

from urushi.material.encode import encode
from urushi.material.layer import layer
from urushi.material.lerp import lerp
from urushi.material.material import Material, load

__all__ = ["Material", "encode", "layer", "lerp", "load"]
