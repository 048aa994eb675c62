"""Urushi: layered materials by light transport and latent codes, for Mitsuba 3.

Importing this package chooses a libLLVM that Dr.Jit can use and registers the Mitsuba plugins
`layered`, `neural_layered`, `neural_brdf`, `measured_brdf`, `openpbr` and `materialx`; everything
else is loaded when it is first used.
"""

import importlib
from typing import TYPE_CHECKING, Any

from urushi import platform

if TYPE_CHECKING:
    from urushi.app.notebook import show
    from urushi.material.encode import encode
    from urushi.material.layer import layer
    from urushi.material.lerp import lerp
    from urushi.material.material import Material, load
    from urushi.measured import load_measured, pigment
    from urushi.openpbr_surface.description import OpenPBR, openpbr, save_materialx
    from urushi.openpbr_surface.plugins.materialx import load_materialx
    from urushi.walk import Stack, coat, conductor, dielectric, diffuse, slab
    from urushi.walk.simulate import simulate

__version__ = "0.2.0.dev0"

__all__ = [
    "Material",
    "OpenPBR",
    "Stack",
    "__version__",
    "coat",
    "conductor",
    "dielectric",
    "diffuse",
    "encode",
    "layer",
    "lerp",
    "load",
    "load_materialx",
    "load_measured",
    "openpbr",
    "pigment",
    "save_materialx",
    "show",
    "simulate",
    "slab",
]

#: Where the public names are found.
_MODULES = (
    *("app.notebook", "material", "measured", "openpbr_surface.description"),
    *("openpbr_surface.plugins.materialx", "walk"),
)

if not TYPE_CHECKING:  # to a type checker, a module with __getattr__ has every name

    def __getattr__(name: str) -> Any:
        """Load the public names when one of them is first used: they start Dr.Jit."""
        if name not in __all__:
            raise AttributeError(f"module 'urushi' has no attribute '{name}'")
        platform.require_drjit()
        for place in _MODULES:
            found = vars(importlib.import_module(f"urushi.{place}"))
            globals().update({label: found[label] for label in __all__ if label in found})
        globals()["Material"]._repr_png_ = _picture
        return globals()[name]


def _picture(material: "Material") -> bytes | None:
    """The picture (PNG) by which IPython and Jupyter show a material of one or three channels."""
    from urushi.app.notebook import png

    return png(material) if material.channels in (1, 3) else None


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])


platform.choose_llvm()
if platform.missing_library() is None:  # else Mitsuba cannot be imported, as `urushi doctor` says
    from urushi.mitsuba import register
    from urushi.openpbr_surface import plugins

    register.register(register.PLUGINS, plugins.PLUGINS)
