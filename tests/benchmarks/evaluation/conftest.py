"""Groups of a few stacks, their reference at a coarse aim, and untrained models."""

import pytest
from benchmarks.evaluation import benchmark
from benchmarks.evaluation.distributions import Table2
from benchmarks.evaluation.samples import Group, Samples
from tests.untrained import untrained

from urushi.nets.weights import Model
from urushi.train.distribution import Extended


@pytest.fixture(scope="session")
def groups() -> tuple[Group, ...]:
    """Small ones: one with everything that a group may have, and one that is analytic."""
    return Group("few", Table2(1), 3, probed=(1,)), Group("bare", Extended(0, "mixture"), 3)


@pytest.fixture(scope="session")
def sets(groups) -> dict[str, Samples]:
    """The groups' sets, at three times the noise of the stored ones, more in the albedo."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(benchmark, "E_ERROR", 0.009)
        patch.setattr(benchmark, "P_ERROR", 0.009)
        patch.setattr(benchmark, "ALBEDO_ERROR", 0.02)
        return {group.name: benchmark.simulate(group) for group in groups}


@pytest.fixture(scope="session")
def tiny() -> Model:
    """Smooth random functions and random networks."""
    return untrained(3)
