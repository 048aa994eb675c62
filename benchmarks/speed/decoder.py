"""Speed of the decoder alone: `python -m benchmarks.speed.decoder`; two minutes on two idle cores.

Prints millions of RGB evaluations of f per second, the best of several alternating runs. The second
column is computed from CPU time, times the number of cores: the speed of an idle machine. The rows
are constant codes, and textured codes, for which every evaluation computes the codes' part of the
first layer again.
"""

import argparse
import os
import time
from collections.abc import Callable

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.material.material import Material
from urushi.nets.weights import DEFAULT

COUNT, RUNS = 1 << 20, 7


def directions(seed: int) -> "mi.Vector3f":
    """COUNT unit vectors, uniformly distributed over the hemisphere."""
    rng = np.random.default_rng(seed)
    z, phi = rng.uniform(0.01, 1, COUNT), rng.uniform(0, 2 * np.pi, COUNT)
    r = np.sqrt(1 - z * z)
    return mi.Vector3f(np.stack([r * np.cos(phi), r * np.sin(phi), z]).astype(np.float32))


def evaluations(weights: str) -> dict[str, Callable[[], object]]:
    """For each row of the table, a function that evaluates the decoder."""
    from urushi.mitsuba.latents.holders import ConstantLatents, TexturedLatents
    from urushi.nets.weights import find
    from urushi.textures.store import IDENTITY, TexelGrid, TextureStore

    model = find(weights)
    rng = np.random.default_rng(0)
    codes = rng.normal(size=(64 * 64, 3, model.arch.latent)).astype(np.float32)
    store = TextureStore(model, 3, len(codes))
    store.write(np.arange(len(codes)), codes)
    grid = TexelGrid(64, 64, IDENTITY, "repeat", False)
    si = dr.zeros(mi.SurfaceInteraction3f, COUNT)
    si.wi, wo = directions(1), directions(2)
    si.uv = mi.Point2f(rng.random((2, COUNT), np.float32))
    dr.eval(si, wo)

    def of(latents) -> Callable[[], object]:
        return lambda: latents.f(latents.vertex(si, mi.Bool(True)), si, wo, mi.Bool(True))

    return {
        "constant codes": of(ConstantLatents(Material(codes[0], model))),
        "textured codes": of(TexturedLatents(model, store, grid)),
    }


def seconds(evaluate: Callable[[], object]) -> tuple[float, float]:
    """Wall and CPU time of one kernel [s]."""
    f = evaluate()
    wall, cpu = time.perf_counter(), time.process_time()
    dr.eval(f)
    dr.sync_thread()
    return time.perf_counter() - wall, time.process_time() - cpu


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.speed.decoder",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--weights", nargs="+", default=[DEFAULT], help="names or files")
    given = parser.parse_args()
    cases = {(name, form): f for name in given.weights for form, f in evaluations(name).items()}
    times: dict[tuple, list] = {case: [] for case in cases}
    for run in range(RUNS + 1):
        for case, evaluate in cases.items():
            result = seconds(evaluate)
            if run:  # the first run compiles
                times[case].append(result)
    cores = len(os.sched_getaffinity(0))
    print(f"{'million RGB evaluations per second':40}{'wall':>8}{f'CPU x {cores}':>9}")
    for (name, form), values in times.items():
        wall, cpu = COUNT / 1e6 / np.min(values, axis=0)
        print(f"{name:10}{form:30}{wall:8.2f}{cores * cpu:9.2f}", flush=True)


if __name__ == "__main__":
    mi.set_variant("llvm_ad_rgb")
    main()
