"""Renders scenes that the page has saved, and compares: `mitsuba_picture.py FOLDER`.

Each line of the standard input is a name. The folder holds `NAME.zip` (the scene), `NAME.exr` (the
page's radiance) and `NAME.png` (the page's picture, as it is seen). Prints the measures of
`compare` as a line of JSON. Writes `NAME-compared.png`: page, Mitsuba, and the map of FLIP.
"""

import json
import sys
import zipfile
from pathlib import Path

import drjit as dr
import flip_evaluator
import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")

import urushi  # noqa: E402, F401  (registers the plugins)
from urushi.app.demo import side_by_side, srgb, write_png  # noqa: E402

#: Samples of a half of a picture, and how they are drawn: jittered ones have the noise of three
#: times as many independent ones. Noise must be far below what is compared, see `compare`.
SAMPLES, SAMPLER = 400, "multijitter"


class Unoccluded(mi.SamplingIntegrator):
    """Light from the environment that an object reflects once, without shadows, as on the page.

    Emitters and BSDF are sampled, and weighted by the balance heuristic (Veach 1997). The last of
    the four channels is the object's coverage.
    """

    def sample(self, scene, sampler, ray, medium=None, active=True):
        si = scene.ray_intersect(ray, active)
        active = mi.Bool(active) & si.is_valid()
        context, bsdf = mi.BSDFContext(), si.bsdf(ray)
        result = mi.Color3f(0)

        ds, weight = scene.sample_emitter_direction(si, sampler.next_2d(active), False, active)
        use = active & (ds.pdf > 0)
        f_cos, pdf = bsdf.eval_pdf(context, si, si.to_local(ds.d), use)
        share = dr.select(ds.delta, 1, ds.pdf / (ds.pdf + pdf))
        result += dr.select(use, f_cos * weight * share, 0)

        bs, weight = bsdf.sample(
            context, si, sampler.next_1d(active), sampler.next_2d(active), active
        )
        ray = si.spawn_ray(si.to_world(bs.wo))
        away = dr.zeros(mi.SurfaceInteraction3f)
        away.wi, away.wavelengths = -ray.d, ray.wavelengths
        environment = scene.environment()
        use = active & (bs.pdf > 0)
        light = environment.eval(away, use)
        ds = dr.zeros(mi.DirectionSample3f)
        ds.d, ds.emitter = ray.d, mi.EmitterPtr(environment)
        chance = scene.pdf_emitter_direction(si, ds, use)
        result += dr.select(use, weight * light * bs.pdf / (bs.pdf + chance), 0)
        return result, si.is_valid(), [dr.select(si.is_valid(), 1.0, 0.0)]

    def aov_names(self):
        return ["coverage"]


def shown(image: np.ndarray) -> np.ndarray:
    """Radiance (H, W, 3) as shown, in [0, 1]: the neutral curve (Khronos 2024), and sRGB."""
    least = image.min(axis=-1, keepdims=True)
    light = image - np.where(least < 0.08, least - 6.25 * least**2, 0.04)
    start = 0.8 - 0.04
    peak = np.maximum(light.max(axis=-1, keepdims=True), 1e-6)
    lowered = 1 - (1 - start) ** 2 / (np.maximum(peak, start) + 1 - 2 * start)
    grey = 1 - 1 / (0.15 * (peak - lowered) + 1)
    bright = light * lowered / peak * (1 - grey) + lowered * grey
    return srgb(np.clip(np.where(peak < start, light, bright), 0, 1)).astype(np.float32)


def flip(image: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """The map (H, W) of FLIP (Andersson et al. 2020) of shown pictures, at 67 pixels a degree."""
    errors, _, _ = flip_evaluator.evaluate(reference, image, "LDR", applyMagma=False)
    return np.asarray(errors).reshape(image.shape[:2])


def render(scene: mi.Scene, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Radiance (H, W, 3) of the object alone, and where it covers a whole pixel (H, W)."""
    image = np.array(
        mi.render(scene, integrator=Unoccluded(mi.Properties()), spp=SAMPLES, seed=seed)
    )
    return image[..., :3], image[..., 3] > 1 - 1e-4


def compare(folder: Path, name: str) -> dict[str, float]:
    """The mean FLIP and the relative difference of the mean radiance, over whole pixels.

    `noise` and `mean_noise` are those of the noise of Mitsuba's picture, the mean of two halves of
    its samples: half of what the halves differ, since their difference has four times its variance.
    `tone` is the largest difference of the tone curve here from the page's.
    """
    target = folder / name
    with zipfile.ZipFile(folder / f"{name}.zip") as archive:
        archive.extractall(target)
    path = target / "scene.xml"
    path.write_text(path.read_text().replace('"independent"', f'"{SAMPLER}"'))
    scene = mi.load_file(str(path))
    (first, covered), (second, _) = (render(scene, seed) for seed in (1, 2))
    inside = covered[..., None]
    reference = (first + second) / 2
    page = np.array(mi.Bitmap(str(folder / f"{name}.exr")))
    png = np.array(mi.Bitmap(str(folder / f"{name}.png")))[..., :3] / np.float32(255)
    seen, expected = np.where(inside, png, 0), np.where(inside, shown(reference), 0)
    errors = flip(seen, expected)
    halves = flip(*(np.where(inside, shown(half), 0) for half in (first, second)))
    grey = np.repeat(errors[..., None], 3, axis=-1)
    write_png(side_by_side(seen, expected, grey), folder / f"{name}-compared.png")

    def mean(image: np.ndarray) -> float:
        return float(image[covered].mean())

    return {
        "flip": float(errors[covered].mean()),
        "noise": float(halves[covered].mean()) / 2,
        "mean": mean(page) / mean(reference) - 1,
        "mean_noise": (mean(first) / mean(second) - 1) / 2,
        "tone": float(np.abs(shown(page) - png).max()),
    }


if __name__ == "__main__":
    for line in sys.stdin:
        print(json.dumps(compare(Path(sys.argv[1]), line.strip())), flush=True)
