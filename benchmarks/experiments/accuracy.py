"""Errors of the shipped networks on held-out stacks, and the laws of physics that they keep."""

from collections.abc import Iterable
from dataclasses import asdict
from typing import Any

from benchmarks.evaluation import benchmark, report
from benchmarks.experiment import NETWORKS, Experiment, Found, Options
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


def measure(_: Any, options: Options) -> Found:
    """Rows of errors and laws, as of `report.Result`."""
    found = report.measure(options.model, benchmark.read())
    laws = [asdict(law) | {"kept": law.kept} for law in found.laws]
    return {"rows": found.rows, "laws": laws}


def tables(found: Found) -> list[str]:
    """Tables: the README's, with the laws that are broken; all errors; all laws."""
    rows, laws = found["all"]["rows"], found["all"]["laws"]
    first = [[name, "E " + _quantiles(rows[name]["E"], ("mean", "median"))] for name in FIRST]
    broken = [[f"broken law: {law['name']}", _limited(law)] for law in laws if law["kept"] is False]
    errors = [
        [name, _quantiles(row["E"]), _quantiles(row["P"], ("median",))]
        for name, row in rows.items()
    ]
    kept = {True: "yes", False: "no", None: ""}
    all_laws = [[law["name"], _limited(law), kept[law["kept"]]] for law in laws]
    heads = (
        ["codes on held-out stacks", "mean / median, or value"],
        ["task of the networks", "E mean / median / p95", "P median"],
        ["law", "value", "kept"],
    )
    bodies = first + broken, errors, all_laws
    return [table(head, map(_indented, body)) for head, body in zip(heads, bodies, strict=True)]


def _quantiles(errors: dict[str, float], names: Iterable[str] = ("mean", "median", "p95")) -> str:
    return " / ".join(f"{100 * errors[name]:.2f}" for name in names) + " %"


def _limited(law: dict[str, Any]) -> str:
    """The value of a law, and its limit if it has one."""
    value = f"{law['value']:.4g} {law['unit']}".strip()
    if law["limit"] is None:
        return value
    limit = f"{law['limit']:g} {law['unit']}".strip()
    return f"{value} ({'above' if law['lower'] else 'at most'} {limit})"


def _indented(row: list[str]) -> list[str]:
    """A row whose name begins with two spaces gets a dot, which Markdown shows."""
    name, *others = row
    return [name.replace("  ", "· ") if name[:2] == "  " else name, *others]


EXPERIMENT = Experiment(
    cases=lambda _: {"all": None},
    measure=measure,
    tables=tables,
    pages=("README.md", "docs/results.md", "src/urushi/nets/weights/README.md"),
    models=NETWORKS,
    minutes=1,
)
