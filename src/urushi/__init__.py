"""Urushi: layered materials in a neural latent space, for Mitsuba 3.

Importing this package chooses a libLLVM that Dr.Jit can use and registers the Mitsuba plugins
`layered`, `neural_layered`, `neural_brdf` and `measured_brdf`; everything else is loaded when it is
first used.
"""

import importlib
from typing import TYPE_CHECKING, Any

from urushi import backend

if TYPE_CHECKING:
    from urushi.material.encode import encode
    from urushi.material.layer import layer
    from urushi.material.lerp import lerp
    from urushi.material.material import Material, load
    from urushi.measured import load_measured
    from urushi.reference.simulate import simulate
    from urushi.reference.stack import Stack, coat, conductor, dielectric, diffuse

__version__ = "0.1.0"

__all__ = [
    "Material",
    "Stack",
    "coat",
    "conductor",
    "dielectric",
    "diffuse",
    "encode",
    "layer",
    "lerp",
    "load",
    "load_measured",
    "simulate",
]

_HOME = {
    "coat": "urushi.reference",
    "conductor": "urushi.reference",
    "dielectric": "urushi.reference",
    "diffuse": "urushi.reference",
    "simulate": "urushi.reference",
    "Stack": "urushi.reference",
    "encode": "urushi.material",
    "layer": "urushi.material",
    "lerp": "urushi.material",
    "load": "urushi.material",
    "Material": "urushi.material",
    "load_measured": "urushi.measured",
}


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'urushi' has no attribute '{name}'")
    backend.require_drjit()
    value = getattr(importlib.import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])


backend.choose_llvm()
if backend.missing_library() is None:  # else Mitsuba cannot be imported, as `urushi doctor` says
    importlib.import_module("urushi.render.register").register()
