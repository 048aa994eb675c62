"""All figures of networks: errors by row, and laws of physics."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
from benchmarks.evaluation import physical_laws, predict
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.samples import ROWS, Row, Samples
from benchmarks.showing import table

from urushi.nets.weights import Model


def measure_errors(
    predicted: Callable[..., list], sets: Mapping[str, Samples], rows: tuple[Row, ...] = ROWS
) -> tuple[dict[str, dict[str, Any]], dict[str, list]]:
    """Errors E and P of networks on the groups' sets, row by row.

    predicted: from samples, the number of encoded coats and `how` to their materials, as
        `predict.materials` for a model.

    Returns:
        By row name, stacks and by metric "E" (over stacks) and "P" (over all pairs): mean, median,
        p95 and reference, the reference's own error (mean of E, median of P). And by group, the
        materials with every coat layered.
    """
    materials: dict[tuple, list] = {}  # by group, number of encoded coats, and `how`
    values: dict[tuple, np.ndarray] = {}
    found = {}
    for row in rows:
        ways = []
        for name in row.groups:
            held = sets[name]
            coats = held.table.coats if row.encoded < 0 else row.encoded
            ways.append(way := (name, coats, row.how))
            if way not in materials:
                materials[way] = predicted(held, coats, how=row.how)
                values[way] = predict.evaluate(materials[way], held.wi, held.wo)
        found[row.name] = _row([(sets[way[0]], values[way]) for way in ways])
    return found, {way[0]: made for way, made in materials.items() if way[1:] == (0, "code")}


def measure(
    model: Model, sets: Mapping[str, Samples], rows: tuple[Row, ...] = ROWS
) -> dict[str, Any]:
    """All figures of networks on the groups' sets, as JSON values: "rows" of errors, and "laws"."""
    predicted = partial(predict.materials, model)
    errors, layered = measure_errors(predicted, sets, rows)
    exact = {name: predicted(sets[name], how="table") for name in layered}
    laws = physical_laws.measure(model, sets, exact)
    return {"rows": errors, "laws": [asdict(law) | {"kept": law.kept} for law in laws]}


def summary(errors: npt.ArrayLike) -> dict[str, float]:
    """Mean, median and 95th percentile of all `errors`, an array of any shape."""
    median, high = np.percentile(errors, [50, 95])
    return {"mean": float(np.mean(errors)), "median": float(median), "p95": float(high)}


def _row(parts: list[tuple[Samples, np.ndarray]]) -> dict[str, Any]:
    """Figures over the stacks of several sets together, each with the networks' values (S, M)."""
    e = np.concatenate([sampling.stack_errors(f_hat, s) for s, f_hat in parts])
    p = np.concatenate([sampling.pair_errors(f_hat, s).ravel() for s, f_hat in parts])
    # The reference's own error is that of one standard error; of a stack's P the median.
    moved = [(s.f + s.se, s) for s, _ in parts]
    own_e = np.concatenate([sampling.stack_errors(*part) for part in moved])
    own_p = np.concatenate([np.median(sampling.pair_errors(*part), axis=1) for part in moved])
    return {
        "stacks": len(e),
        "E": summary(e) | {"reference": float(own_e.mean())},
        "P": summary(p) | {"reference": float(np.median(own_p))},
    }


def errors_table(rows: Mapping[str, dict[str, Any]]) -> str:
    """The errors of all rows in per cent. The mean of P is left out: dark tails dominate it.

    Rows of equal figures are one.
    """
    found: dict[tuple[str, str], list[str]] = {}
    for name, row in rows.items():
        figures = quantiles(row["E"]), quantiles(row["P"], ("median",))
        found.setdefault(figures, []).append(indented(name))
    cells = []
    for figures, (first, *others) in found.items():  # what is encoded is said once
        names = ", ".join([first, *(name.removeprefix("encode ") for name in others)])
        cells.append([names, *figures])
    return table(["task of the networks", "E [%]: mean / median / p95", "P: median"], cells)


def quantiles(errors: dict[str, float], names: Iterable[str] = ("mean", "median", "p95")) -> str:
    """Some figures of `summary` in per cent."""
    return " / ".join(f"{100 * errors[name]:.2f}" for name in names)


def indented(name: str) -> str:
    """A name that begins with two spaces gets a dot, which Markdown shows."""
    return name.replace("  ", "· ") if name[:2] == "  " else name
