"""The shared fixtures of this folder: a training of a few steps and its data."""

import hashlib

import pytest

from urushi.nets.architecture import Architecture
from urushi.train.distribution import Extended, Table2
from urushi.train.optimiser import Schedule
from urushi.train.presets import Preset, validation
from urushi.train.stages.decoding import Decoding
from urushi.train.stages.joint import Joint
from urushi.train.stages.layering import Layering
from urushi.train.stages.sampling import Sampling
from urushi.train.store import DataSpec, Part, generate

ARCH = Architecture(
    latent=12,
    decoder=(16,),
    encoder=(16,),
    layerer=(24,),
    sampler=(8,),
    lobes=1,
    probes=24,
)

#: Numbers of stacks of 0, 1 and 2 coats in a step.
STACKS = (3, 9, 4)

SOAP = Schedule(8, 4, 1e-3, average=0.9, steps_per_call=4, checkpoint_every=4, rule="soap")

TINY = Preset(
    name="tiny",
    data=DataSpec(
        parts=(
            Part("bare", Extended(0, "diffuse"), 12, 16, 1),
            Part("coated", Table2(1), 20, 16, 8),
            Part("coated-diffuse", Extended(1, "diffuse"), 12, 16, 8),
            Part("twice", Table2(2), 8, 16, 8),
            *validation(stacks=8, walks=16),
        ),
        seed=5,
        shard=16,
    ),
    stages=(
        Joint(Schedule(8, 4, 3e-3, average=0.9, steps_per_call=4, checkpoint_every=4), STACKS),
        Layering(SOAP, stacks=(10, 2), widen_from=(16,)),
        Decoding(SOAP, STACKS),
        Layering(SOAP, stacks=(10, 2), seed_offset=2, name="relayering"),
        Sampling(Schedule(8, 4, 3e-3, average=0.9, steps_per_call=4, checkpoint_every=4)),
    ),
    pairs=8,
    arch=ARCH,
)


@pytest.fixture(scope="session")
def tiny() -> Preset:
    """The preset itself."""
    return TINY


@pytest.fixture(scope="session")
def tiny_data(tmp_path_factory):
    """Its data store, generated once."""
    path = tmp_path_factory.mktemp("tiny") / "data"
    generate(TINY.data, path)
    return path


@pytest.fixture(scope="session")
def fingerprints():
    """A function of a store's path: the hash of each of its files, by name."""

    def of(path):
        return {
            str(file.relative_to(path)): hashlib.sha256(file.read_bytes()).hexdigest()
            for file in path.rglob("*")
            if file.is_file()
        }

    return of
