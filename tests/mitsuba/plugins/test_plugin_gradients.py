"""Derivatives of the plugins: equal values, and slopes of the walk."""

import pytest
from benchmarks.experiments.gradients import SLOPES, slopes

#: Cases of the first tier and of the second; the others are for the third, at the ends of ranges.
FIRST = ("black diffuse", "rough gold")
SECOND = (
    "white diffuse",
    "openpbr",
    "bright openpbr",
    "plastic",
    "alpha on plastic",
    "two indices",
    "white medium",
    "no medium",
)
RARE = {name: pytest.mark.slow if name in SECOND else pytest.mark.research for name in SLOPES}

#: Of an error, relative to the mean size of the slope.
TOLERANCE = 0.03


@pytest.mark.parametrize(
    "case", [pytest.param(name, marks=() if name in FIRST else RARE[name]) for name in SLOPES]
)
def test_slopes_are_those_of_the_walk(rgb, case):
    """With nearly the same f as without gradients: by codes in place of a table.

    Two standard errors of the walk are added. They exceed the tolerance for sharp gold alone.
    """
    found = slopes(case)
    assert found.away < 0.04
    assert found.derivative == pytest.approx(
        found.walk, abs=TOLERANCE * found.size + 2 * found.error
    )
