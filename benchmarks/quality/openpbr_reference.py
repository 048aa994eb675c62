"""Reference values of coated OpenPBR: `python -m benchmarks.quality.openpbr_reference FILE`.

Simulates the 40 materials of `benchmarks.quality.conformance` from fixed seeds, in about a minute
on two cores of an AMD EPYC. A file that exists is continued: its materials are kept if their
parameters are the same.
"""

import argparse
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks.quality.conformance import (
    KIND,
    PAIRS,
    VERSION,
    bsdf_values,
    channel_errors,
    read,
)

from urushi import files
from urushi.core import direction_sets
from urushi.openpbr_surface.description import openpbr

#: Seed from which the pairs are drawn.
SEED = 20260

#: Walks of a pair in one evaluation, evaluations of the pilot run, and greatest number of
#: evaluations. The pilot run tells how many give the `ERROR`, E of one standard error.
WALKS, PILOT, MOST_ROUNDS, ERROR = 1024, 2, 64, 0.004

_BASES: dict[str, dict[str, Any]] = {
    "gold": {
        "base_metalness": 1.0,
        "base_color": (0.94, 0.76, 0.38),
        "specular_color": (1.0, 0.98, 0.87),
    },
    "rough steel": {
        "base_metalness": 1.0,
        "base_color": (0.6, 0.58, 0.56),
        "specular_roughness": 0.6,
    },
    "brushed aluminium": {
        "base_metalness": 1.0,
        "base_color": (0.91, 0.92, 0.92),
        "specular_roughness": 0.4,
        "specular_roughness_anisotropy": 0.6,
    },
    "red plastic": {"base_color": (0.6, 0.05, 0.04)},
    "white paint": {"base_color": (0.8, 0.8, 0.8), "specular_weight": 0.0},
    "clay": {
        "base_color": (0.55, 0.35, 0.25),
        "base_diffuse_roughness": 0.8,
        "specular_roughness": 0.7,
    },
    "metallic lacquer": {
        "base_metalness": 0.5,
        "base_color": (0.1, 0.25, 0.6),
        "specular_roughness": 0.4,
    },
    "enamel": {
        "base_color": (0.05, 0.1, 0.3),
        "specular_roughness": 0.35,
        "specular_ior": 2.0,
    },
}

_COATS: dict[str, dict[str, Any]] = {
    "clear": {"coat_roughness": 0.25},
    "satin": {"coat_roughness": 0.6},
    "varnish": {"coat_roughness": 0.3, "coat_color": (0.9, 0.55, 0.2)},
    "half": {
        "coat_weight": 0.5,
        "coat_roughness": 0.4,
        "coat_color": (0.4, 0.7, 0.9),
        "coat_ior": 1.8,
    },
    "brushed": {
        "coat_roughness": 0.45,
        "coat_roughness_anisotropy": 0.5,
        "coat_ior": 1.35,
        "coat_color": (0.7, 0.9, 0.75),
    },
}

#: The materials: parameters of OpenPBR by name. Every base is under every coat.
MATERIALS: dict[str, dict[str, Any]] = {
    f"{base}, {coat}": {"coat_weight": 1.0, **below, **above}
    for base, below in _BASES.items()
    for coat, above in _COATS.items()
}


def pairs() -> tuple[np.ndarray, np.ndarray]:
    """The pairs (`PAIRS`, 3), float32."""
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(SEED), PAIRS, lowest_cosine=0.02)
    return np.asarray(wi, np.float32), np.asarray(wo, np.float32)


def simulate(
    parameters: Mapping[str, Any], *, walks: int = WALKS, rounds: int = MOST_ROUNDS
) -> tuple[np.ndarray, np.ndarray]:
    """f and its standard error, float32 (`PAIRS`, 3), by random walks through the coat.

    The pilot run is discarded, so that the number of walks does not depend on the values.

    Args:
        parameters: of the material.
        walks: of a pair in one round.
        rounds: greatest number of rounds.
    """
    bsdf = openpbr(reference=True, **parameters).bsdf()
    wi, wo = pairs()
    mean, se = _walked(bsdf, wi, wo, walks, range(PILOT))
    factor = channel_errors(mean + se, mean, wi, wo).max() / ERROR
    needed = min(max(int(np.ceil(PILOT * factor**2)), 1), rounds)
    mean, se = _walked(bsdf, wi, wo, walks, range(PILOT, PILOT + needed))
    return mean.astype(np.float32), se.astype(np.float32)


def _walked(
    bsdf: Any, wi: np.ndarray, wo: np.ndarray, walks: int, rounds: range
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard error (N, 3) of the walks of some rounds."""
    many_wi, many_wo = (np.tile(w, (walks, 1)) for w in (wi, wo))
    total, squares = np.zeros((2, len(wi), 3))
    for k in rounds:
        number = np.repeat(k * walks + np.arange(walks), len(wi)).astype(np.float32)
        values = (
            bsdf_values(bsdf, many_wi, many_wo, number)
            .astype(np.float64)
            .reshape(walks, len(wi), 3)
        )
        total, squares = total + values.sum(0), squares + (values**2).sum(0)
    count = walks * len(rounds)
    mean = total / count
    return mean, np.sqrt(np.maximum(squares / count - mean**2, 0) / (count - 1))


def make(path: str | os.PathLike, report: Callable[[str], None] = print) -> None:
    """Simulate all materials and write the file; it is written after each one.

    A file that exists is continued: its materials are kept if their parameters are the same.

    Raises:
        FileError: the file cannot be written, or exists and is another kind.
    """
    done: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    if Path(path).exists():
        old = read(path)
        same = [np.array_equal(a, b) for a, b in zip((old.wi, old.wo), pairs(), strict=True)]
        for k, (name, parameters) in enumerate(old.parameters.items()):
            if all(same) and name in MATERIALS and parameters == _plain(MATERIALS[name]):
                done[name] = old.f[k], old.se[k]
    for name, parameters in MATERIALS.items():
        if name in done:
            continue
        done[name] = simulate(parameters)
        _write(path, {key: done[key] for key in MATERIALS if key in done})
        report(f"{len(done)} of {len(MATERIALS)}: {name}")


def _write(path: str | os.PathLike, values: Mapping[str, tuple[np.ndarray, np.ndarray]]) -> None:
    wi, wo = pairs()
    description = {
        "version": VERSION,
        "seed": SEED,
        "walks": {"round": WALKS, "rounds": MOST_ROUNDS, "error": ERROR},
        "licence": "CC0-1.0",
        "materials": [{"name": k, "parameters": _plain(MATERIALS[k])} for k in values],
    }
    f, se = (np.stack([pair[k] for pair in values.values()]) for k in range(2))
    files.write_tensors(path, KIND, description, {"wi": wi, "wo": wo, "f": f, "se": se})


def _plain(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters as JSON has them."""
    return {k: list(v) if isinstance(v, tuple) else v for k, v in parameters.items()}


def main() -> None:
    """Write the file."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.openpbr_reference",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", type=Path, help="file to write")
    mi.set_variant("llvm_ad_rgb")
    make(parser.parse_args().file)


if __name__ == "__main__":
    main()
