"""The shipped networks hold the published figures, which the experiment `accuracy` stores."""

from functools import partial

import pytest
from benchmarks import experiment
from benchmarks.evaluation import benchmark, physical_laws, predict, report
from benchmarks.evaluation.samples import ROWS

from urushi.nets import weights

#: The values are deterministic; the margin is for other CPUs' single-precision arithmetic.
MARGIN, ROUNDING = 1.05, 5e-5

#: Rows by tables are left out: light transport has tests of its own.
MEASURED = tuple(row for row in ROWS if row.how != "table")


@pytest.mark.slow
def test_the_shipped_networks_hold_the_published_figures():
    model = weights.default_model()
    stored = experiment.stored("accuracy")
    assert experiment.state("accuracy") == "", "stale: run `python -m benchmarks accuracy`"
    rows, _ = report.measure_errors(partial(predict.materials, model), benchmark.read(), MEASURED)
    assert len(rows) >= 10
    for row, figures in rows.items():
        for metric, names in (("E", ("mean", "median", "p95")), ("P", ("median",))):
            for name in names:
                limit = MARGIN * stored["cases"]["all"]["rows"][row][metric][name] + ROUNDING
                assert figures[metric][name] <= limit, (row, metric, name)


def test_the_shipped_networks_create_no_energy():
    """The directional albedo of stacks that absorb nothing is at most 100 %."""
    assert physical_laws.white_albedo(weights.default_model()).kept
