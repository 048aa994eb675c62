"""Export the material of the examples: a translucent red lacquer on rough gold.

python examples/material.py FOLDER writes material.glsl and material.osl there, with the textures
material.dds and material.exr.
"""

import sys
from pathlib import Path

import urushi
from urushi.app.export import write_table


def lacquer() -> urushi.Material:
    """The material that the examples show."""
    gold = urushi.conductor(alpha=0.3, r0=(1.0, 0.77, 0.34))
    stack = urushi.coat(gold, alpha=0.15, ior=1.5, albedo=0.5, sigma_t=(0.2, 1.0, 3.0))
    return urushi.encode(stack)


def main(folder: Path) -> None:
    """Write the shaders and their textures into a folder."""
    material = lacquer()
    for language, suffix in ("glsl", "dds"), ("osl", "exr"):
        (folder / f"material.{language}").write_text(material.shader(language), encoding="utf-8")
        write_table(folder / f"material.{suffix}", material.shader_texture(language))


if __name__ == "__main__":
    if len(sys.argv) != 2 or not Path(sys.argv[1]).is_dir():
        sys.exit("give a folder that exists: python examples/material.py FOLDER")
    main(Path(sys.argv[1]))
