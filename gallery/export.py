"""Scenes as dictionaries for `mi.load_dict`, or as folders with an XML file."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gallery.options import Options
from gallery.stage import Folder
from urushi.app.export import xml
from urushi.files import atomic_write

#: A scene: a function that writes meshes and textures into a folder, and describes the scene.
Scene = Callable[[Folder, Options], dict[str, Any]]


def build(
    scene: Scene, folder: str | os.PathLike, options: Options | None = None
) -> dict[str, Any]:
    """Describe a scene; its meshes and textures are written into a folder.

    Args:
        scene: one of `gallery.scenes.SCENES`, or any other.
        folder: for these files; made if it is missing.
        options: see `Options`.

    Returns:
        The scene for `mi.load_dict`, in the current variant.

    Raises:
        FileError: the folder cannot be written.
        ParameterError: an option is unknown or out of range.
    """
    options = options or Options()
    options.check()
    return scene(Folder(Path(folder)), options)


def export(scene: Scene, folder: str | os.PathLike, options: Options | None = None) -> Path:
    """Write a scene as a self-contained folder: `scene.xml`, meshes and textures.

    The options `coat`, `spp`, `width` and `height` are parameters of the XML file: $coat, ...

    Returns:
        The path of `scene.xml`.

    Raises:
        FileError, ParameterError: as of `build`.
    """
    options = options or Options()
    description = _relative(build(scene, folder, options), Path(folder).resolve())
    target = Path(folder) / "scene.xml"
    with atomic_write(target) as temporary:
        temporary.write_text(_xml(description, options.coat))
    return target


def _relative(node: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The description with all file names relative to `folder`."""
    result = {}
    for key, value in node.items():
        if isinstance(value, dict):
            value = _relative(value, folder)
        elif key == "filename":
            value = str(Path(value).relative_to(folder))
        result[key] = value
    return result


def _xml(description: dict[str, Any], coat: str) -> str:
    """The description as Mitsuba's XML, with the parameters $coat, $spp, $width and $height."""
    text = xml(description).replace(f'<bsdf type="{coat}"', '<bsdf type="$coat"')
    text = text.replace(f'name="reference" value="{coat}"', 'name="reference" value="$coat"')
    first, rest = text.split("\n", 1)
    return f'{first}\n    <default name="coat" value="{coat}"/>\n{rest}'
