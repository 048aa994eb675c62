"""All figures of networks, as a table and JSON."""

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from benchmarks.evaluation import benchmark, physical_laws, predict
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.samples import GROUPS, ROWS, Group, Row, Samples

from urushi import checks
from urushi.errors import ParameterError
from urushi.files import atomic_write, new_folder
from urushi.nets.weights import Model, Weights, find

#: Columns of the errors. The mean of P is left out: a few pairs in dark tails dominate it.
COLUMNS = [("E", "mean"), ("E", "median"), ("E", "p95"), ("E", "reference")]
COLUMNS += [("P", "median"), ("P", "p95"), ("P", "reference")]

_SHORT = {"reference": "ref"}


@dataclass(frozen=True)
class Result:
    """All figures of one evaluation.

    Attributes:
        fingerprint: of the networks.
        rows: by row name, stacks and by metric "E" (over stacks) and "P" (over all pairs): mean,
            median, p95 and reference, the reference's own error (mean of E, median of P).
        laws: the laws of physics.
        parameters: number of trained parameters by network.
        errors: by group, E (S,) of its stacks with every coat layered.
    """

    fingerprint: str
    rows: dict[str, dict[str, Any]]
    laws: list[physical_laws.Figure]
    parameters: dict[str, int]
    errors: dict[str, np.ndarray]


def report(
    weights: Weights | None = None,
    output: str | os.PathLike | None = None,
) -> str:
    """Measure networks; returns the table of all figures as text.

    Args:
        weights: the networks: a name of shipped ones, a weights file, or a Model; default: the
            default networks.
        output: folder to write figures.json to.

    Raises:
        FileError: the weights or the stored set are missing or damaged, or `output` cannot be
            written.
    """
    model = find(weights)
    folder = None if output is None else new_folder(output)
    result = measure(model, benchmark.read())
    if folder is not None:
        write_json(folder / "figures.json", result)
    return table(result)


class Way(NamedTuple):
    """A way to make the materials of a group's stacks, see `groups.Row`."""

    group: str
    encoded: int = 0
    how: str = "code"


class Errors(NamedTuple):
    """The errors of networks on the groups' stacks.

    Attributes:
        rows: as of `Result`.
        materials: by group, the materials with every coat layered.
        stacks: by group, E (S,) of these materials.
    """

    rows: dict[str, dict[str, Any]]
    materials: dict[str, list]
    stacks: dict[str, np.ndarray]


def measure_errors(
    predicted: Callable[..., list],
    sets: Mapping[str, Samples],
    *,
    groups: tuple[Group, ...] = GROUPS,
    rows: tuple[Row, ...] = ROWS,
) -> Errors:
    """Errors E and P of networks on the groups' sets, row by row.

    predicted: from samples, the number of encoded coats and `how` to their materials, as
        `predict.materials` for a model.
    """
    materials: dict[Way, list] = {}
    values: dict[Way, np.ndarray] = {}
    by_name = {group.name: group for group in groups}

    def ways(row: Row) -> list[Way]:
        return [Way(name, row.coats(by_name[name]), row.how) for name in row.groups]

    for way in (way for row in rows for way in ways(row)):
        if way not in materials:
            samples = sets[way.group]
            materials[way] = predicted(samples, way.encoded, how=way.how)
            values[way] = predict.evaluate(materials[way], samples.wi, samples.wo)
    layered = [way for way in materials if way == Way(way.group)]
    return Errors(
        rows={
            row.name: _row([(sets[way.group], values[way]) for way in ways(row)]) for row in rows
        },
        materials={way.group: materials[way] for way in layered},
        stacks={way.group: sampling.stack_errors(values[way], sets[way.group]) for way in layered},
    )


def measure(
    model: Model,
    sets: Mapping[str, Samples],
    *,
    groups: tuple[Group, ...] = GROUPS,
    rows: tuple[Row, ...] = ROWS,
) -> Result:
    """All figures of networks on the groups' sets."""
    predicted = partial(predict.materials, model)
    errors = measure_errors(predicted, sets, groups=groups, rows=rows)
    exact = {name: predicted(sets[name], how="table") for name in errors.materials}
    return Result(
        fingerprint=model.fingerprint,
        rows=errors.rows,
        laws=physical_laws.measure(model, sets, exact),
        parameters=parameters(model),
        errors=errors.stacks,
    )


def parameters(model: Model) -> dict[str, int]:
    """Number of parameters by part."""
    counts: dict[str, int] = {}
    for name, array in model.params.items():
        part = name.split(".", 1)[0]
        counts[part] = counts.get(part, 0) + array.size
    return counts


def summary(errors: npt.ArrayLike) -> dict[str, float]:
    """Mean, median and 95th percentile of all `errors`, an array of any shape."""
    (errors,) = checks.finite(errors=errors)
    if errors.size == 0:
        raise ParameterError("errors is empty; there is nothing to summarise")
    median, high = np.percentile(errors, [50, 95])
    return {"mean": float(errors.mean()), "median": float(median), "p95": float(high)}


def _row(parts: list[tuple[Samples, np.ndarray]]) -> dict[str, Any]:
    """Figures over the stacks of several sets together, each with the networks' values (S, M)."""
    e = np.concatenate([sampling.stack_errors(f_hat, s) for s, f_hat in parts])
    p = np.concatenate([sampling.pair_errors(f_hat, s).ravel() for s, f_hat in parts])
    own = [sampling.reference_error(s) for s, _ in parts]
    own_e, own_p = (np.concatenate(x) for x in zip(*own, strict=True))
    return {
        "stacks": len(e),
        "E": summary(e) | {"reference": float(own_e.mean())},
        "P": summary(p) | {"reference": float(np.median(own_p))},
    }


def write_json(path: Path, result: Result) -> None:
    content = asdict(result)
    content["laws"] = [asdict(law) | {"kept": law.kept} for law in result.laws]
    content["errors"] = {name: errors.tolist() for name, errors in result.errors.items()}
    with atomic_write(path) as temporary:
        temporary.write_text(json.dumps(content, indent=2) + "\n")


def table(result: Result) -> str:
    """The whole table: errors in percent, laws of physics, and sizes."""
    width = max(map(len, [*result.rows, *(law.name for law in result.laws)]))
    lines = [f"networks {result.fingerprint}", ""]
    lines += error_lines(result.rows, width)
    lines += ["", "laws of physics"]
    for law in result.laws:
        lines.append(f"{law.name:<{width}} {law.value:>10.4g} {law.unit:<4} {_limit(law)}".rstrip())
    lines += ["", "parameters"]
    lines += [f"{name:<{width}} {count:>10,}" for name, count in result.parameters.items()]
    return "\n".join(lines)


def error_lines(rows: Mapping[str, dict[str, Any]], width: int) -> list[str]:
    """The lines of the errors in percent; width: of the names."""
    heads = " ".join(f"{metric + ' ' + _SHORT.get(key, key):>8}" for metric, key in COLUMNS)
    lines = [f"{'errors [%]':<{width}} {'stacks':>6} {heads}"]
    for name, row in rows.items():
        numbers = " ".join(f"{100 * row[metric][key]:8.2f}" for metric, key in COLUMNS)
        lines.append(f"{name:<{width}} {row['stacks']:>6} {numbers}")
    return lines


def _limit(law: Any) -> str:
    if law.limit is None:
        return ""
    return f"{'>' if law.lower else '<='} {law.limit:g} {'ok' if law.kept else 'BROKEN'}"
