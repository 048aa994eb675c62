"""Errors of the shipped networks on held-out stacks, and the laws of physics that they keep."""

from typing import Any

from benchmarks.evaluation import benchmark
from benchmarks.evaluation.report import errors_table, indented, measure, quantiles
from benchmarks.experiment import NETWORKS, Experiment, Found
from benchmarks.showing import table

#: Rows of the README's table.
FIRST = (
    "layer two interfaces, Table 2",
    "  by tables",
    "  by the network",
    "layer three interfaces",
    "layer six interfaces",
    "encode simulated stacks",
)


def tables(found: Found) -> list[str]:
    """Tables: the README's, with the laws that are broken; all errors; all laws.

    Details of a law that are zero are left out.
    """
    rows, laws = found["all"]["rows"], found["all"]["laws"]
    first = [[indented(name), quantiles(rows[name]["E"], ("mean", "median"))] for name in FIRST]
    shown = [law for law in laws if law["value"] or law["limit"] is not None]
    broken = [_line(law) for law in laws if law["kept"] is False]
    return [
        table(["codes on held-out stacks", "E [%]: mean / median"], first + broken),
        errors_table(rows),
        table(["law", "value and limit"], map(_line, shown)),
    ]


def _line(law: dict[str, Any]) -> list[str]:
    """The name of a law, its value and its limit; a broken one is called so."""
    name = f"broken law: {law['name']}" if law["kept"] is False else indented(law["name"])
    value = f"{law['value']:.4g} {law['unit']}".strip()
    if law["limit"] is not None:
        limit = f"{law['limit']:g} {law['unit']}".strip()
        value += f" ({'above' if law['lower'] else 'at most'} {limit})"
    return [name, value]


EXPERIMENT = Experiment(
    lambda _: {"all": None},
    tables,
    lambda _, options: measure(options.model, benchmark.read()),
    pages=("README.md", "docs/results.md", "src/urushi/nets/weights/README.md"),
    models=NETWORKS,
)
