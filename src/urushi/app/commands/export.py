"""`urushi export`: a material as source code of a shader."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from urushi.files import atomic_write


@dataclass(frozen=True)
class Export:
    """Write a material as one file of source code: functions f, pdf and sample.

    The weights of the networks are literals in the file, which needs nothing else. Without a
    material, the file is for all materials: their latent codes are arguments of its functions.

    Example: urushi export lacquer.safetensors --language glsl -o lacquer.glsl

    Example: urushi export --language wgsl -o all.wgsl
    """

    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """File to write."""
    language: Annotated[
        Literal["glsl", "wgsl", "hlsl", "slang", "osl", "python"], tyro.conf.arg(aliases=["-l"])
    ]
    """Language of the file."""
    material: tyro.conf.Positional[str | None] = None
    """Material: a material file, a measured BRDF (MERL or RGL), or a description as in Python,
    such as "conductor(alpha=0.2, r0=0.9)"."""
    prefix: str = "urushi"
    """Beginning of the names of all functions and structures; Python's have none."""
    weights: str | None = None
    """Networks: base (the default), small, or a weights file."""

    def run(self) -> int:
        text = self._text()
        with atomic_write(self.output) as temporary:
            temporary.write_text(text, encoding="utf-8")
        print(self.output)
        return 0

    def _text(self) -> str:
        from urushi.app.commands.layer import read_material
        from urushi.export.program import codes_text
        from urushi.nets.weights import default_model, find

        if self.material is None:
            model = find(self.weights) if self.weights else default_model()
            return codes_text(self.language, model, self.prefix)
        return read_material(self.material, self.weights).shader(self.language, self.prefix)
