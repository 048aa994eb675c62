"""`urushi demo`: a lacquered tea caddy, by codes and by the reference walk, compared."""

import json
import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import tyro

from urushi.app.render import copy_demo_scene, load_scene, passes, set_variant
from urushi.core import error_metrics as metrics
from urushi.core.error_metrics import srgb
from urushi.files import atomic_write, new_folder
from urushi.ranges import Pixels, Range

#: Samples per pixel in one pass: bounds the memory, and is the step of the progress bar.
PASS_SPP = 8

#: The compared plugins: by codes, and the random walk, which is the reference.
COATS = NEURAL, REFERENCE = "neural_layered", "layered"

#: Relative differences of luminance of this size and above are shown in full colour.
DIFFERENCE_SCALE = 0.25

#: Commands to try after the demo, with their purpose.
NEXT_COMMANDS = (
    ("urushi render caddy -o out/caddy.png", "the scene alone, by codes"),
    ("urushi render caddy -D coat=layered -o out/caddy-reference.png", "the same, by the walk"),
    ("urushi scene out/caddy", "a scene file to change and render"),
    ('urushi simulate "coat(diffuse(0.5), alpha=0.1, eta=1.5)"', "values of a coated BRDF"),
)


@dataclass(frozen=True)
class Demo:
    """Render a lacquered tea caddy by the reference walk and by codes, and compare.

    Writes both pictures (.exr), `comparison.png` and `report.json` into a folder, and the scene's
    files into its folder `scene`. Then prints what each method cost, what to look at and what to
    try next.

    Example: urushi demo -o out/demo
    """

    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("out/demo")
    """Folder to write to. It is created if it is missing."""
    mode: Annotated[str, tyro.conf.arg(aliases=["-m"])] = "llvm_ad_rgb"
    """Mitsuba variant."""
    width: Pixels = 400
    """Width of each picture in pixels."""
    height: Pixels = 400
    """Height of each picture in pixels."""
    spp: Annotated[int, Range(16, 1 << 16, " samples", step=16)] = 128
    """Samples per pixel of each picture, a multiple of 16."""

    def run(self) -> int:
        set_variant(self.mode)
        import mitsuba as mi

        out = new_folder(self.output)
        scene, size = copy_demo_scene(out / "scene"), (self.width, self.height)
        neural, reference = (  # different seeds: noise that both share would cancel
            render(scene, coat, size, self.spp, k) for k, coat in enumerate(COATS)
        )
        figures = compare(neural, reference)
        for name, of in ((NEURAL, neural), (REFERENCE, reference)):
            with atomic_write(out / f"{name}.exr") as temporary:
                mi.Bitmap(of.image.astype(np.float32)).write(str(temporary))
        pictures = tonemap(reference.image), tonemap(neural.image)
        difference = difference_picture(neural.image, reference.image)
        write_png(side_by_side(*pictures, difference), out / "comparison.png")
        with atomic_write(out / "report.json") as temporary:
            temporary.write_text(json.dumps(figures, indent=2) + "\n")
        print(describe(figures, out))
        return 0


class Render(NamedTuple):
    """A render of two independent halves, whose difference measures its noise."""

    image: np.ndarray  # (H, W, 3) linear radiance
    variance: np.ndarray  # (H, W, 3) estimate of the variance of `image`
    seconds: float  # wall time of the passes after the first
    start: float  # wall time of loading the scene and of the first pass, which compiles the code


def render(scene: Path, coat: str, size: tuple[int, int], spp: int, seed: int) -> Render:
    """Render the scene with a plugin as its coat, in passes that alternate between the halves.

    size: width and height [pixels]. spp: samples per pixel, a multiple of twice `PASS_SPP`.
    """
    begin, (width, height), start = time.perf_counter(), size, 0.0
    loaded = load_scene(scene, {"coat": coat, "width": str(width), "height": str(height)})
    halves = np.zeros((2, height, width, 3))
    parts = passes(loaded, spp, seed, PASS_SPP, title=f"{coat:>14}")
    for index, (image, samples) in enumerate(parts):
        halves[index % 2] += image * samples / (spp // 2)
        start = start or time.perf_counter() - begin
    seconds = time.perf_counter() - begin - start
    return Render(halves.mean(axis=0), metrics.halves_variance(*halves), seconds, start)


def compare(neural: Render, reference: Render) -> dict[str, float]:
    """Figures of the image by codes against the walk's.

    Returns:
        relative_mse: relative mean squared error, less the noise of the reference;
            relative_mse_noise_free: less the noise of both. psnr: of the tone-mapped pictures [dB].
        noise, seconds, start_seconds: of each method, its name in front: the relative mean squared
            error that more samples would remove, and the times of its `Render`.
    """
    truth, figures = reference.image, {}
    for name, of in ((REFERENCE, reference), (NEURAL, neural)):
        figures[f"{name}_noise"] = metrics.relative_mse(truth, truth, variance=-of.variance)
        figures[f"{name}_seconds"], figures[f"{name}_start_seconds"] = of.seconds, of.start
    without = metrics.relative_mse(neural.image, truth, variance=reference.variance)
    return figures | {
        "relative_mse": without,
        "relative_mse_noise_free": without - figures[f"{NEURAL}_noise"],
        "psnr": metrics.psnr(tonemap(neural.image), tonemap(truth)),
    }


def describe(figures: dict[str, float], out: Path) -> str:
    """Text of the figures of `compare`, the pictures to look at, and commands to try next."""
    rows = "\n".join(
        f"{name:<14} {figures[f'{name}_start_seconds']:7.1f} s {figures[f'{name}_seconds']:7.1f} s"
        f"   {figures[f'{name}_noise']:.4f}   {what}"
        for name, what in ((REFERENCE, "random walks: the reference"), (NEURAL, "latent codes"))
    )
    commands = "\n".join(f"  {command}\n      {purpose}" for command, purpose in NEXT_COMMANDS)
    time, noise = (
        figures[f"{NEURAL}_{key}"] / figures[f"{REFERENCE}_{key}"] for key in ("seconds", "noise")
    )
    return f"""
method             start    render    noise
{rows}

"start" is loading the scene, compiling the code, and the first {PASS_SPP} samples per pixel.
Compiled code is kept on disk: the next start is shorter. "noise" is the relative mean squared
error that more samples would remove.

A render by codes takes {time:.0%} of the walk's time and has {noise:.0%} of its noise. For a
picture of the same noise, codes take {time * noise:.0%} of the walk's time.

Error of the codes: {figures["relative_mse"]:.4f}
  Relative mean squared error, without the noise of '{REFERENCE}'.

Look at {out / "comparison.png"}
  Left: {REFERENCE}. Middle: {NEURAL}. Right: their difference in luminance; black is equal,
  orange means that codes are brighter, blue that they are darker, and the full colour is a
  difference of {DIFFERENCE_SCALE:.0%} or more. All figures are in {out / "report.json"}.

Try next
{commands}
  In your own Mitsuba scene, put the plugin "{NEURAL}" around a BSDF to coat it."""


def tonemap(radiance: np.ndarray) -> np.ndarray:
    """Display values of linear radiance (H, W, 3): the fit of Narkowicz 2015 to ACES, then sRGB."""
    x = np.maximum(radiance, 0)
    curve = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
    return srgb(np.clip(curve, 0, 1))


def difference_picture(image: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Display values of the signed relative difference of luminance, all (H, W, 3).

    Black if equal, orange if brighter, blue if darker.
    """
    weights = np.array([0.2126, 0.7152, 0.0722])  # luminance of Rec. 709
    luminance = reference @ weights
    relative = (image @ weights - luminance) / (luminance + 0.05)
    amount = np.clip(np.abs(relative) / DIFFERENCE_SCALE, 0, 1)[..., None]
    colour = np.where(relative[..., None] > 0, [1.0, 0.55, 0.15], [0.2, 0.55, 1.0])
    return amount * colour


def side_by_side(*panels: np.ndarray) -> np.ndarray:
    """Join (H, W, 3) display images from left to right, with white gaps of four pixels."""
    white = np.ones((panels[0].shape[0], 4, 3))
    joined = [part for panel in panels for part in (white, panel)][1:]
    return np.concatenate(joined, axis=1)


def write_png(image: np.ndarray, path: str | os.PathLike) -> None:
    """Write (H, W, 3) display values in [0, 1] as an 8-bit PNG, whole or not at all."""
    import mitsuba as mi

    pixels = np.round(255 * np.clip(image, 0, 1)).astype(np.uint8)
    with atomic_write(path) as temporary:
        mi.Bitmap(np.ascontiguousarray(pixels)).write(str(temporary))
