"""Measured materials, encoded and fitted by other methods: `python -m benchmarks.quality.measured`.

Takes FILEs: MERL tables (.binary), RGL materials (.bsdf), folders of these, or archives (.npz) of
published neural fits of 675 weights each, whose tables in MERL's bins stand in for MERL files. Each
folder or archive is a set, single files together are one, and each set gets a table:

- columns: Urushi's materials by their `code` and by their `table`; fits of
  one and two GGX lobes and a Lambertian part (`benchmarks.rivals.ggx_fit`), for each material the
  best of several losses by PSNR; a network trained for each material
  (`benchmarks.rivals.nbrdf`); and Mitsuba's `measured`. RGL files are made reciprocal first,
  because all other methods are reciprocal; the column of Mitsuba shows how much that changes.
- figures: PSNR [dB] and FLIP of spheres, means over the environments, and E (docs/conventions.md)
  in per cent; then the means of all measures over materials, and the five lowest PSNR.

Spheres are free of noise and displayed in sRGB, the background is not counted, and every
environment is exposed so that a white Lambertian sphere has a mean luminance of 0.5. By default
there are two environments of Urushi; `--envmaps` replaces them (HDR or EXR).

A material takes about a minute of one core, and all cores are used. Results are stored in
`--folder`, so that a stopped run resumes and new weights do not repeat the other methods. SET.json
there has all figures, and SET-worst.png shows original, code and ten times their difference.
Stand-ins favour NBRDF, because such networks made them.
"""

import argparse
import json
import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import numpy as np
from benchmarks.quality import environment_maps, pictures, sphere
from benchmarks.rivals.comparisons import METHODS, Comparisons, Measured, Result, code_hashes
from tqdm import tqdm

import urushi
from urushi.core import error_metrics as metrics
from urushi.files import atomic_write, new_folder
from urushi.platform import available_cores

#: Number of materials that are listed as the worst, and drawn.
WORST = 5

#: Factor by which pictures of differences are brightened.
BRIGHTER = 10

#: Environment of worker processes: one thread each, because the processes share the cores.
ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
}

Results = dict[str, dict[str, Result]]


def find_sets(paths: list[Path], wanted: list[str] | None) -> dict[str, list[Measured]]:
    """The materials of each set; only those named in `wanted`, if it is given."""
    sets: dict[str, list[Measured]] = {}
    for path in paths:
        if path.is_dir():
            files = sorted(f for f in path.iterdir() if f.suffix in (".binary", ".bsdf"))
            found = [Measured(file.stem, file) for file in files]
        elif path.suffix == ".npz":
            with np.load(path) as archive:
                found = [Measured(name, path) for name in archive.files]
        else:
            found = [Measured(path.stem, path)]
        key = path.stem if len(found) != 1 or path.is_dir() else "files"
        sets.setdefault(key, []).extend(m for m in found if not wanted or m.name in wanted)
    return {name: materials for name, materials in sets.items() if materials}


def methods_of(materials: list[Measured], wanted: list[str]) -> list[str]:
    """The methods that apply to all materials of a set."""
    return [n for n in wanted if n != "Mitsuba" or all(m.is_rgl for m in materials)]


def run_material(comparisons: Comparisons, material: Measured, names: list[str]) -> None:
    """Task of a worker process: `Comparisons.run`."""
    comparisons.run(material, names)


def run_all(
    comparisons: Comparisons, sets: dict[str, list[Measured]], wanted: list[str], jobs: int
) -> None:
    """Compute all results that are not stored yet."""
    os.environ |= ONE_THREAD
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, spawn) as pool:
        tasks = [
            pool.submit(run_material, comparisons, material, methods_of(materials, wanted))
            for materials in sets.values()
            for material in materials
        ]
        try:
            for task in tqdm(as_completed(tasks), total=len(tasks), desc="materials"):
                task.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def show(results: Results, names: list[str]) -> None:
    """Print a set's tables."""
    print(f"{'':28}" + "".join(f"{name:>19}" for name in names))
    print(f"{'PSNR [dB], FLIP, E [%]':28}" + f"{'PSNR':>7}{'FLIP':>6}{'E':>6}" * len(names))
    for material, row in results.items():
        print(f"{material:28}" + "".join(_cells(row[name]) for name in names))
    means = {name: _mean([row[name] for row in results.values()]) for name in names}
    print(f"{'mean':28}" + "".join(_cells(means[name]) for name in names))
    worst = [np.sort([r[name].look.psnr for r in results.values()])[:WORST] for name in names]
    print(f"{f'mean of the worst {WORST}':28}" + "".join(f"{w.mean():7.1f}{'':12}" for w in worst))
    print(
        f"\n{'means':10}{'MAE':>8}{'RMSE':>8}{'PSNR':>8}{'SSIM':>8}{'FLIP':>8}{'E [%]':>8}{'s':>8}"
    )
    for name, mean in means.items():
        look = mean.look
        print(
            f"{name:10}{look.mae:8.4f}{look.rmse:8.4f}{look.psnr:8.2f}{look.ssim:8.4f}"
            f"{look.flip:8.4f}{100 * mean.error:8.2f}{mean.seconds:8.2f}"
        )
    for rival in ("GGX", "two GGX", "NBRDF"):
        if {"code", rival} <= set(names):
            higher = sum(r["code"].look.psnr > r[rival].look.psnr for r in results.values())
            print(
                f"the code has a higher PSNR than {rival} on {higher} of {len(results)} materials"
            )


def worst(results: Results) -> list[str]:
    """The materials whose code has the lowest PSNR."""
    return sorted(results, key=lambda name: results[name]["code"].look.psnr)[:WORST]


def draw(path: Path, comparisons: Comparisons, materials: list[Measured], results: Results) -> None:
    """Spheres of materials: original, code and their difference in every environment."""
    from matplotlib import pyplot as plt

    count = 3 * len(comparisons.environments)
    figure, axes = plt.subplots(
        len(materials), count, figsize=(1.5 * count, 1.6 * len(materials) + 0.3), squeeze=False
    )
    for row, material in zip(axes, materials, strict=True):
        truth = material.load()
        coded = urushi.encode(truth, comparisons.weights, table=False)
        pairs = zip(
            *(sphere.render(f, comparisons.environments) for f in (truth.f, coded.f)), strict=True
        )
        for i, (light, pair) in enumerate(zip(comparisons.environments, pairs, strict=True)):
            original, encoded = (metrics.shown(picture) for picture in pair)
            difference = np.clip(BRIGHTER * np.abs(encoded - original), 0, 1)
            psnr = pictures.compare(*pair[::-1], sphere.mask(), flip=False).psnr
            titles = (
                f"original, {light.name}",
                f"code, {psnr:.1f} dB",
                f"difference x {BRIGHTER}",
            )
            for place, picture, title in zip(
                row[3 * i : 3 * i + 3], (original, encoded, difference), titles, strict=True
            ):
                place.imshow(picture)
                place.set_title(title, fontsize=6)
                place.set_xticks([])
                place.set_yticks([])
        row[0].set_ylabel(
            f"{material.name}\n{results[material.name]['code'].look.psnr:.1f} dB", fontsize=6
        )
    figure.tight_layout(pad=0.4)
    with atomic_write(path) as temporary:
        figure.savefig(temporary, dpi=130)
    plt.close(figure)


def write_json(path: Path, comparisons: Comparisons, results: Results) -> None:
    """All figures of a set."""
    content = {
        "environments": [light.name for light in comparisons.environments],
        "materials": {
            material: {
                name: {**r.look.as_dict(), "E": r.error, "seconds": r.seconds}
                for name, r in row.items()
            }
            for material, row in results.items()
        },
    }
    with atomic_write(path) as temporary:
        temporary.write_text(json.dumps(content, indent=1) + "\n")


def _cells(result: Result) -> str:
    return f"{result.look.psnr:7.1f}{result.look.flip:6.3f}{100 * result.error:6.1f}"


def _mean(results: list[Result]) -> Result:
    looks = pictures.Comparison.mean([r.look for r in results])
    return Result(
        looks,
        float(np.mean([r.error for r in results])),
        float(np.mean([r.seconds for r in results])),
    )


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.measured",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("data", type=Path, nargs="+", help="files, folders or archives")
    parser.add_argument("--materials", nargs="+", help="names; default: all")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS))
    parser.add_argument("--envmaps", type=Path, nargs="+", help="default: Urushi's own two")
    parser.add_argument("--weights", help="networks: a name or file; default: the default ones")
    parser.add_argument(
        "--folder", type=Path, default=Path("runs/measured"), help="folder of results"
    )
    parser.add_argument("--jobs", type=int, default=available_cores(), help="number of processes")
    options = parser.parse_args()
    maps = options.envmaps
    lights = [environment_maps.read(path) for path in maps] if maps else sphere.own_environments()
    folder = new_folder(options.folder)
    comparisons = Comparisons(
        [sphere.exposed(light) for light in lights],
        options.weights,
        new_folder(folder / "rows"),
        code_hashes(options.methods, options.weights),
    )
    sets = find_sets(options.data, options.materials)
    run_all(comparisons, sets, options.methods, options.jobs)
    for name, materials in sets.items():
        columns = methods_of(materials, options.methods)
        results = {m.name: {c: comparisons.result(m, c) for c in columns} for m in materials}
        print(f"\n{name}: {len(materials)} materials, {len(lights)} environments")
        show(results, columns)
        write_json(folder / f"{name}.json", comparisons, results)
        if "code" in columns:
            names = worst(results)
            print(f"worst by code: {', '.join(names)}")
            chosen = [next(m for m in materials if m.name == n) for n in names]
            draw(folder / f"{name}-worst.png", comparisons, chosen, results)


if __name__ == "__main__":
    main()
