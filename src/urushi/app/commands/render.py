"""`urushi render`: Mitsuba's own command line, with Urushi's plugins in it.

`urushi scenes`: the shipped scenes as folders, to look into and to change.
"""

import re
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from urushi import platform
from urushi.errors import FileError, ParameterError, PlatformError
from urushi.files import atomic_write

#: What Mitsuba puts into long messages so that they break well.
ZERO_WIDTH_SPACE = "\u200b"
SUFFIXES = (".exr", ".png", ".jpg")


@dataclass(frozen=True)
class Render:
    """Render a Mitsuba scene file, Urushi's plugins included, or one of the shipped scenes.

    Flags are those of the `mitsuba` executable, which cannot see Python plugins itself. The shipped
    scenes are still-life, globe, teapot and shoe; they have the parameters $coat ("layered" gives
    the reference), $spp, $resx and $resy.

    Example: urushi render teapot -m llvm_ad_rgb -D coat=layered --spp 64 -o teapot.exr
    """

    scene: tyro.conf.Positional[str]
    """Scene file (XML), or the name of a shipped scene."""
    mode: Annotated[str, tyro.conf.arg(aliases=["-m"])] = "llvm_ad_rgb"
    """Mitsuba variant."""
    output: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Picture to write (.exr, or .png/.jpg in sRGB); default: beside the scene file, or for a
    shipped scene in the working folder, with .exr."""
    sensor: Annotated[int, tyro.conf.arg(aliases=["-s"])] = 0
    """Index of the sensor, in the scene file's order."""
    define: Annotated[tuple[str, ...], tyro.conf.arg(aliases=["-D"]), tyro.conf.UseAppendAction] = (
        field(default=())
    )
    """Give the scene file's parameter $key a value: -D key=value; may be repeated."""
    append: Annotated[
        tuple[Path, ...], tyro.conf.arg(aliases=["-a"]), tyro.conf.UseAppendAction
    ] = field(default=())
    """Also look for the scene's files in this folder; may be repeated."""
    threads: Annotated[int | None, tyro.conf.arg(aliases=["-t"])] = None
    """Number of threads; default: all."""
    spp: int | None = None
    """Samples per pixel; default: the scene's own."""
    seed: int = 0
    """Seed of the random numbers."""

    def run(self) -> int:
        definitions = parse_definitions(self.define)
        set_variant(self.mode)
        import drjit as dr
        import mitsuba as mi

        if self.threads is not None:
            dr.set_thread_count(self.threads)
        scene = self._load(definitions)
        sensors = len(scene.sensors())
        if not 0 <= self.sensor < sensors:
            raise ParameterError(
                f"--sensor is {self.sensor}, but '{self.scene}' has {sensors}, counted from 0"
            )
        try:
            image = mi.render(scene, sensor=self.sensor, spp=self.spp or 0, seed=self.seed)
        except RuntimeError as error:
            raise PlatformError(f"cannot render '{self.scene}': {one_line(error)}") from error
        target = self.output or Path(self.scene).with_suffix(".exr")
        write_picture(image, target)
        print(target)
        return 0

    def _load(self, definitions: Mapping[str, str]) -> Any:
        """The scene of the file, or the shipped one where no file has that name."""
        from urushi.scenes import shipped

        path = Path(self.scene)
        if path.exists() or path.suffix:
            return load_scene(path, definitions, self.append)
        shipped.find(self.scene)
        with tempfile.TemporaryDirectory(prefix="urushi-") as folder:
            return load_scene(shipped.export(self.scene, folder), definitions, self.append)


def write_picture(image: Any, path: Path) -> None:
    """Write a rendered image by its suffix: linear .exr, or tone-mapped .png and .jpg."""
    import mitsuba as mi

    if path.suffix.lower() not in SUFFIXES:
        raise ParameterError(f"'{path}' has no suffix of a picture; use {', '.join(SUFFIXES)}")
    with atomic_write(path) as temporary:
        try:
            mi.util.write_bitmap(str(temporary), image, write_async=False)
        except RuntimeError as error:
            raise FileError(f"cannot write '{path}': {one_line(error)}") from error


def load_scene(path: Path, definitions: Mapping[str, str], folders: Sequence[Path] = ()) -> Any:
    """Load a scene file, looking for its files in `folders` too.

    Raises:
        FileError: it is missing, or Mitsuba refuses it; the message holds Mitsuba's reason.
    """
    import mitsuba as mi

    if not path.is_file():
        raise FileError(f"scene file '{path}' does not exist")
    resolver = mi.file_resolver()
    for folder in folders:
        resolver.append(str(folder))
    try:
        scene = mi.load_file(str(path), **definitions)
    except Exception as error:  # Mitsuba raises several kinds, plugins their own
        raise FileError(f"cannot load '{path}': {one_line(error)}") from error
    if not isinstance(scene, mi.Scene):
        raise FileError(f"'{path}' is no scene: its outermost element must be <scene>")
    return scene


def set_variant(name: str) -> None:
    """Switch Mitsuba to a variant; PlatformError or ParameterError says why it cannot be had."""
    platform.require_drjit()
    import mitsuba as mi

    if name not in mi.variants():
        raise ParameterError(
            f"Mitsuba has no variant '{name}'; choose one of {', '.join(mi.variants())}"
        )
    if name.startswith("llvm"):
        platform.require_llvm()
    try:
        mi.set_variant(name)
    except ImportError as error:
        raise PlatformError(
            f"variant '{name}' cannot run here: {one_line(error)}; `urushi doctor` says which can"
        ) from error


def parse_definitions(pairs: tuple[str, ...]) -> dict[str, str]:
    """Split "key=value" pairs."""
    definitions = {}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not (key and equals):
            raise ParameterError(f"-D is given '{pair}'; write it as key=value")
        definitions[key] = value
    return definitions


def one_line(error: BaseException) -> str:
    """An error's message in one line, without what Mitsuba adds for its own developers.

    That is: source positions in its parser, invisible characters, and the stack of calls of a
    plugin written in Python, of which only the error at the end is kept.
    """
    text = str(error).replace(ZERO_WIDTH_SPACE, "")
    text = re.sub(r"^\[\w+\.cpp:\d+\] ", "", text)
    text = re.sub(r"Traceback \(most recent call last\):\n(?:\s+.*\n)*(?:[\w.]+: )?", "", text)
    return " ".join(text.split()).rstrip(".")


@dataclass(frozen=True)
class ExportScene:
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

        set_variant("scalar_rgb")  # describes a scene as well as any, and needs no LLVM
        from urushi.scenes import shipped
        from urushi.scenes.stage import Options

        options = Options(coat=self.coat, weights=self.weights, detail=self.detail)
        print(shipped.export(self.scene, self.folder, options))
        return 0


@dataclass(frozen=True)
class ListScenes:
    """Print the shipped scenes' names and what they show.

    Example: urushi scenes list
    """

    def run(self) -> int:
        from urushi.scenes import shipped

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
        Annotated[ExportScene, tyro.conf.subcommand("export")]
        | Annotated[ListScenes, tyro.conf.subcommand("list")]
    )

    def run(self) -> int:
        return self.command.run()
