"""The scene "violin": spruce and flamed maple under amber varnish, described by OpenPBR.

The varnish is a coat of OpenPBR; its colour follows its depth, which is worn at the edges.
"""

from typing import Any

import mitsuba as mi
import numpy as np

from gallery import stage
from gallery import violin_fittings as fittings
from gallery import violin_wood as wood
from gallery.options import Options
from gallery.solids import merged
from gallery.stage import Folder, Light
from gallery.violin_shape import RIBS, Arching, plate

#: Texels along the body.
TEXELS = 640

#: Colour of the varnish at depth one: of light that passes it twice.
AMBER = np.array([0.93, 0.56, 0.17])

#: Heights of the arches of belly and back above the ribs.
BELLY, BACK = 15.5, 14.5


def violin(folder: Folder, options: Options) -> dict[str, Any]:
    """Describe the scene for `mi.load_dict`; its files are written into `folder`."""
    belly, back = Arching(BELLY), Arching(BACK)
    rows = options.texels(TEXELS)
    black = options.openpbr(
        base_color=stage.rgb(0.012, 0.010, 0.009), specular_roughness=0.32, specular_ior=1.55
    )
    spruce = _varnished(folder, options, "spruce", *wood.spruce(belly, rows))
    maple = _varnished(folder, options, "maple", *wood.flamed_maple(back, rows))
    meshes = {
        "belly": (plate(belly, holes=True), spruce),
        "maple": (wood.maple_parts(back), maple),
        "ebony": (merged(fittings.ebony_parts()), black),
        "bridge": (
            fittings.bridge(belly),
            options.openpbr(base_color=stage.rgb(0.62, 0.40, 0.19), specular_roughness=0.5),
        ),
        "metal": (
            merged(fittings.metal_parts(belly)),
            options.openpbr(
                base_metalness=1.0, base_color=stage.rgb(0.56, 0.55, 0.53), specular_roughness=0.3
            ),
        ),
    }
    parts: dict[str, Any] = {
        "surround": stage.surround(
            folder,
            zenith=(0.22, 0.24, 0.28),
            horizon=(0.16, 0.155, 0.15),
            ground=(0.06, 0.055, 0.05),
            lights=[
                Light((-5.0, 3.5, 5.0), (0.22, 0.40), (8.5, 8.2, 7.7)),
                Light((-1.3, 5.0, 4.2), (0.08, 0.45), (6.5, 6.5, 6.3)),
                Light((5.5, -3.0, 4.0), (0.16, 0.40), (6.0, 6.5, 7.4)),
            ],
        ),
        "table": stage.table(80.0, 0.075, 0.090, 0.105),
    }
    transform = mi.ScalarTransform4d()
    placed = transform.rotate([0, 0, 1], -49).scale(0.01).translate([0, -290, RIBS + BACK + 0.5])
    for name, (mesh, bsdf) in meshes.items():
        parts[name] = folder.mesh(name, mesh) | {"to_world": placed, "bsdf": bsdf}
    view = stage.camera(options, (-0.38, -7.6, 6.9), (-0.38, -0.24, 0.1), 32)
    return stage.scene(view, parts)


def _varnished(
    folder: Folder, options: Options, name: str, color: np.ndarray, depth: np.ndarray
) -> dict[str, Any]:
    """Wood of a colour (H, W, 3) under varnish of a depth (H, W)."""
    return options.openpbr(
        base_color=folder.texture(f"{name}-color", color),
        specular_roughness=0.5,
        coat_weight=1.0,
        coat_color=folder.texture(f"{name}-varnish", AMBER ** depth[..., None]),
        coat_roughness=0.14,
        coat_ior=1.53,
    )
