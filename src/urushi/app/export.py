"""`urushi export` and `convert`: shader code of materials, and scenes of MaterialX documents."""

import itertools
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
import tyro

from urushi.app.render import set_variant
from urushi.errors import ParameterError
from urushi.files import atomic_write, new_folder, tensor_file_kind
from urushi.ranges import Texels

if TYPE_CHECKING:
    from urushi.openpbr_surface.materialx.reader import Mix, Surface
    from urushi.textures.gpu import Image


@dataclass(frozen=True)
class Export:
    """Write a material as one file of source code: functions f, pdf and sample.

    The weights of the networks are literals in the file, which needs nothing else. Without a
    material, the file is for all materials: their latent codes are arguments of its functions.

    A latent texture, as written by the method `save` of a plugin, becomes a file with a texture
    look-up, and a texture file for graphics hardware. So does a material with a table, as
    of a measured BRDF; without --texture, its f is computed from its codes.

    Example: urushi export lacquer.safetensors --language glsl -o lacquer.glsl

    Example: urushi export shoe.safetensors -l hlsl -o shoe.hlsl --texture shoe.dds

    Example: urushi export --language wgsl -o all.wgsl
    """

    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """File to write."""
    language: Annotated[
        Literal["glsl", "wgsl", "hlsl", "slang", "osl", "python"], tyro.conf.arg(aliases=["-l"])
    ]
    """Language of the file."""
    material: tyro.conf.Positional[str | None] = None
    """Material: a material file, a latent texture, a measured BRDF (MERL or RGL), or a
    description as in Python, such as "conductor(alpha=0.2, r0=0.9)"."""
    texture: Path | None = None
    """Texture file to write (.dds or .ktx2): a latent texture with its mip levels, or the
    table of a material."""
    prefix: str = "urushi"
    """Beginning of the names of all functions and structures; Python's have none."""
    weights: str | None = None
    """Weights file of the networks. Default: the shipped ones."""

    def run(self) -> int:
        text = self._text()
        with atomic_write(self.output) as temporary:
            temporary.write_text(text, encoding="utf-8")
        print(self.output)
        return 0

    def _text(self) -> str:
        from urushi.app.encode import read_material
        from urushi.export.program import codes_text
        from urushi.nets.weights import find

        if self.material is not None and tensor_file_kind(self.material) == "texture":
            return self._textured_text()
        material = None if self.material is None else read_material(self.material, self.weights)
        table = None if material is None else material.table
        if self.texture is not None and table is None:
            raise ParameterError(
                "only latent textures and tables of materials become texture files; give one, or "
                "leave out --texture"
            )
        if material is None:
            return codes_text(self.language, find(self.weights), self.prefix)
        if table is None or self.texture is None:
            return material.shader(self.language, self.prefix)
        from urushi.textures import gpu

        text = material.shader(self.language, self.prefix, table=True)
        self._write_texture(gpu.table_image(table))
        return text

    def _textured_text(self) -> str:
        """The text for a texture, which is written."""
        from urushi.export.program import codes_text
        from urushi.nets.weights import find
        from urushi.textures import gpu
        from urushi.textures.store import read_texture

        given = None if self.weights is None else find(self.weights)
        store, grid, model = read_texture(str(self.material), given)
        text = codes_text(self.language, model, self.prefix, gpu.texels(store, grid))
        self._write_texture(gpu.texture_image(store))
        return text

    def _write_texture(self, image: "Image") -> None:
        from urushi.textures import gpu

        writers = {".dds": gpu.dds, ".ktx2": gpu.ktx2}
        if self.texture is None or self.texture.suffix not in writers:
            raise ParameterError(
                f"'{self.material}' has a texture; name the texture file to write, .dds or .ktx2, "
                "by --texture"
            )
        with atomic_write(self.texture) as temporary:
            temporary.write_bytes(writers[self.texture.suffix](image))
        print(self.texture)


@dataclass(frozen=True)
class Convert:
    """Write a material of a MaterialX document as a Mitsuba scene, with textures as OpenEXR files.

    The folder gets scene.xml, a sphere of the material: a BSDF of type openpbr, an emitter of type
    openpbr_emission where it emits light, and the medium inside if it transmits light. Colours
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
        from urushi.openpbr_surface.plugins.materialx import check_supported, read

        found = read(self.document, self.material, self.resolution, self.uv_plane)
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
    from urushi.openpbr_surface.materialx.reader import Mix
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
