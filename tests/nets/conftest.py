"""Networks with random weights."""

import pytest

from urushi.nets.architecture import Architecture, init


@pytest.fixture(scope="session", params=["smoothstep", "silu7", "silu", "relu"])
def networks(request):
    """An architecture and random parameters whose f spans several orders of magnitude."""
    arch = Architecture(activation=request.param)
    params = init(arch, seed=5)
    params["decoder.3.weight"] = params["decoder.3.weight"] * 8
    params["sampler.2.weight"] = params["sampler.2.weight"] * 10
    return arch, params
