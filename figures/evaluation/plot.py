"""Prints the tables of the shipped networks' errors and laws: python -m figures.evaluation.plot."""

import json
from collections.abc import Iterable
from typing import Any

from figures import page
from figures.evaluation.compute import FOLDER

#: Rows of the README's table.
FIRST = (
    "layer two interfaces, Table 2",
    "  by tables",
    "  by the network",
    "layer three interfaces",
    "layer six interfaces",
    "encode simulated stacks",
)


def main() -> None:
    """Print the tables."""
    print("\n\n".join(tables(json.loads((FOLDER / "results.json").read_text()))))


def tables(found: dict[str, Any]) -> list[str]:
    """Tables: the README's, with the laws that are broken; all errors; all laws."""
    rows, laws = found["rows"], found["laws"]
    first = [[name, "E " + quantiles(rows[name]["E"], ("mean", "median"))] for name in FIRST]
    broken = [[f"broken law: {law['name']}", limited(law)] for law in laws if law["kept"] is False]
    errors = [
        [name, quantiles(row["E"]), quantiles(row["P"], ("median",))] for name, row in rows.items()
    ]
    return [
        page.table(
            ["codes on held-out stacks", "mean / median, or value"], indented(first + broken)
        ),
        page.table(["task of the networks", "E mean / median / p95", "P median"], indented(errors)),
        page.table(["law", "value", "kept"], indented([row_of(law) for law in laws])),
    ]


def quantiles(errors: dict[str, float], names: Iterable[str] = ("mean", "median", "p95")) -> str:
    """Errors in per cent."""
    return " / ".join(f"{100 * errors[name]:.2f}" for name in names) + " %"


def valued(law: dict[str, Any]) -> str:
    return f"{law['value']:.4g} {law['unit']}".strip()


def limited(law: dict[str, Any]) -> str:
    """The value of a law and its limit."""
    limit = f"{law['limit']:g} {law['unit']}".strip()
    return f"{valued(law)} ({'above' if law['lower'] else 'at most'} {limit})"


def row_of(law: dict[str, Any]) -> list[str]:
    kept = {True: "yes", False: "no", None: ""}[law["kept"]]
    return [law["name"], valued(law) if law["limit"] is None else limited(law), kept]


def indented(rows: list[list[str]]) -> list[list[str]]:
    """Rows whose names begin with two spaces get a dot, which Markdown shows."""
    return [[name.replace("  ", "· ") if name[:2] == "  " else name, *row] for name, *row in rows]


if __name__ == "__main__":
    main()
