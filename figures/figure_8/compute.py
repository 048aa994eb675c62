"""Errors and lobes of stacks of two to six interfaces.

    python -m figures.figure_8.compute

Each number of interfaces has `STACKS` stacks of the paper's Table 2, which no training has seen.
Coats are layered one by one; figures are of the codes. The reference is the walk, to an error of
0.3 %.
"""

import functools
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.evaluation import predict, samples
from benchmarks.evaluation.distributions import Table2
from benchmarks.evaluation.samples import Group
from benchmarks.quality import benchmark_set
from research.rivals import belcour

import urushi
from figures import results
from urushi.nets.weights import default_model

FOLDER = Path(__file__).parent
PARTS = results.parts_folder("figure_8")
#: Numbers of interfaces, and stacks of each.
INTERFACES, STACKS = (2, 3, 4, 5, 6), 32
#: Seed of the stacks and walks.
SEED = 8
#: Angles of the lobes: incident, and outgoing in the plane of incidence [degrees].
INCIDENT, OUTGOING = 45.0, np.linspace(-85.0, 85.0, 86)
#: Walks of a lobe's values, and gold's reflectance at normal incidence.
WALKS, GOLD = 1 << 15, (1.0, 0.78, 0.34)


def main() -> None:
    """Compute what is missing and write results.json."""
    parts = {f"interfaces_{n}": functools.partial(errors, n, STACKS) for n in INTERFACES}
    parts["lobes"] = functools.partial(lobes, WALKS)
    found = results.collect(PARTS, parts)
    results.write(FOLDER / "results.json", {"weights": default_model().fingerprint, **found})


def errors(interfaces: int, stacks: int) -> dict[str, Any]:
    """E of networks and of Belcour 2018, and the reference's own error, of each stack."""
    group = Group(f"figure 8, {interfaces} interfaces", Table2(interfaces - 1), stacks)
    held_out = benchmark_set.simulate(group, SEED)
    model = default_model()
    f = predict.evaluate(predict.materials(model, held_out), held_out.wi, held_out.wo)
    row = np.repeat(np.arange(stacks, dtype=np.uint32), held_out.wi.shape[1])
    operators = belcour.rows(
        held_out.table, row, held_out.wi.reshape(-1, 3), held_out.wo.reshape(-1, 3)
    ).reshape(f.shape)
    return {
        "networks": results.rounded(samples.stack_errors(f, held_out)),
        "Belcour 2018": results.rounded(samples.stack_errors(operators, held_out)),
        "reference": results.rounded(samples.reference_error(held_out)[0]),
    }


def lobes(walks: int) -> dict[str, Any]:
    """f cos θo of gold under one to five coats, by walk and networks; the green channel."""
    angle = np.radians(OUTGOING)
    wo = np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], axis=-1)
    tilt = np.radians(INCIDENT)
    wi = np.tile([-np.sin(tilt), 0, np.cos(tilt)], (len(wo), 1))
    found: dict[str, Any] = {"walk": [], "se": [], "networks": []}
    reference: Any = urushi.conductor(alpha=0.12, r0=GOLD)
    material: Any = reference
    for interfaces in INTERFACES:
        # Interfaces become rougher towards the bottom.
        alpha = 0.05 + 0.03 * (INTERFACES[-1] - interfaces)
        medium = {"albedo": 0.7, "sigma_t": 0.25, "g": 0.4}
        reference = urushi.coat(reference, alpha, 1.5 if interfaces % 2 else 1.3, **medium)
        top = urushi.dielectric(alpha=alpha, eta=1.5 if interfaces % 2 else 1.3)
        material = urushi.layer(top, material, **medium)
        coded = replace(material, table=None)
        f, se = urushi.simulate(reference, wi, wo, walks=walks, seed=SEED)
        for name, values in (("walk", f), ("se", se), ("networks", coded.f(wi, wo))):
            found[name].append(results.rounded(values[:, 1] * wo[:, 2]))
    return found


if __name__ == "__main__":
    main()
