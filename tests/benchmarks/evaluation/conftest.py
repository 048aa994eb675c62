"""Groups of a few stacks, their reference at a coarse aim, and untrained models."""

import numpy as np
import pytest
from benchmarks.evaluation import benchmark_set
from benchmarks.evaluation.distributions import Table2
from benchmarks.evaluation.samples import Group, Samples
from tests.untrained import untrained

from urushi.nets.networks import Networks
from urushi.nets.weights import Model
from urushi.train.distribution import Extended

#: Small ones: one with everything that a group may have, and one that is analytic.
GROUPS = (
    Group("few", Table2(1), 3, probed=(1,)),
    Group("bare", Extended(0, "mixture"), 3),
)


@pytest.fixture(scope="session")
def groups() -> tuple[Group, ...]:
    return GROUPS


@pytest.fixture(scope="session")
def aim() -> float:
    """The error of the reference in E and P that the sets are made for."""
    return 0.009


@pytest.fixture(scope="session")
def sets(groups, aim) -> dict[str, Samples]:
    """The groups' sets, at three times the noise of the stored ones, more in the albedo."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(benchmark_set, "E_ERROR", aim)
        patch.setattr(benchmark_set, "P_ERROR", aim)
        patch.setattr(benchmark_set, "ALBEDO_ERROR", 0.02)
        return {group.name: benchmark_set.simulate(group) for group in groups}


@pytest.fixture(scope="session")
def tiny() -> Model:
    """Smooth random functions and random networks."""
    return untrained(3)


@pytest.fixture
def lax(tiny, monkeypatch) -> Model:
    """A model by which the rest of any BRDF is f = 1."""
    rows = np.zeros_like(tiny.params["basis.rows"])
    rows[:, 1] = 1
    encode = Networks.encode

    def without_shape(self, f, lobe=None):
        codes = encode(self, f, lobe)
        codes[..., self.arch.lobe :] = 0
        return codes

    monkeypatch.setattr(Networks, "encode", without_shape)
    return Model.of(tiny.arch, dict(tiny.params) | {"basis.rows": rows}, {})
