"""`urushi demo`: a lacquered tea caddy, rendered by the networks and by the reference walk.

In this order: pictures for looking at, rendering, comparison, files and the command.
"""

import json
import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import mitsuba as mi
import numpy as np
import tyro
from tqdm import tqdm

from urushi.errors import ParameterError
from urushi.eval import metrics
from urushi.eval.metrics import srgb
from urushi.files import atomic_write, new_folder
from urushi.scenes import caddy
from urushi.scenes.caddy import scene
from urushi.scenes.mesh import lathe, write_ply

#: Samples per pixel in one pass: bounds the memory, and is the step of the progress bar.
PASS_SPP = 8

#: The compared plugins: the random walk, which is the reference, and the networks.
REFERENCE, NEURAL = "layered", "neural_layered"

#: Relative differences of luminance of this size and above are shown in full colour.
DIFFERENCE_SCALE = 0.25

#: Commands to try after the demo, with what they do.
NEXT_COMMANDS = (
    ("urushi render teapot -o out/teapot.png", "another scene, by the networks"),
    ("urushi render teapot -D coat=layered -o out/teapot-reference.png", "the same, by the walk"),
    ("urushi scenes export still-life out/still-life", "a scene file to change and render"),
    ('urushi simulate "coat(diffuse(0.5), alpha=0.1, eta=1.5)"', "values of a coated BRDF"),
)


def tonemap(radiance: np.ndarray) -> np.ndarray:
    """Film-like curve (the fit of Narkowicz 2015 to ACES), then the sRGB transfer function.

    Args:
        radiance: (H, W, 3) linear; 1 is a bright surface, and highlights above it roll off.

    Returns:
        (H, W, 3) display values in [0, 1].
    """
    x = np.maximum(radiance, 0)
    curve = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
    return srgb(np.clip(curve, 0, 1))


def difference_picture(image: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Signed relative difference of luminance: black if equal, orange if brighter, blue if darker.

    Args:
        image, reference: (H, W, 3) linear radiance.

    Returns:
        (H, W, 3) display values in [0, 1].
    """
    weights = np.array([0.2126, 0.7152, 0.0722])  # luminance of Rec. 709
    luminance = reference @ weights
    relative = (image @ weights - luminance) / (luminance + 0.05)
    amount = np.clip(np.abs(relative) / DIFFERENCE_SCALE, 0, 1)[..., None]
    colour = np.where(relative[..., None] > 0, [1.0, 0.55, 0.15], [0.2, 0.55, 1.0])
    return amount * colour


def side_by_side(*panels: np.ndarray, gap: int = 4) -> np.ndarray:
    """Join (H, W, 3) display images from left to right, with white gaps of `gap` pixels."""
    white = np.ones((panels[0].shape[0], gap, 3))
    joined = [part for panel in panels for part in (white, panel)][1:]
    return np.concatenate(joined, axis=1)


def write_png(image: np.ndarray, path: str | os.PathLike) -> None:
    """Write (H, W, 3) display values in [0, 1] as an 8-bit PNG, whole or not at all."""
    pixels = np.round(255 * np.clip(image, 0, 1)).astype(np.uint8)
    with atomic_write(path) as temporary:
        mi.Bitmap(np.ascontiguousarray(pixels)).write(str(temporary))


def write_exr(image: np.ndarray, path: str | os.PathLike) -> None:
    """Write (H, W, 3) linear radiance as a float32 EXR, whole or not at all."""
    with atomic_write(path) as temporary:
        mi.Bitmap(np.ascontiguousarray(image, dtype=np.float32)).write(str(temporary))


@dataclass(frozen=True)
class Render:
    """A render as two independent halves, whose difference measures its noise.

    Attributes:
        first, second: (H, W, 3) float64 linear radiance, each from half of the samples.
        seconds: wall time of the passes after the first.
        start: wall time of loading the scene and of the first pass, which compiles the code.
    """

    first: np.ndarray
    second: np.ndarray
    seconds: float
    start: float

    @property
    def image(self) -> np.ndarray:
        """(H, W, 3) mean of both halves."""
        return (self.first + self.second) / 2

    @property
    def variance(self) -> np.ndarray:
        """(H, W, 3) estimate of the variance of `image` in every pixel."""
        return metrics.halves_variance(self.first, self.second)


def render(bsdf: str, mesh: Path, width: int, height: int, spp: int, seed: int) -> Render:
    """Render the scene with the plugin `bsdf` in passes, which alternate between the two halves."""
    begin = time.perf_counter()
    loaded = mi.load_dict(scene(bsdf, str(mesh), width=width, height=height))
    halves = np.zeros((2, height, width, 3))
    passes, start = spp // PASS_SPP, 0.0
    for index in tqdm(range(passes), desc=f"{bsdf:>14}", unit="pass", disable=None):
        image = mi.render(loaded, spp=PASS_SPP, seed=seed * passes + index)
        halves[index % 2] += np.array(image, dtype=np.float64) / (passes // 2)
        start = start or time.perf_counter() - begin
    return Render(halves[0], halves[1], seconds=time.perf_counter() - begin - start, start=start)


def compare(neural: Render, reference: Render) -> dict[str, float]:
    """Figures of the networks' image against the walk's.

    Returns:
        mse: mean squared error, with the noise of both images.
        relative_mse: relative mean squared error, less the noise of the reference.
        relative_mse_noise_free: the same less the noise of both images: an estimate for infinitely
            many samples.
        reference_noise, neural_noise: the relative noise that was subtracted.
        psnr: of the tone-mapped pictures [dB].
        neural_seconds, reference_seconds, neural_start_seconds, reference_start_seconds: `seconds`
            and `start` of each `Render`.
    """
    image, truth = neural.image, reference.image
    noise = {
        name: metrics.relative_mse(truth, truth, variance=-of.variance)
        for name, of in (("reference", reference), ("neural", neural))
    }
    without = metrics.relative_mse(image, truth, variance=reference.variance)
    return {
        "mse": metrics.mse(image, truth),
        "relative_mse": without,
        "relative_mse_noise_free": without - noise["neural"],
        "reference_noise": noise["reference"],
        "neural_noise": noise["neural"],
        "psnr": metrics.psnr(tonemap(image), tonemap(truth)),
        "neural_seconds": neural.seconds,
        "reference_seconds": reference.seconds,
        "neural_start_seconds": neural.start,
        "reference_start_seconds": reference.start,
    }


def describe(figures: dict[str, float], out: Path) -> str:
    """Text to print after the demo: what each method cost, what to look at, what to try next.

    Args:
        figures: of `compare`.
        out: the folder that `run` wrote to.
    """
    commands = "\n".join(f"  {command}\n      {purpose}" for command, purpose in NEXT_COMMANDS)
    time = figures["neural_seconds"] / figures["reference_seconds"]
    noise = figures["neural_noise"] / figures["reference_noise"]
    return f"""
method             start    render    noise
{_cost(figures, REFERENCE, "reference")}   random walks through the coat: the reference
{_cost(figures, NEURAL, "neural")}   the networks

"start" is loading the scene, compiling the code, and the first {PASS_SPP} samples per pixel.
Compiled code is kept on disk: the next start is shorter. "noise" is the relative mean squared
error that more samples would remove.

A render by the networks takes {time:.0%} of the walk's time and has {noise:.0%} of its noise. For a
picture of the same noise, the networks take {time * noise:.0%} of the walk's time.

Error of the networks: {figures["relative_mse"]:.4f}
  Relative mean squared error, without the noise of '{REFERENCE}'.

Look at {out / "comparison.png"}
  Left: {REFERENCE}. Middle: {NEURAL}. Right: their difference in luminance; black is equal,
  orange means that the networks are brighter, blue that they are darker, and the full colour is a
  difference of {DIFFERENCE_SCALE:.0%} or more. All figures are in {out / "report.json"}.

Try next
{commands}
  In your own Mitsuba scene, put the plugin "{NEURAL}" around a BSDF to coat it."""


def _cost(figures: dict[str, float], plugin: str, name: str) -> str:
    start, seconds = figures[f"{name}_start_seconds"], figures[f"{name}_seconds"]
    return f"{plugin:<14} {start:7.1f} s {seconds:7.1f} s   {figures[f'{name}_noise']:.4f}"


def write(out: Path, renders: dict[str, Render], figures: dict[str, float]) -> None:
    """Write the images and the figures into the folder `out`, each file whole or not at all.

    Raises:
        FileError: a file cannot be written.
    """
    shown = {name: tonemap(of.image) for name, of in renders.items()}
    for name, of in renders.items():
        write_exr(of.image, out / f"{name}.exr")
        write_png(shown[name], out / f"{name}.png")
    difference = difference_picture(renders[NEURAL].image, renders[REFERENCE].image)
    write_png(difference, out / "difference.png")
    write_exr(renders[NEURAL].image - renders[REFERENCE].image, out / "difference.exr")
    panels = side_by_side(shown[REFERENCE], shown[NEURAL], difference)
    write_png(panels, out / "comparison.png")
    with atomic_write(out / "report.json") as temporary:
        temporary.write_text(json.dumps(figures, indent=2) + "\n")


def run(
    out: Path,
    *,
    width: int = 400,
    height: int = 400,
    spp: int = 128,
    variant: str = "llvm_ad_rgb",
    seed: int = 0,
) -> dict[str, float]:
    """Render the lacquered caddy by both methods and write images and figures into `out`.

    Writes `neural_layered` and `layered` as .exr and .png, `comparison.png` (reference, networks
    and their difference from left to right), `difference.png`, `difference.exr`, `report.json` and
    `natsume.ply`.

    Args:
        out: folder, made if it is missing.
        width, height: size of each picture [pixels].
        spp: samples per pixel of each render, a multiple of 16.
        variant: Mitsuba variant.
        seed: of the samples; the two renders derive different seeds from it.

    Returns:
        The figures of `report.json`, see `compare`.

    Raises:
        ParameterError: `width`, `height` or `spp` is out of range.
        FileError: `out` cannot be written.
    """
    for name, pixels in (("width", width), ("height", height)):
        if pixels < 1:
            raise ParameterError(f"{name} is {pixels}; it must be at least one pixel")
    if spp < 2 * PASS_SPP or spp % (2 * PASS_SPP):
        raise ParameterError(f"spp is {spp}; it must be a positive multiple of {2 * PASS_SPP}")
    mesh = out / "natsume.ply"
    new_folder(out)
    write_ply(lathe(caddy.natsume(), 256, 384), mesh)
    mi.set_variant(variant)
    renders = {  # with different seeds: noise that both share would cancel in the comparison
        name: render(name, mesh, width, height, spp, 2 * seed + index)
        for index, name in enumerate((NEURAL, REFERENCE))
    }
    figures = compare(renders[NEURAL], renders[REFERENCE])
    write(out, renders, figures)
    return figures


@dataclass(frozen=True)
class Demo:
    """Render a lacquered tea caddy by the reference walk and by the networks, and compare.

    Writes both pictures, their difference and the error figures into a folder. Then prints what
    each method cost, what to look at and what to try next.

    Example: urushi demo -o out/demo
    """

    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("out/demo")
    """Folder to write to. It is created if it is missing."""
    mode: Annotated[str, tyro.conf.arg(aliases=["-m"])] = "llvm_ad_rgb"
    """Mitsuba variant."""
    width: int = 400
    """Width of each picture in pixels."""
    height: int = 400
    """Height of each picture in pixels."""
    spp: int = 128
    """Samples per pixel of each picture, a multiple of 16."""

    def run(self) -> int:
        from urushi.app.commands.render import set_variant

        set_variant(self.mode)
        figures = run(
            self.output, width=self.width, height=self.height, spp=self.spp, variant=self.mode
        )
        print(describe(figures, self.output))
        return 0
