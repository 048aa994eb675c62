"""Variance times seconds of the bidirectional estimator beside the walk's.

    python -m benchmarks.quality.estimators
    python -m benchmarks.quality.estimators --spheres

Prints a Markdown table. The variance is the mean of the squared relative errors over 32 pairs, and
the ratio is that of the walk over that of the bidirectional estimator: above 1, the latter is
better at equal time. With `--spheres`, the same of pictures: spheres of the plugin `layered` under
a point light, where the noise is that of the walks, and under a sky, where it is also that of the
light's directions.
"""

import argparse
import time

import mitsuba as mi
import numpy as np

import urushi
from urushi.walk.estimators import ESTIMATORS

METAL, WHITE = urushi.conductor(alpha=0.3, r0=0.9), urushi.diffuse(0.7)


def layered(bottom, coats, **medium):
    """A bottom under equal coats, of indices 1.5 and 1.3 in turn."""
    for number in range(coats):
        bottom = urushi.coat(bottom, 0.15, 1.3 if number % 2 else 1.5, **medium)
    return bottom


CASES = {
    "clear coat on metal": layered(METAL, 1, albedo=1, sigma_t=0),
    "depth 1, g 0, on metal": layered(METAL, 1, albedo=0.95, sigma_t=1),
    "depth 1, g 0.9, on metal": layered(METAL, 1, albedo=0.95, sigma_t=1, g=0.9),
    "depth 4, g 0.9, on metal": layered(METAL, 1, albedo=0.95, sigma_t=4, g=0.9),
    "depth 4, g 0.95, on metal": layered(METAL, 1, albedo=0.95, sigma_t=4, g=0.95),
    "depth 16, g 0, on white": layered(WHITE, 1, albedo=0.99, sigma_t=16),
    "depth 16, g 0.9, on white": layered(WHITE, 1, albedo=0.99, sigma_t=16, g=0.9),
    "two coats, depth 1, g 0.9, on metal": layered(METAL, 2, albedo=0.95, sigma_t=1, g=0.9),
    "four coats, depth 0.5, g 0.5, on metal": layered(METAL, 4, albedo=0.95, sigma_t=0.5, g=0.5),
}


#: Media of the spheres: properties of `layered` over `METAL`.
COLOUR = {"type": "rgb", "value": [0.95, 0.8, 0.5]}
DEPTHS = {"type": "rgb", "value": [1.0, 2.0, 4.0]}
SPHERES = {
    f"{name}, g {g}": {"sigma_t": sigma_t, "albedo": COLOUR, "g": g}
    for name, sigma_t in (("depth 1", 1.0), ("depth 4", 4.0), ("depths 1, 2, 4 by channel", DEPTHS))
    for g in (0.0, 0.9)
}
#: Side of a sphere's picture [pixels], samples of a pixel, and pictures of other seeds.
SIDE, SAMPLES, PICTURES = 32, 64, 8


def main() -> None:
    """Measure all cases and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--walks", type=int, default=1 << 15, help="walks per pair")
    parser.add_argument("--spheres", action="store_true", help="render spheres in place of pairs")
    options = parser.parse_args()
    print("| stack | variance | seconds | variance × seconds |\n|---|---|---|---|")
    if options.spheres:
        for light in ("point light", "sky"):
            for name, medium in SPHERES.items():
                line(f"{light}: {name}", *(render(medium, light, e) for e in ESTIMATORS))
        return
    wi, wo = directions(32)
    for name, stack in CASES.items():
        line(name, *(measure(stack, wi, wo, options.walks, e) for e in ESTIMATORS))


def line(name: str, walk: tuple[float, float], both: tuple[float, float]) -> None:
    """Print a line of the table: ratios of two variances, of two times and of their products."""
    variance, seconds = (a / b for a, b in zip(walk, both, strict=True))
    print(f"| {name} | {variance:.2g} | {seconds:.2g} | {variance * seconds:.2g} |", flush=True)


def directions(count: int) -> np.ndarray:
    """Two arrays (count, 3) of unit vectors whose cosines are at least 0.2."""
    rng = np.random.default_rng(1)
    cosine, angle = rng.uniform(0.2, 1, (2, count)), rng.uniform(0, 2 * np.pi, (2, count))
    sine = np.sqrt(1 - cosine**2)
    return np.stack([sine * np.cos(angle), sine * np.sin(angle), cosine], axis=-1)


def measure(stack, wi, wo, walks, estimator) -> tuple[float, float]:
    """Mean squared relative standard error, and CPU seconds; the kernel is compiled before."""
    for count in (2, walks):
        start = time.process_time()
        f, se = urushi.simulate(
            stack, wi, wo, walks=count, seed=1, progress=False, estimator=estimator
        )
    return float(np.mean((se / f) ** 2)), time.process_time() - start


def render(medium: dict, light: str, estimator: str) -> tuple[float, float]:
    """Mean squared relative error of a sphere's pixels, and CPU seconds of a picture.

    The mean is over pixels and channels of the sphere. The kernel is compiled before.
    """
    mi.set_variant("llvm_ad_rgb")
    scene = sphere(medium, light, estimator)
    mi.render(scene, spp=1, seed=PICTURES)
    mi.render(scene, spp=SAMPLES, seed=PICTURES)
    start = time.process_time()
    pictures = np.stack([mi.render(scene, spp=SAMPLES, seed=i).numpy() for i in range(PICTURES)])
    seconds = time.process_time() - start
    mean = pictures.mean(axis=0)
    seen = mean > 0
    return float((pictures.var(axis=0, ddof=1)[seen] / mean[seen] ** 2).mean()), seconds / PICTURES


def sphere(medium: dict, light: str, estimator: str) -> "mi.Scene":
    """A coated metal sphere under a point light or a sky with a bright spot."""
    sky = np.full((16, 32, 3), 0.2, np.float32)
    sky[3:6, 6:10] = 8
    metal = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.3, "material": "Al"}
    bsdf = {"type": "layered", "alpha": 0.15, "int_ior": 1.5, "ext_ior": 1.0, "base": metal}
    lights = {
        "point light": {"type": "point", "position": [3, 2, 4]},
        "sky": {"type": "envmap", "bitmap": mi.Bitmap(sky)},
    }
    film = {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"}}
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {
                "type": "direct",
                "emitter_samples": 1,
                "bsdf_samples": int(light == "sky"),
                "hide_emitters": True,
            },
            "sensor": {
                "type": "perspective",
                "fov": 24,
                "to_world": mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]),
                "film": film,
            },
            "light": lights[light],
            "sphere": {"type": "sphere", "bsdf": {**bsdf, **medium, "estimator": estimator}},
        }
    )


if __name__ == "__main__":
    main()
