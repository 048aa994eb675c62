"""The evaluation of networks: every figure of the table, as text, JSON and plots."""

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from urushi.eval import benchmark, cost, metrics, physical_laws, predict, table
from urushi.eval import samples as sampling
from urushi.eval.groups import GROUPS, ROWS, Group, Row
from urushi.eval.samples import Samples
from urushi.files import atomic_write, new_folder
from urushi.material import Material
from urushi.nets.weights import Model, Weights, find


@dataclass(frozen=True)
class Result:
    """All figures of one evaluation.

    Attributes:
        fingerprint: of the networks.
        reference: where the reference values are from, in words.
        rows: by row name, stacks and by metric "E" (over stacks) and "P" (over all pairs): mean,
            median, p95 and reference, the reference's own error (mean of E, median of P).
        laws: the laws of physics.
        parameters: trained numbers by network.
        seconds: times by operation.
        errors: by group, E of its stacks, coat after coat layered.
    """

    fingerprint: str
    reference: str
    rows: dict[str, dict[str, Any]]
    laws: list[physical_laws.Figure]
    parameters: dict[str, int]
    seconds: dict[str, float]
    errors: dict[str, np.ndarray]


def report(
    weights: Weights | None = None,
    output: str | os.PathLike | None = None,
    *,
    seed: int | None = None,
) -> str:
    """Measure networks and tabulate the figures.

    Args:
        weights: the networks: "base" (the default), "small", a weights file, or a Model.
        output: folder to write figures.json and the plots to.
        seed: simulate other held-out stacks by this seed, which takes long; default: compare with
            the stored set.

    Raises:
        FileError: the weights or the stored set are missing or damaged, or `output` cannot be
            written.
    """
    model = find(weights)
    folder = None if output is None else new_folder(output)
    sets = benchmark.read() if seed is None else sampling.simulate_all(GROUPS, seed)
    source = "the stored set" if seed is None else f"simulated by seed {seed}"
    result = measure(model, sets, source=source)
    if folder is not None:
        write_json(folder / "figures.json", result)
        from urushi.eval.plots import errors, lobes  # lazily: matplotlib is an extra

        errors.draw(folder / "errors.png", sets, result.errors)
        lobes.draw(folder / "worst.png", model, sets, result.errors)
    return table.text(result)


class _Way(NamedTuple):
    """How materials of a group's stacks are made, see `groups.Row`."""

    group: str
    encoded: int = 0
    refined: bool = False


def measure(
    model: Model,
    sets: Mapping[str, Samples],
    *,
    groups: tuple[Group, ...] = GROUPS,
    rows: tuple[Row, ...] = ROWS,
    source: str = "",
) -> Result:
    """Take all figures of networks on the groups' sets."""
    made: dict[_Way, list[Material]] = {}
    values: dict[_Way, np.ndarray] = {}
    by_name = {group.name: group for group in groups}
    for row in rows:
        for name in row.groups:
            way = _Way(name, row.coats(by_name[name]), row.refined)
            if way not in made:
                made[way] = predict.materials(model, sets[name], way.encoded, refined=way.refined)
                values[way] = predict.evaluate(made[way], sets[name].wi, sets[name].wo)
    layered = {way.group: group for way, group in made.items() if way == _Way(way.group)}
    return Result(
        fingerprint=model.fingerprint,
        reference=source,
        rows={
            row.name: _row(
                [(sets[n], values[_Way(n, row.coats(by_name[n]), row.refined)]) for n in row.groups]
            )
            for row in rows
        },
        laws=physical_laws.measure(model, sets, layered),
        parameters=cost.parameters(model),
        seconds=cost.seconds(model),
        errors={name: sampling.stack_errors(values[_Way(name)], sets[name]) for name in layered},
    )


def _row(parts: list[tuple[Samples, np.ndarray]]) -> dict[str, Any]:
    """Figures over the stacks of several sets together, each with the networks' values."""
    e = np.concatenate([sampling.stack_errors(f_hat, s) for s, f_hat in parts])
    p = np.concatenate([sampling.pair_errors(f_hat, s).ravel() for s, f_hat in parts])
    own = [sampling.reference_error(s) for s, _ in parts]
    own_e, own_p = (np.concatenate(x) for x in zip(*own, strict=True))
    return {
        "stacks": len(e),
        "E": metrics.summary(e) | {"reference": float(own_e.mean())},
        "P": metrics.summary(p) | {"reference": float(np.median(own_p))},
    }


def write_json(path: Path, result: Result) -> None:
    """Write all figures as JSON."""
    content = asdict(result)
    content["laws"] = [asdict(law) | {"kept": law.kept} for law in result.laws]
    content["errors"] = {name: errors.tolist() for name, errors in result.errors.items()}
    with atomic_write(path) as temporary:
        temporary.write_text(json.dumps(content, indent=2) + "\n")
