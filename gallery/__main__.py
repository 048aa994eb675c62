"""Write a scene of the gallery into a folder: scene.xml with its meshes and textures.

Example: python -m gallery still-life out/still-life
"""

from pathlib import Path
from typing import Annotated, Literal

import mitsuba as mi
import tyro

from gallery.export import export
from gallery.options import Options
from gallery.scenes import SCENES


def main(
    scene: tyro.conf.Positional[Literal[tuple(SCENES)]],  # type: ignore[valid-type]
    folder: tyro.conf.Positional[Path],
    options: Annotated[Options, tyro.conf.OmitArgPrefixes],
) -> None:
    """Write a scene of the gallery; `urushi render FOLDER/scene.xml` renders it.

    Args:
        scene: its name.
        folder: to write to; made if it is missing.
        options: of the scene.
    """
    mi.set_variant("scalar_rgb")  # enough for describing a scene, and needs no LLVM
    print(export(SCENES[scene], folder, options))


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
