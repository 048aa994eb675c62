"""Parts of a figure's results: computed once, kept in files, collected for the plot."""

import json
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.machine import processor
from tqdm import tqdm

from urushi.core import error_metrics as metrics
from urushi.files import atomic_write
from urushi.nets.weights import default_model

#: Resamples of a bootstrap interval, and its coverage.
RESAMPLES, COVERAGE = 10_000, 0.95


def parts_folder(name: str) -> Path:
    """The folder of a figure's finished parts, which are of the shipped weights."""
    return Path("out/figures") / default_model().fingerprint / name


def collect(folder: Path, parts: dict[str, Callable[[], Any]]) -> dict[str, Any]:
    """Results of all parts; those with a file `NAME.json` in the folder are read from it.

    A run that is stopped loses the part in progress alone. Delete a file to compute it again.

    Args:
        folder: where the files are; it is made.
        parts: by name, a function that returns JSON values.
    """
    folder.mkdir(parents=True, exist_ok=True)
    results = {}
    for name, compute in tqdm(parts.items(), desc=folder.name, unit="part", disable=None):
        path = folder / f"{name}.json"
        if not path.is_file():
            text = json.dumps(compute())
            with atomic_write(path) as temporary:
                temporary.write_text(text + "\n")
        results[name] = json.loads(path.read_text())
    return results


def write(path: Path, results: dict[str, Any]) -> None:
    """Write a figure's results as JSON, with the date and the processor."""
    stamped = {"date": date.today().isoformat(), "processor": processor(), **results}
    text = json.dumps(stamped, indent=1)
    with atomic_write(path) as temporary:
        temporary.write_text(text + "\n")


def write_pictures(path: Path, pictures: dict[str, np.ndarray]) -> None:
    """Write pictures (..., H, W, 3) of linear radiance by name, in half precision, for the plot."""
    with atomic_write(path) as temporary:
        np.savez(temporary, **{name: np.float16(picture) for name, picture in pictures.items()})


def shown_pictures(path: Path) -> dict[str, np.ndarray]:
    """Pictures that `write_pictures` wrote, as sRGB values in [0, 1]."""
    with np.load(path) as file:
        return {name: metrics.shown(file[name].astype(np.float32)) for name in file}


def interval(values: np.ndarray, seed: int = 0) -> tuple[float, float]:
    """Bootstrap interval of a mean, at `COVERAGE` (Efron 1979, percentile method)."""
    values = np.asarray(values, float)
    rng = np.random.default_rng(seed)
    means = values[rng.integers(len(values), size=(RESAMPLES, len(values)))].mean(axis=1)
    low, high = np.percentile(means, 50 * np.array([1 - COVERAGE, 1 + COVERAGE]))
    return float(low), float(high)


def rounded(values: np.ndarray, digits: int = 4) -> list:
    """Values as nested lists of few significant digits, which keep committed files small."""
    flat = [float(f"{x:.{digits}g}") for x in np.asarray(values, float).ravel()]
    return np.array(flat).reshape(np.shape(values)).tolist()
