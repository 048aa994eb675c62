"""`urushi convert`: materials of a MaterialX document as a Mitsuba scene."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated
from xml.sax.saxutils import quoteattr

import tyro

from urushi.app.commands.render import set_variant
from urushi.files import atomic_write, new_folder
from urushi.ranges import Texels

if TYPE_CHECKING:
    from urushi.openpbr_surface.materialx.baking import Texture
    from urushi.openpbr_surface.materialx.surface import Mix, ParameterValue, Surface

#: A sphere under even light, seen from the front.
_SCENE = """<scene version="3.0.0">
    <default name="spp" value="64"/>
    <integrator type="path"/>
    <sensor type="perspective">
        <float name="fov" value="32"/>
        <transform name="to_world">
            <lookat origin="0, 1, 4" target="0, 0, 0" up="0, 1, 0"/>
        </transform>
        <film type="hdrfilm">
            <integer name="width" value="512"/>
            <integer name="height" value="512"/>
        </film>
        <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
    </sensor>
    <emitter type="constant"><rgb name="radiance" value="0.3"/></emitter>
    <shape type="sphere">
        <point name="center" x="3" y="5" z="4"/>
        <emitter type="area"><rgb name="radiance" value="12"/></emitter>
    </shape>
{bsdf}
    <shape type="sphere"><ref id={id}/>{emitter}</shape>
</scene>
"""


@dataclass(frozen=True)
class Convert:
    """Write a material of a MaterialX document as a Mitsuba scene, with textures as OpenEXR files.

    The folder gets scene.xml, a sphere of the material, a BSDF of type openpbr, and an emitter of
    type openpbr_emission where it emits light. Colours are linear sRGB. Copy both elsewhere.

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
        folder = new_folder(self.output)
        bsdf, emitter = bsdf_xml(found, found.name, folder)
        target = folder / "scene.xml"
        with atomic_write(target) as temporary:
            scene = _SCENE.format(bsdf=bsdf, emitter=emitter, id=quoteattr(found.name))
            temporary.write_text(scene, encoding="utf-8")
        print(target)
        return 0


def bsdf_xml(found: "Surface | Mix", name: str, folder: Path) -> tuple[str, str]:
    """The material of a name as an element <bsdf>; its textures are written into the folder.

    Returns:
        The element, and the element <emitter> of what it emits, empty if nothing.

    Raises:
        FileError: the folder cannot be written.
    """
    from urushi.openpbr_surface.inputs import EMISSION
    from urushi.openpbr_surface.materialx.surface import Mix
    from urushi.openpbr_surface.plugins.emission import NAMES

    if isinstance(found, Mix):
        parts = [bsdf_xml(found.bg, f"{name}-bg", folder), bsdf_xml(found.fg, f"{name}-fg", folder)]
        weight = _value_xml(name, "weight", found.weight, folder)
        inside = "\n".join((f"        {weight}", *(part for part, _ in parts)))
        return f'    <bsdf type="blendbsdf" id={quoteattr(name)}>\n{inside}\n    </bsdf>', ""
    lines = {key: _value_xml(name, key, x, folder) for key, x in found.values.items()}
    inside = "".join(f"\n        {x}" for key, x in lines.items() if key not in EMISSION)
    bsdf = f'    <bsdf type="openpbr" id={quoteattr(name)}>{inside}\n    </bsdf>'
    if found.values.get("emission_luminance", 0.0) == 0.0:
        return bsdf, ""
    light = "".join(f"\n            {x}" for key, x in lines.items() if key in NAMES)
    return bsdf, f'\n        <emitter type="openpbr_emission">{light}\n        </emitter>\n    '


def _value_xml(material: str, name: str, value: "ParameterValue", folder: Path) -> str:
    """The element of a parameter."""
    from urushi.openpbr_surface.materialx.baking import Texture

    if isinstance(value, Texture):
        return _texture_xml(material, name, value, folder)
    if isinstance(value, bool):
        return f'<boolean name="{name}" value="{str(value).lower()}"/>'
    if isinstance(value, tuple):
        numbers = " ".join(repr(number) for number in value)
        return f'<rgb name="{name}" value="{numbers}"/>'
    return f'<float name="{name}" value="{value!r}"/>'


def _texture_xml(material: str, name: str, texture: "Texture", folder: Path) -> str:
    import mitsuba as mi
    import numpy as np

    from urushi.openpbr_surface.plugins.materialx import filter_type, is_raw

    file = "textures/" + re.sub(r"[^A-Za-z0-9_-]", "_", f"{material[:60]}-{name}") + ".exr"
    new_folder(folder / "textures")
    with atomic_write(folder / file) as temporary:
        mi.Bitmap(np.ascontiguousarray(texture.pixels)).write(str(temporary))
    four = np.eye(4)  # as Mitsuba reads it from XML: the translation in the last column
    four[:2, :2], four[:2, 3] = texture.to_uv[:2, :2], texture.to_uv[:2, 2]
    matrix = " ".join(repr(float(x)) for x in four.ravel())
    parts = (
        f'<texture type="bitmap" name="{name}">',
        f'    <string name="filename" value="{file}"/>',
        f'    <boolean name="raw" value="{str(is_raw(name)).lower()}"/>',
        f'    <string name="wrap_mode" value="{texture.wrap}"/>',
        f'    <string name="filter_type" value="{filter_type(texture)}"/>',
        f'    <transform name="to_uv"><matrix value="{matrix}"/></transform>',
        "</texture>",
    )
    return "\n        ".join(parts)
