"""Time to load a coat with textured parameters: `python -m benchmarks.speed.baking`; minutes.

The coat has RGB textures of 2048² texels (`--side` sets another size) for alpha, albedo, sigma_t
and g. Prints the time in which the plugin `neural_layered` loads over a constant bottom, and over a
rough conductor whose width and reflectance are textures; the peak memory of the process, textures
included; and the times of an edit, of writing a file and of reading it. Textures hold noise of 8
bits, as images do, and hardly two texels are equal. With `--float`, noise has single precision, and
no two channels are equal either. The last row is a clear coat over Mitsuba's `principled` with a
wood of 2048 x 1571 texels as its colour and another map as its roughness. Every row is measured in
a process of its own.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from urushi.nets.weights import DEFAULT
from urushi.platform import available_cores

ROWS = ("one bottom", "textured bottom", "wood")

#: Size of the wood.
WIDTH, HEIGHT = 2048, 1571


def measure(side: int, weights: str | None, bottom: str, levels: int) -> None:
    """Print one row, in this process."""
    import mitsuba as mi

    import urushi  # noqa: F401  (registers the plugins)

    mi.set_variant("llvm_ad_rgb")
    rng = np.random.default_rng(0)

    def texture(low: float, high: float, channels: int):
        noise = rng.random((side, side, channels), np.float32)
        if levels:
            noise = np.floor(noise * levels) / levels
        pixels = (low + (high - low) * noise).astype(np.float32)
        return mi.load_dict({"type": "bitmap", "bitmap": mi.Bitmap(pixels), "raw": True})

    base: dict = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2}
    if bottom == ROWS[1]:
        base |= {"alpha": texture(0.05, 0.5, 1), "specular_reflectance": texture(0.1, 1, 3)}
    coat = {
        "type": "neural_layered",
        "weights": weights or DEFAULT,
        "alpha": texture(0.02, 0.3, 1),
        "albedo": texture(0, 1, 3),
        "sigma_t": texture(0, 2, 3),
        "g": texture(-0.5, 0.5, 1),
        "base": mi.load_dict(base),
    }
    small = {**coat, "resolution": 2}
    mi.load_dict(small)  # compiles kernels, which are then stored
    start, cpu = time.perf_counter(), time.process_time()
    bsdf = mi.load_dict(coat)
    wall, cpu = time.perf_counter() - start, time.process_time() - cpu
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    parameters = mi.traverse(bsdf)
    pixels = np.array(parameters["albedo.data"])
    pixels[: side // 64, : side // 64] = 0.5
    parameters["albedo.data"] = mi.TensorXf(pixels)
    edit = _timed(parameters.update)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "coat.safetensors"
        save = _timed(lambda: bsdf.save(path))
        size = path.stat().st_size / 2**20
        described = {"type": "neural_brdf", "filename": str(path), "weights": coat["weights"]}
        reload = _timed(lambda: mi.load_dict(described))
    print(
        f"{bottom:17}{wall:8.1f} s{cpu:8.1f} s{peak:8.2f} GB{edit:8.2f} s{size:8.0f} MB"
        f"{save:8.2f} s{reload:8.2f} s"
    )


def measure_wood() -> None:
    """Print the row of the wood, in this process."""
    import mitsuba as mi

    import urushi  # noqa: F401  (registers the plugins)

    mi.set_variant("llvm_ad_rgb")
    rng = np.random.default_rng(0)
    v, u = np.meshgrid(np.arange(HEIGHT) / HEIGHT, np.arange(WIDTH) / WIDTH, indexing="ij")
    waves = sum(np.sin(2 * np.pi * (a * u + b * v)) / a for a, b in ((2, 1), (5, 2), (11, 3)))
    ring = 0.5 + 0.5 * np.sin(2 * np.pi * (12 * u + 0.7 * waves))
    grain = 1 + rng.normal(0, 0.06, (HEIGHT, WIDTH, 1)) + rng.normal(0, 0.012, (HEIGHT, WIDTH, 3))
    dark, light = np.array([0.36, 0.2, 0.1]), np.array([0.72, 0.5, 0.3])
    colour = (dark + (light - dark) * ring[..., None]) * grain
    rough = 0.3 + 0.4 * ring[..., None] + rng.normal(0, 0.02, (HEIGHT, WIDTH, 1))

    def texture(values: np.ndarray, raw: bool) -> dict:
        pixels = np.uint8(np.clip(255 * values, 0, 255))
        return {"type": "bitmap", "bitmap": mi.Bitmap(pixels), "raw": raw}

    base = {"base_color": texture(colour, False), "roughness": texture(rough, True)}
    coat = {"type": "neural_layered", "alpha": 0.05, "base": {"type": "principled", **base}}
    mi.load_dict({**coat, "resolution": 2})  # compiles kernels, which are then stored
    cpu = time.process_time()
    wall = _timed(lambda: mi.load_dict(coat))
    print(f"{'wood':17}{wall:8.1f} s{time.process_time() - cpu:8.1f} s")


def _timed(operation) -> float:
    start = time.perf_counter()
    operation()
    return time.perf_counter() - start


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.speed.baking",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--weights", help="networks: a name or file; default: the default ones")
    parser.add_argument("--side", type=int, default=2048, help="side of the textures [texels]")
    parser.add_argument("--float", action="store_true", help="noise of single precision")
    parser.add_argument("--row", choices=ROWS, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.row == ROWS[2]:
        measure_wood()
        return
    if arguments.row:
        levels = 0 if arguments.float else 255
        measure(arguments.side, arguments.weights, arguments.row, levels)
        return
    print(f"{arguments.side}² texels, {arguments.weights or DEFAULT}, {available_cores()} cores")
    print(
        f"{'':17}{'load':>10}{'CPU':>10}{'peak':>11}{'edit':>10}{'file':>11}{'save':>10}{'reload':>10}"
    )
    for row in ROWS:
        subprocess.run([sys.executable, *sys.orig_argv[1:], "--row", row], check=True)


if __name__ == "__main__":
    main()
