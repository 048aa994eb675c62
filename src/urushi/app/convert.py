"""`urushi convert`: MaterialX documents as scenes of Mitsuba."""

import itertools
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import tyro

from urushi.app.render import set_variant
from urushi.files import atomic_write, new_folder
from urushi.ranges import Texels

if TYPE_CHECKING:
    from urushi.openpbr_surface.materialx.surface import Mix, Surface


@dataclass(frozen=True)
class Convert:
    """Write a material of a MaterialX document as a Mitsuba scene, with textures as OpenEXR files.

    The folder gets scene.xml, a sphere of the material: a BSDF of type openpbr, an emitter of type
    openpbr_emission where it emits light, and the medium inside of what transmits light. Colours
    are linear sRGB. Copy both elsewhere.

    Example: urushi convert car_paint.mtlx -o out/car_paint
    """

    document: tyro.conf.Positional[Path]
    """MaterialX document (.mtlx)."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Folder to write to. It is created if it is missing."""
    material: str | None = None
    """Name of the material. Default: the document's only one."""
    resolution: Texels = 1024
    """Rows and columns of textures that are computed from patterns, at most 4096."""

    uv_plane: bool = False
    """Take patterns in space on the plane (u, v, 0) of the texture coordinates."""

    def run(self) -> int:
        set_variant("scalar_rgb")  # enough for images, and needs no LLVM
        from urushi.openpbr_surface.materialx.surface import read_surface
        from urushi.openpbr_surface.plugins.materialx import (
            check_supported,
            checked_resolution,
            decode,
        )

        resolution = checked_resolution(self.resolution)
        found = read_surface(self.document, decode, self.material, resolution, self.uv_plane)
        check_supported(found)
        target = new_folder(self.output) / "scene.xml"
        with atomic_write(target) as temporary:
            temporary.write_text(xml(scene(found, self.output)), encoding="utf-8")
        print(target)
        return 0


def scene(found: "Surface | Mix", folder: Path) -> dict[str, Any]:
    """A sphere of a material under even light, seen from the front.

    Textures are written into the folder, which file names are relative to.
    """
    import mitsuba as mi

    from urushi.openpbr_surface.description import OpenPBR, openpbr
    from urushi.openpbr_surface.materialx.surface import Mix
    from urushi.openpbr_surface.plugins.materialx import description

    numbers = itertools.count(1)

    def stored(name: str, pixels: np.ndarray) -> dict[str, Any]:
        file = f"textures/{name}-{next(numbers)}.exr"
        new_folder(folder / "textures")
        with atomic_write(folder / file) as temporary:
            mi.Bitmap(pixels).write(str(temporary))
        return {"filename": file}

    shape: dict[str, Any] = {"type": "sphere", "bsdf": description(found, stored=stored)}
    if not isinstance(found, Mix):
        shape = OpenPBR(openpbr(**shape["bsdf"]).parameters).on({"type": "sphere"})
    name = re.sub(r"[^A-Za-z0-9_-]", "_", found.name)
    return {
        "type": "scene",
        "integrator": {"type": "volpath" if "interior" in shape else "path"},
        "sensor": {
            "type": "perspective",
            "fov": 32.0,
            "to_world": mi.ScalarTransform4f().look_at([0, 1, 4], [0, 0, 0], [0, 1, 0]),
            "film": {"type": "hdrfilm", "width": 512, "height": 512},
            "sampler": {"type": "independent", "sample_count": 64},
        },
        "sky": {"type": "constant", "radiance": 0.3},
        "lamp": {
            "type": "sphere",
            "center": [3, 5, 4],
            "emitter": {"type": "area", "radiance": 12.0},
        },
        name: shape["bsdf"],
        "object": shape | {"bsdf": {"type": "ref", "id": name}},
    }


def xml(description: dict[str, Any]) -> str:
    """A scene for `mi.load_dict` as Mitsuba's XML, with the parameters $spp, $width and $height."""
    import mitsuba as mi

    from urushi.mitsuba.register import ROOM

    state = mi.parser.parse_dict(mi.parser.ParserConfig(mi.variant()), description)
    nodes = state.nodes
    for node in nodes:
        if node.props.plugin_name() in (*ROOM.bsdfs, "openpbr"):
            node.type = mi.ObjectType.BSDF  # Mitsuba does not know the type of plugins in Python
    state.nodes = nodes
    text = mi.parser.write_string(state)
    for written, name in (("resx", "width"), ("resy", "height")):  # as Mitsuba names them
        text = text.replace(f'name="{written}"', f'name="{name}"')
        text = text.replace(f'"${written}"', f'"${name}"')
    return re.sub(r"-?\d+\.\d{13,}(e-?\d+)?", lambda number: f"{float(number[0]):.12g}", text)
