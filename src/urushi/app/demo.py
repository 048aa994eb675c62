"""The demo: a lacquered tea caddy with a maki-e pattern, by the walk and by the networks.

Render the demo's scene with the walk and with the networks, compare, and write everything.

`urushi demo`.

Pictures for looking at: tone curve, difference in false colour, panels side by side.
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

#: Samples a pixel in one pass: bounds the memory, and is the step of the progress bar.
PASS_SPP = 8

#: The plugins under comparison: the reference first.
REFERENCE, NEURAL = "layered", "neural_layered"


@dataclass(frozen=True)
class Render:
    """A render, kept as two independent halves so that its noise is known.

    Attributes:
        first, second: (H, W, 3) float64 linear radiance, each from half of the samples.
        seconds: wall time of the passes after the first.
        start: wall time of loading the scene and of the first pass, which compiles.
    """

    first: np.ndarray
    second: np.ndarray
    seconds: float
    start: float

    @property
    def image(self) -> np.ndarray:
        return (self.first + self.second) / 2

    @property
    def variance(self) -> np.ndarray:
        """(H, W, 3) estimate of the image's variance by pixel."""
        return metrics.halves_variance(self.first, self.second)


def run(
    out: Path, *, size: int = 400, spp: int = 128, variant: str = "llvm_ad_rgb", seed: int = 0
) -> dict[str, float]:
    """Render the lacquered caddy twice and write images and figures into the folder `out`.

    Writes `neural_layered` and `layered` as .exr and .png, `comparison.png` (reference, networks
    and their difference from left to right), `difference.png`, `report.json` and `natsume.ply`.

    Args:
        out: folder, made where it is missing.
        size: pixels across, in each render.
        spp: samples a pixel of each render, a multiple of 16.
        variant: Mitsuba variant.
        seed: of both renders' samples.

    Returns:
        The figures of `report.json`, see `compare`.

    Raises:
        ParameterError: `size` or `spp` is no positive number of the right kind.
        FileError: `out` cannot be written.
    """
    if size < 1:
        raise ParameterError(f"size is {size}; it must be at least one pixel")
    if spp < 2 * PASS_SPP or spp % (2 * PASS_SPP):
        raise ParameterError(f"spp is {spp}; it must be a positive multiple of {2 * PASS_SPP}")
    mesh = out / "natsume.ply"
    new_folder(out)
    write_ply(lathe(caddy.natsume(), 256, 384), mesh)
    mi.set_variant(variant)
    renders = {  # with different seeds: noise that both share would hide in the comparison
        name: render(name, mesh, size, spp, 2 * seed + index)
        for index, name in enumerate((NEURAL, REFERENCE))
    }
    figures = compare(renders[NEURAL], renders[REFERENCE])
    write(out, renders, figures)
    return figures


def render(bsdf: str, mesh: Path, size: int, spp: int, seed: int) -> Render:
    """Render the scene with the plugin `bsdf` in passes, which add up in two halves by turns."""
    begin = time.perf_counter()
    loaded = mi.load_dict(scene(bsdf, str(mesh), width=size, height=size))
    halves = np.zeros((2, size, size, 3))
    passes, start = spp // PASS_SPP, 0.0
    for index in tqdm(range(passes), desc=f"{bsdf:>14}", unit="pass", disable=None):
        image = mi.render(loaded, spp=PASS_SPP, seed=seed * passes + index)
        halves[index % 2] += np.array(image, dtype=np.float64) / (passes // 2)
        start = start or time.perf_counter() - begin
    return Render(halves[0], halves[1], seconds=time.perf_counter() - begin - start, start=start)


def compare(neural: Render, reference: Render) -> dict[str, float]:
    """Figures of the networks' image against the walk's.

    Returns:
        mse: mean squared error, both images' noise included.
        relative_mse: relative mean squared error less the reference's noise.
        relative_mse_noise_free: less both images' noise, an estimate for endless samples.
        reference_noise, neural_noise: what was subtracted, relative in the same way.
        psnr: of the tone-mapped pictures [dB].
        seconds and start_seconds of either: see `Render`.
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


def describe(figures: dict[str, float]) -> str:
    """The figures of `compare` that matter, in three lines to print."""
    return (
        f"relative mean squared error, less the reference's noise: {figures['relative_mse']:.4f}\n"
        f"the noise itself: {figures['reference_noise']:.4f} in '{REFERENCE}', "
        f"{figures['neural_noise']:.4f} in '{NEURAL}'\n"
        f"rendering took {figures['reference_seconds']:.0f} s and "
        f"{figures['neural_seconds']:.0f} s, "
        f"after {figures['reference_start_seconds']:.0f} s and "
        f"{figures['neural_start_seconds']:.0f} s to start"
    )


def write(out: Path, renders: dict[str, Render], figures: dict[str, float]) -> None:
    """Write the images and the figures, each file whole or not at all."""
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


@dataclass(frozen=True)
class Demo:
    """Render a lacquered tea caddy by the reference walk and by the networks, side by side.

    Writes both pictures, their difference (EXR and PNG) and the error's figures.

    Example: urushi demo -o out/demo
    """

    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("out/demo")
    """Folder to write to."""
    mode: Annotated[str, tyro.conf.arg(aliases=["-m"])] = "llvm_ad_rgb"
    """Mitsuba variant."""
    size: int = 400
    """Pixels across each picture."""
    spp: int = 128
    """Samples per pixel of each picture, a multiple of 16."""

    def run(self) -> int:
        from urushi.app.commands.render import set_variant

        set_variant(self.mode)
        figures = run(self.output, size=self.size, spp=self.spp, variant=self.mode)
        print(describe(figures))
        print(self.output / "comparison.png")
        return 0


#: Relative differences of this size and more are shown in full colour.
DIFFERENCE_SCALE = 0.25


def tonemap(radiance: np.ndarray) -> np.ndarray:
    """Film-like curve (the fit of Narkowicz 2015 to ACES), then the sRGB transfer function.

    Args:
        radiance: (H, W, 3) linear, 1 a bright surface; highlights above roll off softly.

    Returns:
        (H, W, 3) display values in [0, 1].
    """
    x = np.maximum(radiance, 0)
    curve = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
    return srgb(np.clip(curve, 0, 1))


def difference_picture(image: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Signed relative difference of luminance: black where equal, orange too bright, blue too dark.

    Args:
        image, reference: (H, W, 3) linear radiance.

    Returns:
        (H, W, 3) display values in [0, 1].
    """
    weights = np.array([0.2126, 0.7152, 0.0722])  # of Rec. 709
    luminance = reference @ weights
    relative = (image @ weights - luminance) / (luminance + 0.05)
    amount = np.clip(np.abs(relative) / DIFFERENCE_SCALE, 0, 1)[..., None]
    colour = np.where(relative[..., None] > 0, [1.0, 0.55, 0.15], [0.2, 0.55, 1.0])
    return amount * colour


def side_by_side(*panels: np.ndarray, gap: int = 4) -> np.ndarray:
    """Join (H, W, 3) display images from left to right, with white gaps."""
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
