"""Time to read and encode a measured BRDF: `python -m benchmarks.speed.encode [FILE...]`.

Takes seconds. Prints CPU times, summed over threads, for each file; without files, for a table in
MERL's format that it writes, a rough conductor plus a Lambertian BRDF. The best of several runs.
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import urushi
from urushi.core.directions import directions_at
from urushi.measured import merl
from urushi.measured.tabulated import bin_centres
from urushi.walk import analytic

RUNS = 5


def main() -> None:
    """Print a line for each file."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.speed.encode",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("files", nargs="*", type=Path, help="MERL or RGL files")
    paths = parser.parse_args().files
    print(f"{'CPU seconds':32}{'read':>8}{'encode':>8}{'all':>8}")
    with tempfile.TemporaryDirectory() as folder:
        for path in paths or [synthetic_merl(Path(folder) / "synthetic.binary")]:
            brdf = urushi.load_measured(path)
            read = best(lambda path=path: urushi.load_measured(path))
            encode = best(lambda brdf=brdf: urushi.encode(brdf))
            print(f"{path.name[:31]:32}{read:8.2f}{encode:8.2f}{read + encode:8.2f}")


def best(call: Callable[[], Any]) -> float:
    """The smallest CPU time [s] of several calls."""
    times = []
    for _ in range(RUNS):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return min(times)


def synthetic_merl(path: Path) -> Path:
    """Write a table in MERL's format: a rough conductor plus a Lambertian BRDF."""
    centres = (angle.ravel() for angle in np.broadcast_arrays(*bin_centres(merl.SHAPE)))
    wi, wo = (w.astype(np.float32) for w in directions_at(*centres))
    gold, base = urushi.conductor(0.2, (0.98, 0.77, 0.34)), urushi.diffuse((0.1, 0.05, 0.02))
    f = analytic.f(gold, wi, wo) + analytic.f(base, wi, wo)
    with path.open("wb") as file:
        np.array(merl.SHAPE, "<i4").tofile(file)
        (f / np.array(merl.SCALE)).T.astype("<f8").tofile(file)
    return path


if __name__ == "__main__":
    main()
