"""The shipped networks hold the published figures: the table "Accuracy" of docs/results.md."""

import re
from functools import partial
from pathlib import Path

import pytest
from benchmarks.evaluation import benchmark, physical_laws, predict, report
from benchmarks.evaluation.samples import ROWS

from urushi.nets import weights

RESULTS = Path(__file__).resolve().parents[2] / "docs" / "results.md"

#: The values are deterministic; the margin is for other CPUs' single-precision arithmetic.
MARGIN = 1.05

#: The published figures are rounded to two decimals [%].
ROUNDING = 0.005

#: Refined rows are left out: they are the same networks with minutes of optimisation.
MEASURED = tuple(row for row in ROWS if not row.refined)

#: The table's header: two columns for each of the networks that it names.
HEADER = re.compile(
    r"^\| what the networks do ((?:\| `[^`]+`: E mean / median / p95 \| P median )+)\|$",
    re.MULTILINE,
)

#: Mean, median and p95 of E, and the median of P, in percent.
Figures = tuple[float, ...]


def published(text: str) -> dict[str, dict[str, Figures | None]]:
    """The table's figures by networks and by row; None for rows that networks do not cover."""
    header = HEADER.search(text)
    assert header is not None, "docs/results.md has the table 'Accuracy'"
    names = re.findall(r"`([^`]+)`", header[1])
    body = text[header.end() :].lstrip("\n").split("\n\n")[0].splitlines()[1:]
    table: dict[str, dict[str, Figures | None]] = {name: {} for name in names}
    for line in body:
        row, *cells = (cell.strip() for cell in line.strip("|").split("|"))
        assert len(cells) == 2 * len(names), line
        for name, e, p in zip(names, cells[::2], cells[1::2], strict=True):
            numbers = tuple(float(x) for x in re.findall(r"[\d.]+", f"{e} {p}"))
            assert len(numbers) == 4 or e == p == "–", line
            table[name][row] = numbers or None
    return table


@pytest.fixture(scope="module")
def sets():
    return benchmark.read()


@pytest.mark.slow
def test_the_shipped_networks_hold_the_published_figures(sets):
    tables = published(RESULTS.read_text(encoding="utf-8"))
    assert list(tables) == [weights.DEFAULT]
    table = tables[weights.DEFAULT]
    rows = tuple(row for row in MEASURED if row.name.strip() in table)
    assert len(rows) >= 10, "docs/results.md has the rows of the evaluation"
    predicted = partial(predict.materials, weights.default_model())
    errors = report.measure_errors(predicted, sets, rows=rows)
    for row, figures in errors.rows.items():
        limits = table[row.strip()]
        if figures is None or limits is None:
            assert figures is limits, (row, "has figures where the table has dashes, or none")
            continue
        e, p = figures["E"], figures["P"]
        measured = tuple(100 * x for x in (e["mean"], e["median"], e["p95"], p["median"]))
        for value, limit in zip(measured, limits, strict=True):
            assert value <= MARGIN * limit + ROUNDING, (row, measured, limits)


def test_the_shipped_networks_create_no_energy():
    """The directional albedo of stacks that absorb nothing is at most 100 %."""
    assert physical_laws.white_albedo(weights.default_model()).kept
