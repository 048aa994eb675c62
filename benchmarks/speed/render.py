"""Speed of whole renders: `python -m benchmarks.speed.render`; 15 minutes on two idle cores.

The scene is a sphere under an environment map, 512², 32 samples per pixel, path depth 6,
`llvm_ad_rgb`, default flags; with one value for every parameter, and with a texture for every
parameter. Prints

- the median time of alternating runs of one process, and its ratios to `principled` with as many
  textures and to `layered`, by wall time and by CPU time, which other load disturbs less;
- the time to compile: the first render minus the later ones, with an empty kernel cache;
- times to compile and to render one and ten different materials in one scene.

Mitsuba compiles all BSDFs in memory into every kernel, so that every run loads its scene again and
then releases it. `--side`, `--spp` and `--runs` shorten the benchmark; `--only` selects plugins.
"""

import argparse
import gc
import os
import subprocess
import sys
import tempfile
import time

import drjit as dr
import mitsuba as mi
import numpy as np

PLUGINS = ("principled", "small", "base", "layered")
TEXELS = 64
MATERIALS = 10
FRESH = "URUSHI_FRESH_KERNELS"  # set in the measuring process


def texture(low: float, high: float, channels: int, seed: int) -> dict:
    """A texture of uniform random texels."""
    texels = np.random.default_rng(seed).uniform(low, high, (TEXELS, TEXELS, channels))
    return {"type": "bitmap", "bitmap": mi.Bitmap(texels.astype(np.float32)), "raw": True}


def value(low: float, high: float, channels: int, seed: int) -> dict | float:
    """One value from the same range."""
    numbers = np.random.default_rng(seed).uniform(low, high, channels).tolist()
    return {"type": "rgb", "value": numbers} if channels == 3 else numbers[0]


def material(plugin: str, textured: bool, seed: int = 0) -> dict:
    """The sphere's BSDF; plugin: one of `PLUGINS`."""
    of = texture if textured else value
    if plugin == "principled":
        return {
            "type": "principled",
            "base_color": of(0.2, 0.95, 3, seed + 1),
            "roughness": of(0.1, 0.6, 1, seed + 2),
            "metallic": of(0, 1, 1, seed + 3),
            "clearcoat": of(0.1, 1, 1, seed + 4),
            "clearcoat_gloss": of(0.3, 0.9, 1, seed + 5),
        }
    bottom = {
        "type": "roughconductor",
        "distribution": "ggx",
        "alpha": of(0.05, 0.4, 1, seed + 1),
        "specular_reflectance": of(0.3, 0.95, 3, seed + 2),
    }
    kind = {"type": "layered"} if plugin == "layered" else {"type": "neural_layered"}
    return kind | ({} if plugin == "layered" else {"weights": plugin}) | {
        "alpha": of(0.02, 0.3, 1, seed + 3),
        "albedo": of(0.2, 0.95, 3, seed + 4),
        "sigma_t": of(0.1, 2, 3, seed + 5),
        "g": of(-0.3, 0.6, 3, seed + 6),
        "bottom": bottom,
    }  # fmt: skip


def scene(bsdfs: list[dict], side: int) -> "mi.Scene":
    """Spheres of these BSDFs in a row, which fills the picture, under an environment map."""
    sky = np.random.default_rng(0).uniform(0.5, 1.5, (64, 128, 1)).repeat(3, axis=2)
    sky[10:16, 30:40] = 20
    count = len(bsdfs)
    look = mi.ScalarTransform4f().look_at([0, 0, 4.2], [0, 0, 0], [0, 1, 0])
    spheres = {
        f"sphere {i}": {
            "type": "sphere",
            "center": [(2 * i + 1) / count - 1, 0, 0],
            "radius": 1 / count,
            "bsdf": bsdf,
        }
        for i, bsdf in enumerate(bsdfs)
    }
    film = {"type": "hdrfilm", "width": side, "height": side, "rfilter": {"type": "box"}}
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 6},
            "sensor": {"type": "perspective", "fov": 30, "to_world": look, "film": film},
            "sky": {"type": "envmap", "bitmap": mi.Bitmap(sky.astype(np.float32))},
        }
        | spheres
    )


def rendered(loaded: "mi.Scene", spp: int, seed: int) -> tuple[float, float]:
    """Wall and CPU time of one render [s]."""
    wall, cpu = time.perf_counter(), time.process_time()
    dr.eval(mi.render(loaded, spp=spp, seed=seed))
    dr.sync_thread()
    return time.perf_counter() - wall, time.process_time() - cpu


def first_and_later(bsdfs: list[dict], side: int, spp: int) -> tuple[np.ndarray, np.ndarray]:
    """(Wall, CPU) time [s] of the first render, and of the faster of two later ones."""
    loaded = scene(bsdfs, side)
    first = np.array(rendered(loaded, spp, 0))
    later = np.min([rendered(loaded, spp, seed) for seed in (1, 2)], axis=0)
    del loaded
    gc.collect()
    return first, later


def speed(plugins: list[str], side: int, spp: int, runs: int) -> None:
    """Print the table of render times."""
    cases = [(plugin, textured) for textured in (False, True) for plugin in plugins]
    times: dict[tuple, list[np.ndarray]] = {case: [] for case in cases}
    compiling = {}
    for run in range(runs):
        for case in cases:
            first, later = first_and_later([material(*case)], side, spp)
            times[case].append(later)
            if run == 0:
                compiling[case] = first - later
    medians = {case: np.median(values, axis=0) for case, values in times.items()}
    print(f"{side}², {spp} spp{'':14}{'seconds':>9}{'principled':>12}{'layered':>9}", end="")
    print(f"{'by CPU time':>13}{'':9}{'compile':>9}{'CPU':>7}")
    for plugin, textured in cases:
        name = plugin if plugin in ("principled", "layered") else f"neural_layered, {plugin}"
        line = f"{name:22}{'textured' if textured else '':9}{medians[plugin, textured][0]:8.2f}"
        for clock in (0, 1):
            for other, width in (("principled", 12), ("layered", 9)):
                ratio = medians[plugin, textured] / medians.get((other, textured), np.nan)
                line += f"{ratio[clock]:{width}.2f}"
        print(line + "{:9.1f}{:7.1f}".format(*compiling[plugin, textured]), flush=True)


def compiling(plugins: list[str], side: int) -> None:
    """Print the times of one and of ten materials."""
    print(f"\n{'materials in the scene':31}{'compile':>9}{'CPU':>7}{'1 spp':>9}{'CPU':>7}")
    for plugin in plugins:
        if plugin == "layered":
            continue
        for count in (1, MATERIALS):
            bsdfs = [material(plugin, True, 100 * i) for i in range(count)]
            first, later = first_and_later(bsdfs, side, 1)
            figures = (*(first - later), *later)
            print(f"{plugin:22}{count:9}{{:9.1f}}{{:7.1f}}{{:9.2f}}{{:7.2f}}".format(*figures))


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.speed.render",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--side", type=int, default=512, help="width and height [pixels]")
    parser.add_argument("--spp", type=int, default=32, help="samples per pixel")
    parser.add_argument("--runs", type=int, default=5, help="number of alternating runs")
    parser.add_argument("--only", nargs="+", default=PLUGINS, choices=PLUGINS, help="rows")
    given = parser.parse_args()
    speed(given.only, given.side, given.spp, given.runs)
    compiling(given.only, given.side)


if __name__ == "__main__":
    if FRESH in os.environ:
        mi.set_variant("llvm_ad_rgb")
        import urushi  # noqa: F401  (registers the plugins)

        main()
    else:  # in a new process, whose home folder has no cached kernels
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, "-m", "benchmarks.speed.render", *sys.argv[1:]]
            subprocess.run(command, env=os.environ | {"HOME": folder, FRESH: "1"}, check=True)
