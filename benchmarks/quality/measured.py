"""Measured materials, encoded and by the rivals: `python -m benchmarks.quality.measured FILE... `.

FILEs are MERL tables (.binary), RGL materials (.bsdf), folders of these, or archives (.npz) of
published neural fits of 675 weights each, whose tables in MERL's bins stand in for MERL files. Each
folder or archive is a set of its own, single files together are one, and each set gets a table:

- columns: Urushi's `encoded` and `refined` materials; fits of one and two GGX lobes and a
  Lambertian part, the best of several losses by this very PSNR (`urushi.measured.fits`); a network
  trained for each material (`benchmarks.rivals.nbrdf`). RGL files are made reciprocal first, which
  all   of these are; Mitsuba's plugin `measured` shows how far the files were from it.
- figures: PSNR [dB] and FLIP of spheres, means over the environments, and E (docs/conventions.md)
  in per cent; then the means over materials of all measures, and the worst five by PSNR.

Spheres are free of noise and shown in sRGB, the background is not counted, and every environment is
exposed for a white Lambertian sphere of mean luminance 0.5. By default there are two environments
of Urushi's own; `--envmaps` takes others (HDR or EXR).

About a minute of one core a material, on all cores; results are kept in `--folder`, so that what
was stopped resumes, and new weights cost no new rivals. There also lies SET.json, all figures, and
SET-worst.png: original, refined and ten times their difference. Stand-ins favour NBRDF: they are
themselves made by such networks.
"""

import argparse
import json
import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

import numpy as np
from benchmarks.rivals.contenders import NAMES, Contest, Measured, Result, code
from tqdm import tqdm

import urushi
from urushi.eval import environment, metrics, sphere
from urushi.files import atomic_write, new_folder
from urushi.platform import available_cores

#: Materials that are called the worst, and drawn.
WORST = 5

#: How much differences are brightened in pictures.
BRIGHTER = 10

#: What a worker process must be told before it imports anything: processes share the cores.
ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
}

Results = dict[str, dict[str, Result]]


def find_sets(paths: list[Path], wanted: list[str] | None) -> dict[str, list[Measured]]:
    """The materials by set, those named in `wanted` alone."""
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


def contenders(materials: list[Measured], wanted: list[str]) -> list[str]:
    """Those that apply to a set."""
    return [n for n in wanted if n != "Mitsuba" or all(m.is_rgl for m in materials)]


def hold(contest: Contest, material: Measured, names: list[str]) -> None:
    """What a worker process does: `Contest.hold`."""
    contest.hold(material, names)


def compete(
    contest: Contest, sets: dict[str, list[Measured]], wanted: list[str], jobs: int
) -> None:
    """Fill in all results that are not kept yet."""
    os.environ |= ONE_THREAD
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, spawn) as pool:
        tasks = [
            pool.submit(hold, contest, material, contenders(materials, wanted))
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
        if {"refined", rival} <= set(names):
            wins = sum(r["refined"].look.psnr > r[rival].look.psnr for r in results.values())
            print(f"refined has a higher PSNR than {rival} on {wins} of {len(results)} materials")


def worst(results: Results) -> list[str]:
    """The materials whose refined encoding has the lowest PSNR."""
    return sorted(results, key=lambda name: results[name]["refined"].look.psnr)[:WORST]


def draw(path: Path, contest: Contest, materials: list[Measured], results: Results) -> None:
    """Spheres of materials: original, refined and their difference in every environment."""
    from matplotlib import pyplot as plt

    count = 3 * len(contest.environments)
    figure, axes = plt.subplots(
        len(materials), count, figsize=(1.5 * count, 1.6 * len(materials) + 0.3), squeeze=False
    )
    for row, material in zip(axes, materials, strict=True):
        truth = material.load()
        refined = urushi.encode(truth, contest.weights, refine=True)
        pairs = zip(
            *(sphere.render(f, contest.environments) for f in (truth.f, refined.f)), strict=True
        )
        for i, (light, pair) in enumerate(zip(contest.environments, pairs, strict=True)):
            original, encoded = (metrics.shown(picture) for picture in pair)
            difference = np.clip(BRIGHTER * np.abs(encoded - original), 0, 1)
            psnr = metrics.compare(*pair[::-1], sphere.mask(), flip=False).psnr
            titles = (
                f"original, {light.name}",
                f"refined, {psnr:.1f} dB",
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
            f"{material.name}\n{results[material.name]['refined'].look.psnr:.1f} dB", fontsize=6
        )
    figure.tight_layout(pad=0.4)
    with atomic_write(path) as temporary:
        figure.savefig(temporary, dpi=130)
    plt.close(figure)


def write_json(path: Path, contest: Contest, results: Results) -> None:
    """All figures of a set."""
    content = {
        "environments": [light.name for light in contest.environments],
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


def _mean(several: list[Result]) -> Result:
    looks = metrics.Comparison.mean([r.look for r in several])
    return Result(
        looks,
        float(np.mean([r.error for r in several])),
        float(np.mean([r.seconds for r in several])),
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
    parser.add_argument("--contenders", nargs="+", choices=NAMES, default=list(NAMES))
    parser.add_argument("--envmaps", type=Path, nargs="+", help="default: Urushi's own two")
    parser.add_argument("--weights", default="base", help="base, small, or a weights file")
    parser.add_argument("--folder", type=Path, default=Path("runs/measured"), help="for results")
    parser.add_argument("--jobs", type=int, default=available_cores(), help="processes")
    options = parser.parse_args()
    maps = options.envmaps
    lights = [environment.read(path) for path in maps] if maps else environment.own()
    folder = new_folder(options.folder)
    contest = Contest(
        [sphere.exposed(light) for light in lights],
        options.weights,
        new_folder(folder / "rows"),
        code(options.contenders, options.weights),
    )
    sets = find_sets(options.data, options.materials)
    compete(contest, sets, options.contenders, options.jobs)
    for name, materials in sets.items():
        columns = contenders(materials, options.contenders)
        results = {m.name: {c: contest.result(m, c) for c in columns} for m in materials}
        print(f"\n{name}: {len(materials)} materials, {len(lights)} environments")
        show(results, columns)
        write_json(folder / f"{name}.json", contest, results)
        if "refined" in columns:
            names = worst(results)
            print(f"worst by refined: {', '.join(names)}")
            chosen = [next(m for m in materials if m.name == n) for n in names]
            draw(folder / f"{name}-worst.png", contest, chosen, results)


if __name__ == "__main__":
    main()
