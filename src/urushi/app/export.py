"""`urushi export`: a material as source code of a shader."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from urushi.errors import ParameterError
from urushi.files import atomic_write, tensor_file_kind


@dataclass(frozen=True)
class Export:
    """Write a material as one file of source code: functions f, pdf and sample.

    The weights of the networks are literals in the file, which needs nothing else. Without a
    material, the file is for all materials: their latent codes are arguments of its functions.

    A latent texture, as written by the method `save` of a plugin, becomes such a file with a
    texture look-up, and a texture file for graphics hardware.

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
    """Texture file to write (.dds or .ktx2), with all mip levels that the texture has."""
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
        if self.texture is not None:
            raise ParameterError(
                "only latent textures become texture files; give one, or leave out --texture"
            )
        if self.material is None:
            return codes_text(self.language, find(self.weights), self.prefix)
        return read_material(self.material, self.weights).shader(self.language, self.prefix)

    def _textured_text(self) -> str:
        """The text for a texture, which is written."""
        from urushi.export.program import codes_text
        from urushi.nets.weights import find
        from urushi.textures import file, gpu

        writers = {".dds": gpu.dds, ".ktx2": gpu.ktx2}
        writer = None if self.texture is None else writers.get(self.texture.suffix)
        if self.texture is None or writer is None:
            raise ParameterError(
                f"'{self.material}' is a texture; name the texture file to write, .dds or .ktx2, "
                "by --texture"
            )
        given = None if self.weights is None else find(self.weights)
        store, grid, model = file.read(str(self.material), given)
        text = codes_text(self.language, model, self.prefix, gpu.texels(store, grid))
        with atomic_write(self.texture) as temporary:
            temporary.write_bytes(writer(store))
        print(self.texture)
        return text
