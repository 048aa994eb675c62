"""The shipped scenes by name, as dictionaries for `mi.load_dict` or as folders with an XML file."""

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mitsuba as mi

from urushi.errors import ParameterError
from urushi.files import atomic_write
from urushi.mitsuba.register import ROOM
from urushi.scenes.caddy import caddy
from urushi.scenes.options import Options
from urushi.scenes.stage import Folder

#: A scene: a function that writes meshes and textures into a folder, and describes the scene.
Scene = Callable[[Folder, Options], dict[str, Any]]

SCENES: dict[str, Scene] = {"caddy": caddy}


def build(
    scene: Scene, folder: str | os.PathLike, options: Options | None = None
) -> dict[str, Any]:
    """Describe a scene; its meshes and textures are written into a folder.

    Args:
        scene: one of `SCENES`, or any other.
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


def find(name: str) -> Scene:
    """The function that describes the scene `name`.

    Raises:
        ParameterError: there is no such scene; the message lists the names.
    """
    if name not in SCENES:
        raise ParameterError(f"there is no scene '{name}'; choose one of {', '.join(SCENES)}")
    return SCENES[name]


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


def xml(description: dict[str, Any]) -> str:
    """A scene for `mi.load_dict` as Mitsuba's XML, with the parameters $spp, $width and $height."""
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
