"""The shipped networks hold the published figures: the table "Accuracy" of docs/results.md."""

import re
from pathlib import Path

import pytest

from urushi.eval import benchmark, physical_laws, report
from urushi.eval.groups import ROWS
from urushi.nets import weights

RESULTS = Path(__file__).resolve().parents[2] / "docs" / "results.md"

#: The values are deterministic; the margin is for the published rounding to two decimals and for
#: other CPUs' single-precision arithmetic.
MARGIN = 1.05

#: Refined rows are left out: they are the same networks with minutes of optimisation.
MEASURED = tuple(row for row in ROWS if not row.refined)


def published() -> dict[str, dict[str, tuple[float, ...]]]:
    """By networks and row name: mean, median and p95 of E, and the median of P, in percent."""
    number = r"([\d.]+)"
    figures = rf"{number} / {number} / {number} % \| {number} %"
    row = re.compile(rf"^\| (.+?) \| {figures} \| {figures} \|$", re.MULTILINE)
    matches = row.findall(RESULTS.read_text(encoding="utf-8"))
    return {
        "base": {m[0]: tuple(map(float, m[1:5])) for m in matches},
        "small": {m[0]: tuple(map(float, m[5:9])) for m in matches},
    }


@pytest.fixture(scope="module")
def sets():
    return benchmark.read()


@pytest.mark.parametrize("name", weights.SHIPPED)
def test_the_shipped_networks_hold_the_published_figures(name, sets):
    table = published()[name]
    rows = tuple(row for row in MEASURED if row.name.strip() in table)
    assert len(rows) >= 10, "docs/results.md has the rows of `urushi eval`"
    errors = report.measure_errors(weights.load_shipped(name), sets, rows=rows)
    for row, figures in errors.rows.items():
        e, p = figures["E"], figures["P"]
        measured = tuple(100 * x for x in (e["mean"], e["median"], e["p95"], p["median"]))
        for value, limit in zip(measured, table[row.strip()], strict=True):
            assert value <= MARGIN * limit, (row, measured, table[row.strip()])


@pytest.mark.parametrize("name", weights.SHIPPED)
def test_the_shipped_networks_create_no_energy(name):
    """The directional albedo of stacks that absorb nothing is at most 100 %."""
    assert physical_laws.white_albedo(weights.load_shipped(name)).kept
