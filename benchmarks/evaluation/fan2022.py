"""Errors of the networks of Fan et al. 2022: `python -m benchmarks.evaluation.fan2022 WEIGHTS`.

They are measured on the held-out stacks whose indices are all above one, in minutes to hours.
"""

from collections.abc import Mapping
from functools import partial

import numpy as np
import tyro
from benchmarks.evaluation import benchmark, physical_laws, predict, report
from benchmarks.evaluation.samples import ROWS, Samples
from benchmarks.showing import table
from fan2022.material import Material
from fan2022.networks import PaperNetworks, projection_pairs

from urushi.errors import FileError
from urushi.walk import StackTable


def covered(stacks: StackTable) -> bool:
    """Whether all indices of refraction of the stacks are above one, as the networks need."""
    bottom = [stacks.bottom["eta"]] if stacks.kind == "dielectric" else []
    return bool(np.concatenate([stacks.eta.ravel(), *bottom]).min(initial=np.inf) >= 1)


def materials(
    networks: PaperNetworks, samples: Samples, encoded: int = 0, *, how: str = "code"
) -> list[Material]:
    """The stacks as `predict.materials` makes them; `how` changes nothing."""
    stacks = samples.table
    codes = networks.encode(predict.lower_values(samples, encoded, *projection_pairs()))
    for index in reversed(range(stacks.coats - encoded)):
        codes = networks.layer(codes, predict.coats_at(stacks, index))
    return [Material(code[None], networks) for code in codes]


def evaluate(networks: PaperNetworks, sets: Mapping[str, Samples] | None = None) -> str:
    """A table of the errors E and P, and of reciprocity, over all stacks that are `covered`.

    sets: stacks by group; by default the stored ones.
    """
    sets = benchmark.read() if sets is None else sets
    names = {name for name, samples in sets.items() if covered(samples.table)}
    rows = tuple(row for row in ROWS if names.issuperset(row.groups))
    found, layered = report.measure_errors(partial(materials, networks), sets, rows)
    laws = physical_laws.reciprocity_and_sign(sets, layered)
    figures = table(["law", "value"], [[law.name, f"{law.value:.4g}"] for law in laws])
    errors = report.errors_table(found)
    return "\n\n".join([f"networks {networks.fingerprint}", errors, figures])


def main(weights: tyro.conf.Positional[str]) -> None:
    """Print the tables.

    Args:
        weights: file of the networks, see docs/published.md.
    """
    try:
        print(evaluate(PaperNetworks.read(weights)))
    except FileError as error:
        raise SystemExit(str(error)) from error


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
