"""Export the material of the examples: a translucent red lacquer on rough gold.

python examples/material.py FOLDER writes material.glsl and material.osl there.
"""

import sys
from pathlib import Path

import urushi


def lacquer() -> urushi.Material:
    """The material that the examples show."""
    gold = urushi.conductor(alpha=0.3, r0=(1.0, 0.77, 0.34))
    stack = urushi.coat(gold, alpha=0.15, ior=1.5, albedo=0.5, sigma_t=(0.2, 1.0, 3.0))
    return urushi.encode(stack)


def main(folder: Path) -> None:
    """Write the shaders into a folder."""
    material = lacquer()
    for language in "glsl", "osl":
        (folder / f"material.{language}").write_text(material.shader(language), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 2 or not Path(sys.argv[1]).is_dir():
        sys.exit("give a folder that exists: python examples/material.py FOLDER")
    main(Path(sys.argv[1]))
