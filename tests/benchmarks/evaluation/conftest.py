"""Groups of a few stacks, their reference at a coarse aim, and untrained networks."""

import pytest
from benchmarks.evaluation.samples import Group, Samples
from benchmarks.quality import benchmark_set

from urushi.nets import weights
from urushi.nets.architecture import Architecture, init
from urushi.train.distribution import Extended, Table2

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
def tiny() -> weights.Model:
    """Networks that were never trained."""
    arch = Architecture(decoder=(16,), encoder=(16,), layerer=(16,), sampler=(8,))
    return weights.Model.of(arch, init(arch, 3), {})


@pytest.fixture(scope="session")
def lax(tiny) -> weights.Model:
    """Networks of the same sizes that return f = exp(0) for any input."""
    params = {name: value * 0 for name, value in tiny.params.items()}
    params["encoder.input_scale"] = params["encoder.input_scale"] + 1
    return weights.Model.of(tiny.arch, params, {})
