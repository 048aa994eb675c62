"""Energy and errors of the right walk and of its faulty variants.

    python -m figures.simulator_biases.compute

Every result has one value for each walk of `variants.VARIANTS`.
"""

import functools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.evaluation import benchmark, samples
from benchmarks.evaluation.samples import GROUPS
from benchmarks.quality import benchmark_set

import urushi
from figures import results
from figures.simulator_biases.variants import VARIANTS
from urushi.walk.simulate import albedo

FOLDER = Path(__file__).parent
PARTS = results.parts_folder("simulator_biases")
#: GGX widths and relative indices of the furnaces, and the index and width that stay.
ALPHAS = (0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.14, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0)
ETAS = (1.05, 1.1, 1.2, 1.3, 1.4, 1.5, 1.7, 2.0, 2.5, 3.0)
ETA, ALPHA = 1.5, 0.02
#: Angle of incidence [degrees].
INCIDENT = 30.0
#: Optical depths of the medium above the bottoms whose interior light is measured.
DEPTHS = (0.0, 1.0)
#: Width of the coat above them.
COAT_ALPHA = 0.1
#: Walks of an albedo, and of a pair of directions.
WALKS, PAIR_WALKS = 1 << 22, 1 << 15
SEED = 11
#: The held-out stacks of the paper's Table 2 in the stored benchmark set.
STACKS = tuple(group for group in GROUPS if group.name == "two, table2")


def main() -> None:
    """Compute what is missing and write results.json."""
    parts: dict[str, Any] = {
        "furnace_alpha": functools.partial(furnace, ALPHAS, (ETA,), WALKS),
        "furnace_eta": functools.partial(furnace, (ALPHA,), ETAS, WALKS),
        "interior": functools.partial(interior, ALPHAS, WALKS),
        "table2": functools.partial(table2, PAIR_WALKS),
    }
    results.write(FOLDER / "results.json", results.collect(PARTS, parts))


def incident() -> np.ndarray:
    """The unit vector wi (1, 3) of all albedos."""
    angle = np.radians(INCIDENT)
    return np.array([[np.sin(angle), 0, np.cos(angle)]], np.float32)


def furnace(alphas: Sequence[float], etas: Sequence[float], walks: int) -> dict[str, Any]:
    """Directional albedo, with standard errors, of clear coats over equally rough mirrors."""
    stacks = [
        urushi.coat(urushi.conductor(alpha=alpha, r0=1), alpha, eta, albedo=1, sigma_t=0)
        for alpha in alphas
        for eta in etas
    ]
    return albedos(stacks, walks)


def interior(alphas: Sequence[float], walks: int) -> dict[str, Any]:
    """Directional albedo of rough mirrors below a coat without absorption; `top` is its surface's.

    One list for each of `DEPTHS`.
    """
    found: dict[str, Any] = {}
    for depth in DEPTHS:
        medium = {"albedo": 1, "sigma_t": depth}
        stacks = [
            urushi.coat(urushi.conductor(alpha=alpha, r0=1), COAT_ALPHA, ETA, **medium)
            for alpha in alphas
        ]
        found[f"depth {depth:g}"] = albedos(stacks, walks)
    black = urushi.coat(urushi.diffuse(0), COAT_ALPHA, ETA, albedo=0, sigma_t=0)
    found["top"] = float(albedo(black, incident(), walks=walks, seed=SEED)[0][0, 0])
    return found


def albedos(stacks: Sequence[Any], walks: int) -> dict[str, Any]:
    """Albedo and standard error of every stack, by the walk's name."""
    found = {}
    for name, variant in VARIANTS.items():
        with variant():
            values = [albedo(stack, incident(), walks=walks, seed=SEED) for stack in stacks]
        mean, se = np.array(values)[:, :, 0, 0].T
        found[name] = {"albedo": results.rounded(mean, 5), "se": results.rounded(se, 2)}
    return found


def table2(walks: int, stacks: int | None = None) -> dict[str, Any]:
    """How far each fault would move the values of Table 2 stacks; by the fault's name.

    E is the error of the faulty value, `energy` the relative change of sum f cos cos, both over the
    pairs of the stored set. The two walks share their random numbers. `noise` is E of the right
    walk against the stored values.
    """
    (stored,) = benchmark.read(groups=STACKS).values()
    count = len(stored.table) if stacks is None else stacks
    table = benchmark_set.first(stored.table, count)
    part = slice(None), slice(None, samples.E_PAIRS)
    wi, wo = stored.wi[:count][part], stored.wo[:count][part]
    values = {}
    for name, variant in VARIANTS.items():
        with variant():
            values[name], _ = samples.walk_all(table, wi, wo, walks, SEED)
    reference = values.pop("right")
    error = functools.partial(samples.error_metrics.stack_error, cos_i=wi[..., 2], cos_o=wo[..., 2])
    weight = samples.error_metrics.energy_weight(wi[..., 2], wo[..., 2])
    found: dict[str, Any] = {"noise": results.rounded(error(reference, stored.f[:count][part]))}
    for name, f in values.items():
        change = (weight * (f - reference)).sum(1) / (weight * reference).sum(1)
        found[name] = {
            "E": results.rounded(error(f, reference)),
            "energy": results.rounded(change),
        }
    return found


if __name__ == "__main__":
    main()
