"""A training so small that it takes seconds, on data that every test of this floor shares."""

import pytest

from urushi.data.distribution import Extended, Table2
from urushi.data.generate import generate
from urushi.data.spec import DataSpec, Part
from urushi.nets.architecture import Architecture
from urushi.train.datasets import validation
from urushi.train.presets import Layering, Preset, Schedule

ARCH = Architecture(
    latent=6, decoder=(16,), encoder=(16,), layerer=(24,), sampler=(8,), lobes=2, probes=24
)

TINY = Preset(
    name="tiny",
    data=DataSpec(
        parts=(
            Part("bare", Extended(0, "conductor"), 12, 16, 1),
            Part("coated", Table2(1), 20, 16, 8),
            Part("coated-diffuse", Extended(1, "diffuse"), 12, 16, 8),
            Part("twice", Table2(2), 8, 16, 8),
            *validation(stacks=8, walks=16),
        ),
        seed=5,
        shard=16,
    ),
    networks=Schedule(24, 4, 3e-3, average=0.9, steps_per_call=4, checkpoint_every=8),
    layering=Layering(
        Schedule(16, 4, 1e-3, average=0.9, steps_per_call=4, checkpoint_every=8, rule="soap"),
        stacks=(10, 2),
        before=(16,),
    ),
    decoding=Schedule(16, 4, 1e-3, average=0.9, steps_per_call=4, checkpoint_every=8, rule="soap"),
    relayering=Schedule(8, 4, 1e-3, average=0.9, steps_per_call=4, checkpoint_every=8, rule="soap"),
    proposal=Schedule(16, 4, 3e-3, average=0.9, steps_per_call=4, checkpoint_every=8),
    stacks=(3, 9, 4),
    pairs=8,
    memory=512,  # of 832 pairs: the examples stream
    arch=ARCH,
)


@pytest.fixture(scope="session")
def tiny() -> Preset:
    """The preset itself."""
    return TINY


@pytest.fixture(scope="session")
def tiny_data(tmp_path_factory):
    """Its data store, generated once."""
    path = tmp_path_factory.mktemp("tiny") / "data.zarr"
    generate(TINY.data, path)
    return path
