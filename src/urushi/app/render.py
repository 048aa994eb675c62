"""`urushi render` and `urushi scene`: scene files with Urushi's plugins, and the demo's scene.

Pictures are rendered in passes: progress is shown, memory is bounded, and an interrupt is heard.
"""

import re
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro
from tqdm import tqdm

from urushi import platform
from urushi.errors import FileError, ParameterError, PlatformError
from urushi.files import atomic_write, check_file, is_file, new_folder
from urushi.ranges import Index, Pixels, Samples, Seed, Threads

SUFFIXES = (".exr", ".png", ".jpg")

#: Mitsuba's words for a plugin that no library and no imported package has, and Urushi's.
NO_PLUGIN = r'failed to instantiate \w+ plugin of type "(\w+)": \[PluginManager\] .* not found!?'
NO_PLUGIN_CURE = (
    r"neither Mitsuba nor Urushi has a plugin '\1'; if it belongs to another package, render by "
    "that package's command, or import it in Python before you load the scene"
)

#: The scene of `urushi demo`, which `python -m gallery caddy` makes.
DEMO_SCENE = Path(__file__).parent / "caddy" / "scene.xml"


@dataclass(frozen=True)
class Render:
    """Render a Mitsuba scene file that may use Urushi's plugins, or the demo's scene, caddy.

    The flags -m, -o, -s, -D, -a and -t mean what they mean to Mitsuba's own executable, which
    cannot load plugins written in Python. The picture is the mean of passes, whose progress is
    shown on a terminal. The parameters of caddy are $coat, $spp, $width and $height: -D
    coat=layered renders the reference.

    Example: urushi render caddy --width 320 --height 240 --spp 64 -o caddy.exr
    """

    scene: tyro.conf.Positional[str]
    """Scene file (XML), or caddy."""
    mode: Annotated[str, tyro.conf.arg(aliases=["-m"])] = "llvm_ad_rgb"
    """Mitsuba variant."""
    output: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Picture to write: .exr (linear), .png or .jpg (sRGB). Default: an .exr file of the scene's
    name, beside the scene file or, for caddy, in the working folder."""
    sensor: Annotated[Index, tyro.conf.arg(aliases=["-s"])] = 0
    """Index of the sensor (camera), counted from 0 in the scene file's order."""
    define: Annotated[
        tuple[str, ...], tyro.conf.arg(aliases=["-D"]), tyro.conf.UseAppendAction
    ] = ()
    """Set the scene file's parameter $key: -D key=value. May be repeated."""
    append: Annotated[
        tuple[Path, ...], tyro.conf.arg(aliases=["-a"]), tyro.conf.UseAppendAction
    ] = ()
    """Another folder to search for the scene's files. May be repeated."""
    threads: Annotated[Threads | None, tyro.conf.arg(aliases=["-t"])] = None
    """Number of threads that render. All cores read and write files. Default: one per core."""
    weights: str | None = None
    """Networks of every neural_layered and openpbr that names none itself: a weights file.
    Default: the shipped ones."""
    width: Pixels | None = None
    """Width of the picture in pixels. Default: the scene's own."""
    height: Pixels | None = None
    """Height of the picture in pixels. Default: the scene's own."""
    spp: Samples | None = None
    """Samples per pixel. Default: the scene's own."""
    seed: Seed = 0
    """Seed of the random numbers."""

    #: Camera rays of a pass, at most. Recording a pass takes up to half a second, so that fewer
    #: cost time.
    RAYS = 1 << 22

    def run(self) -> int:
        definitions = {}
        for pair in self.define:
            key, equals, definitions[key] = pair.partition("=")
            if not (key and equals):
                raise ParameterError(f"-D '{pair}' is not of the form key=value")
        path, name = Path(self.scene), None
        if not (is_file(path) or path.suffix):
            if self.scene != DEMO_SCENE.parent.name:
                raise ParameterError(
                    f"there is no scene '{self.scene}'; give a scene file or 'caddy'"
                )
            path, name = DEMO_SCENE, self.scene
        target = self.output or Path(self.scene).with_suffix(".exr")
        if target.suffix.lower() not in SUFFIXES:
            raise ParameterError(
                f"'{target}' does not end in a picture format; use {', '.join(SUFFIXES)}"
            )
        in_bytes = target.suffix.lower() != ".exr"
        with atomic_write(target) as temporary:  # it fails before a picture is rendered
            bitmap = self._picture(path, definitions, name, only_colours=in_bytes)
            import mitsuba as mi

            if in_bytes:  # Mitsuba's conversion to bytes turns thousands into black
                linear = bitmap.convert(mi.Bitmap.PixelFormat.RGB, srgb_gamma=False)
                bitmap = mi.util.convert_to_bitmap(np.minimum(linear, 1))
            bitmap.write(str(temporary))
        print(target)
        return 0

    def _picture(
        self, path: Path, definitions: dict[str, str], name: str | None, only_colours: bool
    ) -> Any:
        """The picture (`mi.Bitmap`) of a scene file; only_colours: refuse other channels."""
        set_variant(self.mode)
        import drjit as dr

        size = {"width": self.width, "height": self.height}
        scene = load_scene(
            path, definitions, self.append, weights=self.weights, size=size, name=name
        )
        sensors = len(scene.sensors())
        if not 0 <= self.sensor < sensors:
            raise ParameterError(
                f"--sensor is {self.sensor}, but '{self.scene}' has {sensors} sensors; give an "
                "index from 0, or add a <sensor> to the scene"
            )
        if scene.integrator() is None:
            raise FileError(f"'{self.scene}' has no integrator; add an <integrator> to the scene")
        film = scene.sensors()[self.sensor].film()
        more = scene.integrator().aov_names() or film.base_channels_count() > 4
        if only_colours and more:
            raise ParameterError(
                f"'{self.scene}' has more channels than colours, which only .exr files hold; give "
                "-o a name that ends in .exr"
            )
        before = dr.thread_count()
        # Not while files are read and written: see `set_variant`.
        dr.set_thread_count(self.threads or before)
        try:
            spp = self.spp or scene.sensors()[self.sensor].sampler().sample_count()
            return rendered(scene, self.sensor, spp, self.seed, self.RAYS)
        except RuntimeError as error:
            raise_interrupt(error)
            raise PlatformError(f"cannot render '{self.scene}': {one_line(error)}") from error
        finally:
            dr.set_thread_count(before)


def passes(
    scene: Any, spp: int, seed: int, step: int, *, sensor: int = 0, title: str | None = None
) -> Iterator[tuple[np.ndarray, int]]:
    """Render a scene in passes of `step` samples per pixel; yields pictures and their samples.

    Each pass has a seed of its own, which depends only on `seed` and its number. The last one has
    the samples that remain of `spp`. title: of the progress bar, which only a terminal shows.

    Yields:
        float64 (H, W, C), and the number of its samples per pixel. Channels are the film's.
    """
    import mitsuba as mi

    film = scene.sensors()[sensor].film()
    more = bool(scene.integrator().aov_names())  # `mi.render` returns some of them only
    with tqdm(total=spp, desc=title, unit=" spp", disable=None) as progress:
        for index, first in enumerate(range(0, spp, step)):
            samples = min(step, spp - first)
            own = int(np.random.SeedSequence(seed, spawn_key=(index,)).generate_state(1)[0])
            picture = mi.render(scene, sensor=sensor, spp=samples, seed=own)
            yield np.array(film.bitmap() if more else picture, np.float64), samples
            progress.update(samples)


def rendered(scene: Any, sensor: int, spp: int, seed: int, rays: int) -> Any:
    """The picture (`mi.Bitmap`) of `spp` samples per pixel, the mean over its passes.

    It depends only on the arguments; but a scene that is loaded again has other noise, because
    Mitsuba merges its meshes in an order of chance. rays: of the camera in a pass, at most.
    """
    import mitsuba as mi

    film = scene.sensors()[sensor].film()
    width, height = film.crop_size()
    step = 1  # a power of four, which no sampler of Mitsuba rounds
    while 4 * step * width * height <= rays:
        step *= 4
    parts = passes(scene, spp, seed, step, sensor=sensor)
    mean = sum((picture * samples for picture, samples in parts), start=np.zeros(())) / spp
    form = film.bitmap()
    names = [channel.name for channel in form.struct_()]
    return mi.Bitmap(mean.astype(np.float32), form.pixel_format(), names)


def load_scene(
    path: Path,
    definitions: Mapping[str, str],
    folders: Sequence[Path] = (),
    *,
    weights: str | None = None,
    size: Mapping[str, int | None] = {},
    name: str | None = None,
) -> Any:
    """Load a scene file as `mi.load_file` does.

    Args:
        path: the XML file.
        definitions: values of the file's parameters by name.
        folders: where its meshes and textures are looked for, after the file's own folder.
        weights: those of every coat that names none itself: "default" or a weights file,
            relative to the working folder; None: the default.
        size: "width" and "height" of the film of every sensor [pixels]; None: the file's own.
        name: of the scene in messages; default: the file.

    Returns:
        The `mi.Scene`.
    """
    import mitsuba as mi

    check_file(path, f"scene file '{path}' does not exist")
    if weights is not None and is_file(weights):
        weights = str(Path(weights).absolute())  # Mitsuba searches the scene's folder
    resolver = mi.file_resolver()
    resolver.prepend(str(path.parent))
    for folder in folders:
        resolver.append(str(folder))
    try:
        config = mi.parser.ParserConfig(mi.variant())
        state = mi.parser.parse_file(config, str(path), **definitions)
        nodes = state.nodes  # a copy
        for node in nodes:
            if node.type == mi.ObjectType.Film:
                for key, value in size.items():
                    if value is not None:
                        node.props[key] = value
            neural = node.props.plugin_name() in ("neural_layered", "openpbr")
            if neural and weights is not None and "weights" not in node.props:
                node.props["weights"] = weights
        state.nodes = nodes
        mi.parser.transform_all(config, state)
        scene = mi.parser.instantiate(config, state)
    except Exception as error:  # Mitsuba raises several kinds, plugins their own
        raise_interrupt(error)
        place = rf"(At|(Error w|W)hile loading) {re.escape(str(path))} \((line \d+), col \d+\): "
        reason = re.sub(place, r"" if name else r"\3: ", one_line(error))
        reason = re.sub(NO_PLUGIN, NO_PLUGIN_CURE, reason)
        raise FileError(f"cannot load '{name or path}': {reason}") from error
    finally:
        del resolver[0]
        for _ in folders:
            del resolver[len(resolver) - 1]
    if not isinstance(scene, mi.Scene):
        raise FileError(f"'{path}' is not a scene: its outermost element must be <scene>")
    return scene


def set_variant(name: str) -> None:
    """Switch Mitsuba to a variant."""
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
            f"variant '{name}' cannot run here: {one_line(error)}; `urushi doctor` lists those "
            "that can"
        ) from error
    import drjit as dr

    dr.set_thread_count(max(dr.thread_count(), 2))  # with one, Mitsuba waits for ever for EXR


def raise_interrupt(error: BaseException) -> None:
    """Raise KeyboardInterrupt if it caused the error; Mitsuba and Dr.Jit wrap exceptions."""
    cause: BaseException | None = error
    while cause is not None:
        if isinstance(cause, KeyboardInterrupt) or "KeyboardInterrupt" in str(cause):
            raise KeyboardInterrupt from error
        cause = cause.__cause__ or cause.__context__


def one_line(error: BaseException) -> str:
    """An error's message in one line, without additions for developers of Mitsuba.

    Removes source positions of Mitsuba's parser, invisible characters, and the traceback of a
    plugin written in Python except its last line, the error.
    """
    text = str(error).replace("\u200b", "")  # of long messages, as a place to break the line
    text = re.sub(r"^\[\w+\.cpp:\d+\] ", "", text)
    text = re.sub(r"Traceback \(most recent call last\):\n(?:\s+.*\n)*(?:[\w.]+: )?", "", text)
    return " ".join(text.split()).rstrip(".")


@dataclass(frozen=True)
class Scene:
    """Write the demo's scene into a folder, to change it: scene.xml, its mesh and its textures.

    `urushi render FOLDER/scene.xml` renders the written scene.

    Example: urushi scene out/caddy
    """

    folder: tyro.conf.Positional[Path]
    """Folder to write to. It is created if it is missing."""

    def run(self) -> int:
        print(copy_demo_scene(self.folder))
        return 0


def copy_demo_scene(folder: Path) -> Path:
    """Copy the demo's scene into a folder; returns the path of its scene.xml."""
    new_folder(folder)
    for file in DEMO_SCENE.parent.iterdir():
        with atomic_write(folder / file.name) as temporary:
            shutil.copyfile(file, temporary)
    return folder / DEMO_SCENE.name
