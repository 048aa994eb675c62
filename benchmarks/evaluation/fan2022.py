"""Errors of the networks of Fan et al. 2022 on the held-out stacks of this evaluation."""

from collections.abc import Mapping
from functools import partial

import numpy as np
from benchmarks.evaluation import benchmark, physical_laws, predict, report
from benchmarks.evaluation.samples import GROUPS, ROWS, Samples
from fan2022.material import Material
from fan2022.networks import PaperNetworks, projection_pairs

from urushi.walk import StackTable


def covered(table: StackTable) -> bool:
    """Whether all indices of refraction of the stacks are above one, as the networks need."""
    bottom = [table.bottom["eta"]] if table.kind == "dielectric" else []
    return bool(np.concatenate([table.eta.ravel(), *bottom]).min(initial=np.inf) >= 1)


def materials(
    networks: PaperNetworks, samples: Samples, encoded: int = 0, *, how: str = "code"
) -> list[Material]:
    """The stacks as `predict.materials` makes them; `how` changes nothing."""
    table = samples.table
    codes = networks.encode(predict.lower_values(samples, encoded, *projection_pairs()))
    for index in reversed(range(table.coats - encoded)):
        codes = networks.layer(codes, predict.coats_at(table, index))
    return [Material(code[None], networks) for code in codes]


def evaluate(networks: PaperNetworks, sets: Mapping[str, Samples] | None = None) -> str:
    """A table of the errors E and P, and of reciprocity, over all stacks that are `covered`.

    sets: stacks by group; by default the stored ones.
    """
    sets = benchmark.read() if sets is None else sets
    groups = tuple(g for g in GROUPS if g.name in sets and covered(sets[g.name].table))
    names = {group.name for group in groups}
    rows = tuple(row for row in ROWS if names.issuperset(row.groups))
    found = report.measure_errors(partial(materials, networks), sets, groups=groups, rows=rows)
    width = max(len(row.name) for row in rows)
    lines = [f"networks {networks.fingerprint}", "", *report.error_lines(found.rows, width), ""]
    for law in physical_laws.reciprocity_and_sign(sets, found.materials):
        lines.append(f"{law.name:<{width}} {law.value:.4g}")
    return "\n".join(lines)
