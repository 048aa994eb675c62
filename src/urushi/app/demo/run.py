"""Render the demo's scene with the walk and with the networks, compare, and write everything."""

import json
import time
from dataclasses import dataclass
from pathlib import Path

import mitsuba as mi
import numpy as np
from tqdm import tqdm

from urushi.app.demo import geometry, picture
from urushi.app.demo.scene import scene
from urushi.errors import ParameterError
from urushi.eval import metrics
from urushi.files import atomic_write, new_folder
from urushi.render.scenes.mesh import write_ply
from urushi.render.scenes.turned import lathe

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
    write_ply(lathe(geometry.natsume(), 256, 384), mesh)
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
        "psnr": metrics.psnr(picture.tonemap(image), picture.tonemap(truth)),
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
    shown = {name: picture.tonemap(of.image) for name, of in renders.items()}
    for name, of in renders.items():
        picture.write_exr(of.image, out / f"{name}.exr")
        picture.write_png(shown[name], out / f"{name}.png")
    difference = picture.difference(renders[NEURAL].image, renders[REFERENCE].image)
    picture.write_png(difference, out / "difference.png")
    picture.write_exr(renders[NEURAL].image - renders[REFERENCE].image, out / "difference.exr")
    panels = picture.side_by_side(shown[REFERENCE], shown[NEURAL], difference)
    picture.write_png(panels, out / "comparison.png")
    with atomic_write(out / "report.json") as temporary:
        temporary.write_text(json.dumps(figures, indent=2) + "\n")
