"""`urushi scenes`: the shipped scenes as folders, to look into and to change."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro


@dataclass(frozen=True)
class Export:
    """Write a shipped scene into a folder: scene.xml, and the meshes and textures that it names.

    The scenes are still-life, globe, teapot and shoe. `urushi render FOLDER/scene.xml` renders
    what was written.

    Example: urushi scenes export still-life out/still-life
    """

    scene: tyro.conf.Positional[str]
    """Name of the scene."""
    folder: tyro.conf.Positional[Path]
    """Folder to write to; made where it is missing."""
    coat: Literal["neural_layered", "layered"] = "neural_layered"
    """Plugin of the coats; the file's parameter $coat overrides it."""
    weights: str = "base"
    """Networks of neural_layered: base, small or a weights file."""
    detail: float = 1.0
    """Scale of the sizes of textures."""

    def run(self) -> int:
        from urushi.app.commands.render import set_variant

        set_variant("scalar_rgb")  # describes a scene as well as any, and needs no LLVM
        from urushi.render.scenes import shipped
        from urushi.render.scenes.stage import Options

        options = Options(coat=self.coat, weights=self.weights, detail=self.detail)
        print(shipped.export(self.scene, self.folder, options))
        return 0


@dataclass(frozen=True)
class List:
    """Print the shipped scenes' names and what they show.

    Example: urushi scenes list
    """

    def run(self) -> int:
        from urushi.render.scenes import shipped

        for name, make in shipped.SCENES.items():
            subject = (sys.modules[make.__module__].__doc__ or "").splitlines()[0]
            print(f"{name:12}{subject.partition(': ')[2]}")
        return 0


@dataclass(frozen=True)
class Scenes:
    """The scenes that ship with Urushi, made by code.

    Example: urushi scenes export still-life out/still-life
    """

    command: (
        Annotated[Export, tyro.conf.subcommand("export")]
        | Annotated[List, tyro.conf.subcommand("list")]
    )

    def run(self) -> int:
        return self.command.run()
