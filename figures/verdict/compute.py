"""Errors, laws and costs of all methods that render layered materials, on the same work.

    python -m figures.verdict.compute [--paper FILE]

FILE are weights of the system of Fan et al. (2022): those of a longer training, or the authors'
(`urushi paper`). The default are the weights in this folder. E over measured bottoms needs
the folder that URUSHI_TEST_DATA names.
"""

import argparse
import functools
import os
from pathlib import Path
from typing import Any

import mitsuba as mi
from benchmarks.scenes import LIGHTS

from figures import results
from figures.light.compute import SCENES
from figures.verdict import costs, errors, lights
from urushi.fan2022 import PaperNetworks
from urushi.nets.weights import anisotropic_model, default_model

FOLDER = Path(__file__).parent
#: The system of Fan et al. (2022), trained here; see the README.
PAPER = FOLDER / "fan2022.safetensors"
PARTS = results.parts_folder("verdict")
#: Numbers of interfaces.
INTERFACES = (1, 2, 3, 4, 5, 6)


def main() -> None:
    """Compute what is missing and write results.json."""
    parser = argparse.ArgumentParser(prog="python -m figures.verdict.compute", description=__doc__)
    parser.add_argument(
        "--paper",
        default=str(PAPER),
        metavar="FILE",
        help="weights of the system of Fan et al. (2022)",
    )
    weights = parser.parse_args().paper
    mi.set_variant("llvm_ad_rgb")
    found = results.collect(PARTS, parts(weights))
    head = {
        "weights": default_model().fingerprint,
        "anisotropic weights": anisotropic_model().fingerprint,
        "paper weights": PaperNetworks.read(weights).fingerprint,
    }
    results.write(FOLDER / "results.json", {**head, **found})


def parts(weights: str) -> dict[str, Any]:
    """The functions of all parts by name; weights: file of the paper's system."""
    paper = PaperNetworks.read(weights)
    functions: dict[str, Any] = {
        "evaluations": functools.partial(costs.evaluations, weights),
        "renders": functools.partial(costs.renders, weights),
        "memory": functools.partial(costs.memory, True),
        "new": functools.partial(costs.new_materials, paper),
    }
    for n in INTERFACES:
        functions[f"interfaces_{n}"] = functools.partial(errors.isotropic, n, paper)
    for surface in ("coat", "bottom"):
        functions[f"anisotropic_{surface}"] = functools.partial(errors.anisotropic, surface)
    functions["laws"] = functools.partial(errors.laws, paper)
    if "URUSHI_TEST_DATA" in os.environ:
        functions["measured"] = functools.partial(
            errors.measured, Path(os.environ["URUSHI_TEST_DATA"]), paper
        )
    for scene in SCENES:
        for light in LIGHTS:
            functions[f"{scene}, {light}"] = functools.partial(lights.part, scene, light, weights)
    return functions


if __name__ == "__main__":
    main()
