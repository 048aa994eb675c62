"""`urushi export` and `convert`: shader code of materials, and scenes of MaterialX documents."""

import itertools
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
import tyro

from urushi.app.render import set_variant
from urushi.errors import FileError, ParameterError
from urushi.files import atomic_write, new_folder, tensor_file_kind
from urushi.ranges import Texels

if TYPE_CHECKING:
    from urushi.openpbr_surface.materialx.surface import Mix, Surface
    from urushi.textures.gpu import Image


#: Formats of the texture files that a language reads, the default first.
SUFFIXES = {"osl": (".exr",), "python": (".npy",)}
GPU_SUFFIXES = (".dds", ".ktx2")


@dataclass(frozen=True)
class Export:
    """Write a material as source code, functions f, pdf and sample, and the texture that f reads.

    The texture holds the BRDF without its topmost lobe: a 3D texture for graphics hardware, an
    image for OSL, an array for NumPy. Without a material, the files are for all materials: their
    latent codes are arguments of the functions. So are the files of a latent texture, as
    written by the method `save` of a plugin; its codes are a further texture.

    Example: urushi export lacquer.safetensors --language glsl -o lacquer.glsl

    Example: urushi export shoe.safetensors -l hlsl -o shoe.hlsl --texture shoe.ktx2

    Example: urushi export --language wgsl -o all.wgsl
    """

    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """File of source code to write."""
    language: Annotated[
        Literal["glsl", "wgsl", "hlsl", "slang", "osl", "python"], tyro.conf.arg(aliases=["-l"])
    ]
    """Language of the file."""
    material: tyro.conf.Positional[str | None] = None
    """Material: a material file, a latent texture, a measured BRDF (MERL or RGL), a BSDF of a
    Mitsuba scene file, SCENE.xml#ID, or a description as in Python, such as
    "conductor(alpha=0.2, r0=0.9)"."""
    texture: Path | None = None
    """Texture file to write: .dds or .ktx2, .exr for OSL, .npy for Python. The codes of a
    latent texture are in the same place with "-codes" in the name. Default: as the output."""
    prefix: str = "urushi"
    """Beginning of the names of all functions and structures; Python's have none."""
    weights: str | None = None
    """Weights file. Default: the shipped ones."""

    def run(self) -> int:
        path = self._texture_path()
        text, table, codes = self._exported()
        written = [self.output]
        with atomic_write(self.output) as temporary:  # no code without its textures
            temporary.write_text(text, encoding="utf-8")
            if table is not None:
                write_table(path, table)
                written.append(path)
            if codes is not None:
                written.append(path.with_stem(f"{path.stem}-codes"))
                _write_image(written[-1], codes)
        print(*written, sep="\n")
        return 0

    def _texture_path(self) -> Path:
        if self.output.is_dir():
            raise FileError(f"cannot write '{self.output}': it is a folder; choose another name")
        suffixes = SUFFIXES.get(self.language, GPU_SUFFIXES)
        path = self.output.with_suffix(suffixes[0]) if self.texture is None else self.texture
        if path.suffix not in suffixes:
            raise ParameterError(
                f"exported {self.language} code reads no texture files '{path.suffix}'; give a "
                f"name with {' or '.join(suffixes)}"
            )
        if path == self.output:
            raise ParameterError(f"the texture would replace the code in '{path}'; name one anew")
        return path

    def _exported(self) -> "tuple[str, np.ndarray | None, Image | None]":
        """The source code, the texture of the table or of the basis, and that of codes."""
        from urushi.app.encode import read_material
        from urushi.export.program import codes_text, texture_form
        from urushi.export.rest import basis_texture
        from urushi.nets.weights import find
        from urushi.textures import gpu
        from urushi.textures.store import read_texture

        texels = codes = None
        if self.material is None:
            model = find(self.weights)
        elif tensor_file_kind(self.material) == "texture":
            given = None if self.weights is None else find(self.weights)
            store, grid, model = read_texture(self.material, given)
            texels, codes = gpu.texels(store), gpu.texture_image(store, grid)
        else:
            material = read_material(self.material, self.weights)
            texture = material.shader_texture(self.language)
            return material.shader(self.language, self.prefix), texture, None
        text = codes_text(self.language, model, self.prefix, texels)
        return text, basis_texture(model, texture_form(self.language)), codes


def write_table(path: Path, table: np.ndarray) -> None:
    """Write a texture as of `Material.shader_texture` in the format of the file's name."""
    from urushi.textures.gpu import Image

    if path.suffix in GPU_SUFFIXES:
        _write_image(path, Image(table, is_volume=True))
        return
    set_variant("scalar_rgb")  # enough for images, and needs no LLVM
    import mitsuba as mi

    with atomic_write(path) as temporary:
        if path.suffix == ".npy":
            np.save(temporary, table)
        else:
            mi.Bitmap(table).write(str(temporary))


def _write_image(path: Path, image: "Image") -> None:
    from urushi.textures import gpu

    content = {".dds": gpu.dds, ".ktx2": gpu.ktx2}[path.suffix](image)
    with atomic_write(path) as temporary:
        temporary.write_bytes(content)


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
        from urushi.openpbr_surface.materialx.surface import read_surface
        from urushi.openpbr_surface.plugins.materialx import check_supported

        found = read_surface(self.document, self.material, self.resolution, self.uv_plane)
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
    parts = {
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
    }
    name += "_material" * (name in (*parts, "object"))
    parts[name] = shape["bsdf"]
    return parts | {"object": shape | {"bsdf": {"type": "ref", "id": name}}}


def xml(description: dict[str, Any]) -> str:
    """A scene for `mi.load_dict` as Mitsuba's XML, with the parameters $spp, $width and $height."""
    import mitsuba as mi

    from urushi.mitsuba.register import PLUGINS

    state = mi.parser.parse_dict(mi.parser.ParserConfig(mi.variant()), description)
    nodes = state.nodes
    for node in nodes:
        if node.props.plugin_name() in (*PLUGINS.bsdfs, "openpbr"):
            node.type = mi.ObjectType.BSDF  # Mitsuba does not know the type of plugins in Python
    state.nodes = nodes
    text = mi.parser.write_string(state)
    for written, name in (("resx", "width"), ("resy", "height")):  # as Mitsuba names them
        text = text.replace(f'name="{written}"', f'name="{name}"')
        text = text.replace(f'"${written}"', f'"${name}"')
    return re.sub(r"-?\d+\.\d{13,}(e-?\d+)?", lambda number: f"{float(number[0]):.12g}", text)
