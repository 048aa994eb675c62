"""Noise of importance sampling: by the networks' proposal, by Fan et al. 2022, and by cosines.

    python -m figures.proposal.compute

Figures are those of `benchmarks.quality.sampling`. Spheres under the studio of
`benchmarks.quality.sphere` are rendered by directions drawn from each proposal alone, without light
sampling; the reference is free of noise.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks.quality import sampling, sphere
from benchmarks.quality.sphere import AZIMUTHS, ELEVATIONS, Environment

import urushi
from figures import results
from urushi.core import error_metrics as metrics
from urushi.fan2022.inference import GaussianMixture
from urushi.material import Material
from urushi.nets.weights import default_model

FOLDER = Path(__file__).parent
PARTS = results.parts_folder("proposal")
#: The file of the spheres.
PICTURE = PARTS / "spheres.npz"
#: Names of the proposals in the figure, by that in the benchmark.
NAMES = dict(
    zip(sampling.PROPOSALS, ("networks", "Fan et al. 2022, best fit", "cosine"), strict=True)
)
#: Columns of the spheres.
COLUMNS = ("cosine", "Fan et al. 2022, best fit", "networks", "reference")
#: Samples of a pixel, and renders whose errors are averaged.
COUNTS, RENDERS, SEED = (4, 16), 8, 11
#: Shares of the materials and angles whose variation is stored.
SHARES = np.linspace(0, 1, 101)

#: wi (N, 3), uniform numbers (N, 3) -> wo (N, 3), density (N,) [1/sr].
Draw = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


def materials() -> dict[str, Material]:
    """The materials of the spheres."""
    clear = urushi.dielectric(alpha=0.03, eta=1.5)
    gold = urushi.conductor(alpha=0.2, r0=(1.0, 0.78, 0.34))
    return {
        "dark blue paint, clear coat": urushi.layer(clear, urushi.diffuse((0.03, 0.05, 0.1))),
        "gold, clear coat": urushi.layer(clear, gold),
    }


def main() -> None:
    """Compute what is missing and write results.json; pictures stay beside the finished parts."""
    mi.set_variant("llvm_ad_rgb")
    found = results.collect(PARTS, {"variation": variation, "spheres": spheres})
    head = {"weights": default_model().fingerprint}
    results.write(FOLDER / "results.json", {**head, **found})


def variation() -> dict[str, Any]:
    """The coefficient of variation of f cos / pdf over held-out stacks and angles.

    By proposal: its quantiles at `SHARES`, its medians by angle, and the largest weight.
    """
    found = {}
    for name, (cv, weight) in sampling.figures(default_model()).items():
        found[NAMES[name]] = {
            "quantiles": results.rounded(np.quantile(cv, SHARES)),
            "by angle": results.rounded(np.quantile(cv, (0.5, 0.95), axis=0)),
            "largest": float(f"{weight.max():.3g}"),
        }
    return found


def spheres() -> dict[str, dict[str, dict[str, float]]]:
    """Relative mean squared errors by material, proposal and samples; stores the pictures."""
    light = sphere.exposed(sphere.own_environments()[0])
    found: dict[str, dict[str, dict[str, float]]] = {}
    rows = []
    for name, material in materials().items():
        (truth,) = sphere.render(material.f, [light])
        draws = proposals(material)
        found[name] = {proposal: {} for proposal in draws}
        for count in COUNTS:
            row = []
            for proposal, draw in draws.items():
                images = [render(material, draw, light, count, SEED + i) for i in range(RENDERS)]
                found[name][proposal][str(count)] = float(f"{error(images, truth):.3g}")
                row.append(images[0])
            rows.append(np.stack([*row, truth]))
    results.write_pictures(PICTURE, {"spheres": np.stack(rows)})
    return found


def proposals(material: Material) -> dict[str, Draw]:
    """The proposals of a material in the order of the columns."""
    best = sampling.best_gaussian(sampling.draw(material, SEED))
    mixtures = {
        COLUMNS[0]: GaussianMixture(best.sigma, np.float32(0)),
        COLUMNS[1]: best,
    }

    def of(mixture: GaussianMixture) -> Draw:
        def draw(wi: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            wo = mixture.sample(wi, u)
            return wo, mixture.pdf(wi, wo)

        return draw

    return {name: of(mixture) for name, mixture in mixtures.items()} | {COLUMNS[2]: material.sample}


def render(material: Material, draw: Draw, light: Environment, count: int, seed: int) -> np.ndarray:
    """The sphere (H, W, 3) of `sphere.render` by `count` directions for each pixel."""
    rings = sphere.RINGS
    along = (np.arange(2 * rings) + 0.5 - rings) / rings
    x, y = (values[sphere.mask()] for values in np.meshgrid(along, -along))
    sine, azimuth = np.hypot(x, y), np.arctan2(y, x)
    cosine = np.sqrt(1 - sine**2)
    wi = np.stack([-sine, 0 * sine, cosine], axis=-1).astype(np.float32)
    wi, sine, cosine, azimuth = (np.repeat(a, count, axis=0) for a in (wi, sine, cosine, azimuth))
    u = np.random.default_rng(seed).random((len(wi), 3), np.float32)
    wo, pdf = draw(wi, u)
    # From the surface's frame, whose x axis points away from the middle, to that of the light.
    across, up = cosine * wo[:, 0] + sine * wo[:, 2], cosine * wo[:, 2] - sine * wo[:, 0]
    row = np.arctan2(np.hypot(across, wo[:, 1]), up) / np.pi * ELEVATIONS - 0.5
    column = (np.arctan2(wo[:, 1], across) + azimuth) / (2 * np.pi) * AZIMUTHS
    radiance = sphere.periodic_bilinear(
        light.radiance, np.clip(row, 0, ELEVATIONS - 1), column % AZIMUTHS
    )
    weight = np.where((pdf > 0) & (wo[:, 2] > 0), wo[:, 2] / np.maximum(pdf, 1e-12), 0)
    values = material.f(wi, wo) * weight[:, None] * radiance
    picture = np.zeros((2 * rings, 2 * rings, 3))
    picture[sphere.mask()] = values.reshape(-1, count, 3).mean(axis=1)
    return picture


def error(images: list[np.ndarray], truth: np.ndarray) -> float:
    """The relative mean squared error of pictures on the sphere."""
    inside = sphere.mask()
    return float(np.mean([metrics.relative_mse(i[inside], truth[inside]) for i in images]))


if __name__ == "__main__":
    main()
