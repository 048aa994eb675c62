"""Derivatives of the plugins: equal values, and slopes of the walk."""

import pytest
from benchmarks.experiments.gradients import SLOPES, slopes

#: Of an error, relative to the mean size of the slope.
TOLERANCE = 0.03


@pytest.mark.parametrize("case", SLOPES)
def test_slopes_are_those_of_the_walk(rgb, few_paths, case):
    """With nearly the same f as without gradients: by codes in place of a table.

    Two standard errors of the walk are added. They exceed the tolerance for sharp gold alone.
    """
    found = slopes(case)
    assert found.away < 0.04
    tolerance = TOLERANCE * found.size + 2 * found.error
    assert found.derivative == pytest.approx(found.walk, abs=tolerance)
