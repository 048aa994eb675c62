"""Speed of whole renders: `python -m benchmarks.speed.render`; 20 minutes on two idle cores.

Default flags, path depth 6, 32 samples per pixel. Prints the table of

- `sphere`: a sphere under an environment map, 512², with one value for every parameter, and with a
  texture for every parameter: the median time of alternating runs of one process, and its ratios to
  `principled` with as many textures and to `layered`, by wall time and by CPU time, which other
  load disturbs less; and the time to compile: the first render minus the later ones, with an empty
  kernel cache;
- `materials`: times to compile and to render one and ten different materials in one scene;
- `scenes`: the demo's and the gallery's scenes, 512 pixels wide: times of the walk, of the networks
  and of `principled` in the place of every coat, and the ratios of the networks to the walk. Ratios
  are medians over alternating runs of the ratio within a run, with their range.

Mitsuba compiles all BSDFs in memory into every kernel, so that every run loads its scene again and
then releases it. `--mode` chooses the variant. `--tables`, `--scenes`, `--weights`, `--side`,
`--spp`, `--detail` and `--runs` shorten the benchmark.
"""

import argparse
import gc
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.nets.weights import DEFAULT
from urushi.platform import available_cores

OTHERS = ("principled", "layered")
TABLES = ("sphere", "materials", "scenes")
TEXELS = 64
MATERIALS = 10
#: Before the file of weights of the system of Fan et al. (2022), where others are a name or a file.
PAPER = "fan2022:"
FRESH = "URUSHI_FRESH_KERNELS"  # set in the measuring process


def texture(low: float, high: float, channels: int, seed: int, side: int = TEXELS) -> dict:
    """A texture of uniform random texels."""
    texels = np.random.default_rng(seed).uniform(low, high, (side, side, channels))
    return {"type": "bitmap", "bitmap": mi.Bitmap(texels.astype(np.float32)), "raw": True}


def value(low: float, high: float, channels: int, seed: int) -> dict | float:
    """One value from the same range."""
    numbers = np.random.default_rng(seed).uniform(low, high, channels).tolist()
    return {"type": "rgb", "value": numbers} if channels == 3 else numbers[0]


def coat(plugin: str) -> dict[str, str]:
    """The type and the weights of a coat by "layered", or by weights."""
    if plugin == "layered":
        return {"type": plugin}
    if plugin.startswith(PAPER):
        return {"type": "fan2022_layered", "weights": plugin.removeprefix(PAPER)}
    return {"type": "neural_layered", "weights": plugin}


def material(plugin: str, textured: bool, seed: int = 0, side: int = TEXELS) -> dict:
    """The sphere's BSDF; plugin: one of `OTHERS`, or weights; side: of textures, in texels."""
    of = partial(texture, side=side) if textured else value
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
    return coat(plugin) | {
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


def first_and_later(make: Callable[[], Any], spp: int) -> tuple[np.ndarray, np.ndarray]:
    """(Wall, CPU) time [s] of a scene's first render, and of the faster of two later ones."""
    loaded = make()
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
            first, later = first_and_later(partial(scene, [material(*case)], side), spp)
            times[case].append(later)
            if run == 0:
                compiling[case] = first - later
    medians = {case: np.median(values, axis=0) for case, values in times.items()}
    print(f"{side}², {spp} spp{'':14}{'seconds':>9}{'principled':>12}{'layered':>9}", end="")
    print(f"{'by CPU time':>13}{'':9}{'compile':>9}{'CPU':>7}")
    for plugin, textured in cases:
        name = plugin if plugin in OTHERS else f"neural_layered, {plugin}"
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
            first, later = first_and_later(partial(scene, bsdfs, side), 1)
            figures = (*(first - later), *later)
            print(f"{plugin:22}{count:9}{{:9.1f}}{{:7.1f}}{{:9.2f}}{{:7.2f}}".format(*figures))


def whole_scenes(given: argparse.Namespace) -> None:
    """Print the table of scenes, in Markdown."""
    from benchmarks.scenes import PRINCIPLED, WALK, describe

    methods = (WALK, PRINCIPLED, *given.weights)
    columns = ("scene", "networks", "walk [s]", f"`{PRINCIPLED}` [s]", "networks [s]")
    columns += ("networks / walk", "range", "by CPU time", "range")
    print(f"\n| {' | '.join(columns)} |\n{'|---' * len(columns)}|", flush=True)
    for name in given.scenes:
        times: dict[str, list[np.ndarray]] = {method: [] for method in methods}
        for _ in range(given.runs):
            for method in methods:
                with tempfile.TemporaryDirectory(prefix="urushi-") as folder:
                    size = {"width": given.side, "detail": given.detail}
                    described = describe(name, method, Path(folder), **size)
                    make = partial(mi.load_dict, described)
                    times[method].append(first_and_later(make, given.spp)[1])
        seconds = {method: np.median(runs, axis=0)[0] for method, runs in times.items()}
        for networks in given.weights:
            cells = [f"{seconds[method]:.2f}" for method in (WALK, PRINCIPLED, networks)]
            for ratio in (np.array(times[networks]) / times[WALK]).T:
                cells += [f"{np.median(ratio):.2f}", f"{ratio.min():.2f} to {ratio.max():.2f}"]
            print(f"| {' | '.join((name, networks, *cells))} |", flush=True)


def main() -> None:
    """Print the tables."""
    from benchmarks.machine import processor
    from benchmarks.scenes import SCENES

    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.speed.render",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--tables", nargs="+", default=TABLES, choices=TABLES, help="tables")
    parser.add_argument("--scenes", nargs="+", default=SCENES, choices=SCENES, help="whole scenes")
    parser.add_argument("--weights", nargs="+", default=[DEFAULT], help="weights of neural_layered")
    parser.add_argument("--side", type=int, default=512, help="width [pixels]")
    parser.add_argument("--detail", type=float, default=1.0, help="scale of the scenes' textures")
    parser.add_argument("--spp", type=int, default=32, help="samples per pixel")
    parser.add_argument("--runs", type=int, default=5, help="number of alternating runs")
    parser.add_argument("--mode", default="llvm_ad_rgb", help="variant of Mitsuba")
    given = parser.parse_args()
    mi.set_variant(given.mode)
    import urushi  # noqa: F401  (registers the plugins)

    plugins = [OTHERS[0], *given.weights, OTHERS[1]]
    print(f"{processor()}, {available_cores()} cores\n")
    if "sphere" in given.tables:
        speed(plugins, given.side, given.spp, given.runs)
    if "materials" in given.tables:
        compiling(plugins, given.side)
    if "scenes" in given.tables:
        whole_scenes(given)


if __name__ == "__main__":
    if FRESH in os.environ:
        main()
    else:  # in a new process, whose home folder has no cached kernels
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, "-m", "benchmarks.speed.render", *sys.argv[1:]]
            subprocess.run(command, env=os.environ | {"HOME": folder, FRESH: "1"}, check=True)
