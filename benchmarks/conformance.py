"""Errors of an implementation of OpenPBR: `python -m benchmarks.conformance`.

Prints E and the error of the albedo, in per cent, of the plugin `openpbr` and of OpenPBR's closed
forms, or with `--values FILE` of another renderer. The reference is one safetensors file: f of 40
coated materials by random walks through the coat, at 300 pairs of directions of cosine density on
both sides. docs/conformance.md describes its format. `--make FILE` simulates the values of its
materials and pairs again from fixed seeds, in about a minute on two cores of an AMD EPYC.
"""

import os
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
import tyro
from benchmarks.measures import bsdf_values, channel_errors, coat_errors, moved
from benchmarks.showing import table
from research.rivals import openpbr_recipe
from tqdm import tqdm

from urushi import files
from urushi.checks import finite
from urushi.errors import ParameterError
from urushi.files import read_npz
from urushi.openpbr_surface.description import openpbr

KIND, FILE = "conformance", Path(__file__).with_suffix(".safetensors")

#: Walks of a pair in one evaluation, evaluations of the pilot run, and greatest number of
#: evaluations. From the pilot run follows how many are needed for a standard error with an E of
#: `ERROR`.
WALKS, PILOT, MOST_ROUNDS, ERROR = 1024, 2, 64, 0.004

#: Arrays of the reference by name: wi and wo float32 (N, 3), unit vectors above the horizon, z the
#: normal, x the tangent; f and se float32 (M, N, 3) [1/sr], mean and standard error, linear sRGB,
#: without cosine.
Arrays = dict[str, np.ndarray]


def read() -> tuple[dict[str, dict[str, Any]], Arrays]:
    """Parameters of the M materials by their names, and values, of the file that ships.

    Raises:
        FileError: missing or damaged.
    """
    description, arrays = files.read_tensors(FILE, KIND)
    return {entry["name"]: entry["parameters"] for entry in description["materials"]}, arrays


def errors(values: np.ndarray, reference: Arrays) -> np.ndarray:
    """E and error of the albedo (M, 2) of values (M, N, 3) [1/sr] of a renderer.

    Raises:
        ParameterError: the shape is not the reference's, or a value is not finite.
    """
    (values,) = finite(f=values)
    if values.shape != reference["f"].shape:
        raise ParameterError(
            f"f has the shape {values.shape}; give one of {reference['f'].shape}: materials, pairs "
            "and channels of the reference"
        )
    both = zip(values, reference["f"], strict=True)
    return np.array([coat_errors(*pair, reference["wi"], reference["wo"]) for pair in both])


def errors_table(names: Iterable[str], reference: Arrays, results: Mapping[str, np.ndarray]) -> str:
    """E and error of the albedo [%] by material and renderer, and the reference's noise."""
    noise = errors(moved(reference["f"], reference["se"]), reference)[:, 0]
    found = np.stack(list(results.values()), axis=1)
    rows = [
        [name, *(f"{100 * e:.2f} / {100 * a:+.1f}" for e, a in own), f"{100 * noise[k]:.2f}"]
        for k, (name, own) in enumerate(zip(names, found, strict=True))
    ]
    found = np.abs(found)
    for name, whole in (("mean", np.mean), ("95th percentile", partial(np.percentile, q=95))):
        cells = [f"{100 * e:.2f} / {100 * a:.1f}" for e, a in whole(found, axis=0)]
        rows.append([name, *cells, f"{100 * whole(noise):.2f}"])
    return table(["E / error of the albedo [%]", *results, "noise"], rows)


def simulate(
    parameters: Mapping[str, Any], wi: np.ndarray, wo: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """f and its standard error, float32 (N, 3), by random walks through the coat.

    The pilot run is discarded, so that the number of walks does not depend on the values.
    """
    bsdf = openpbr(reference=True, **parameters).bsdf()
    mean, se = _walked(bsdf, wi, wo, range(PILOT))
    factor = channel_errors(mean + se, mean, wi, wo).max() / ERROR
    rounds = min(max(int(np.ceil(PILOT * factor**2)), 1), MOST_ROUNDS)
    mean, se = _walked(bsdf, wi, wo, range(PILOT, PILOT + rounds))
    return mean.astype(np.float32), se.astype(np.float32)


def _walked(
    bsdf: Any, wi: np.ndarray, wo: np.ndarray, rounds: range
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard error (N, 3) of the walks of some rounds."""
    many_wi, many_wo = (np.tile(w, (WALKS, 1)) for w in (wi, wo))
    total, squares = np.zeros((2, len(wi), 3))
    for k in rounds:
        number = np.repeat(k * WALKS + np.arange(WALKS), len(wi)).astype(np.float32)
        values = bsdf_values(bsdf, many_wi, many_wo, number).astype(np.float64)
        values = values.reshape(WALKS, len(wi), 3)
        total, squares = total + values.sum(0), squares + (values**2).sum(0)
    count = WALKS * len(rounds)
    mean = total / count
    return mean, np.sqrt(np.maximum(squares / count - mean**2, 0) / (count - 1))


def write(path: str | os.PathLike) -> None:
    """Simulate the materials of the file that ships at its pairs, and write a file."""
    (description, arrays), (materials, _) = files.read_tensors(FILE, KIND), read()
    simulated = [
        simulate(parameters, arrays["wi"], arrays["wo"])
        for parameters in tqdm(materials.values(), disable=None)
    ]
    f, se = (np.stack(x) for x in zip(*simulated, strict=True))
    files.write_tensors(path, KIND, description, arrays | {"f": f, "se": se})


def main(values: Path | None = None, make: Path | None = None) -> None:
    """Print the table, or make the reference.

    Args:
        values: NPZ file of a renderer: f of (40, 300, 3).
        make: file to write a reference to.
    """
    mi.set_variant("llvm_ad_rgb")
    if make is not None:
        write(make)
        return
    materials, reference = read()
    parameters, pairs = materials.values(), (reference["wi"], reference["wo"])
    if values is None:
        found = {"urushi": [bsdf_values(openpbr(**own).bsdf(), *pairs) for own in parameters]}
        for name in openpbr_recipe.RECIPES:
            found[name] = [openpbr_recipe.f(own, *pairs, recipe=name) for own in parameters]
    else:
        found = {values.stem: read_npz(values, "f")[0]}
    results = {k: errors(np.array(f), reference) for k, f in found.items()}
    print(errors_table(materials, reference, results))


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
