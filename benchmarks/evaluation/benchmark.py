"""The stored benchmark set: reference values that networks are compared with by default.

One safetensors file of about 1 MB, made by `benchmarks/evaluation/benchmark_set.py`. It holds, for
every group that must be simulated, the stacks' parameters, f in single and its standard error in
half precision, the values at the probe pairs and the directional albedo. The pairs of directions
are drawn again from the seed; the last pair of every stack is stored to detect if other pairs are
drawn.
"""

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.distributions import to_dict
from benchmarks.evaluation.samples import GROUPS, Group, Samples

from urushi import files
from urushi.checks import CoatParameters
from urushi.core.probe_pairs import PROBES
from urushi.errors import FileError
from urushi.walk import StackTable
from urushi.walk.bottoms import KINDS

#: Seed of the stored set.
SEED = 0
KIND = "benchmark"
_REMEDY = "restore it from the repository"


def default_path() -> Path:
    return Path(__file__).with_name("benchmark.safetensors")


def read(
    path: str | os.PathLike | None = None, groups: tuple[Group, ...] = GROUPS
) -> dict[str, Samples]:
    """Read a set that `benchmark_set` wrote; groups without coats are evaluated.

    Args:
        path: the file; default: the stored set.
        groups: to return.

    Raises:
        FileError: missing, foreign, or made for other groups.
    """
    path = default_path() if path is None else path
    description, arrays = files.read_tensors(path, KIND)
    stored = {group["name"]: group for group in description["groups"]}
    result = {}
    for group in groups:
        if not group.distribution.coats:
            table = sampling.draw_stacks(group, description["seed"])
            wi, wo = sampling.draw_pairs(group, description["seed"])
            f = sampling.evaluate_bottoms(table, wi, wo)
            result[group.name] = Samples(table, wi, wo, f, np.zeros_like(f))
        elif stored.get(group.name) != describe(group):
            raise FileError(
                f"the benchmark set '{path}' lacks the group '{group.name}' or was made for other "
                f"stacks of that name; {_REMEDY}"
            )
        else:
            prefix = f"{group.name}."
            own = {k.removeprefix(prefix): v for k, v in arrays.items() if k.startswith(prefix)}
            result[group.name] = _samples(path, group, description["seed"], own)
    return result


def _samples(
    path: str | os.PathLike, group: Group, seed: int, arrays: Mapping[str, np.ndarray]
) -> Samples:
    """A group's set from its stored arrays and its directions, drawn again."""
    wi, wo = sampling.draw_pairs(group, seed)
    # Within rounding: sines may differ in the last digit between machines.
    if not np.allclose(np.stack([wi[:, -1], wo[:, -1]], 1), arrays["last_pair"], atol=1e-5):
        raise FileError(
            f"the directions of the benchmark set '{path}' cannot be reproduced: another NumPy or "
            f"another Urushi made it; {_REMEDY}"
        )
    kind = group.distribution.bottom
    columns = dict(zip(CoatParameters._fields, np.moveaxis(arrays["coats"], -1, 0), strict=True))
    bottom = dict(zip(KINDS[kind].parameters, arrays["bottom"].T, strict=True))
    return Samples(
        table=StackTable(**columns, kind=kind, bottom=bottom),
        wi=wi,
        wo=wo,
        f=arrays["f"],
        se=arrays["se"].astype(np.float32),
        probed={coats: arrays[f"probed{coats}"] for coats in group.probed},
        albedo=arrays["albedo"],
        albedo_se=arrays["albedo_se"],
    )


def describe(group: Group) -> dict[str, object]:
    return {
        "name": group.name,
        "distribution": to_dict(group.distribution),
        "stacks": group.stacks,
        "probed": list(group.probed),
        "pairs": [sampling.E_PAIRS, sampling.P_PAIRS, PROBES],
    }
