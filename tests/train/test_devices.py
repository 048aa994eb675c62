"""Several devices learn what one does; the processor plays four of them in another process."""

import json
import os
import subprocess
import sys
from pathlib import Path

import jax
import numpy as np
import pytest

from urushi.errors import ParameterError
from urushi.nets import weights
from urushi.train import devices
from urushi.train.training import train

SCRIPT = """
import json, sys
sys.path.insert(0, sys.argv[1])
from conftest import TINY
from urushi.train import devices, training

shared = devices.find(sum(TINY.stacks))
rows = {}
place = devices.Devices.place

def watched(self, state, batches):
    state, batches = place(self, state, batches)
    if type(batches).__name__ in rows:  # the decoder's stage has batches like the networks'
        return state, batches
    weight = state.params["layerer.0.weight"]
    arrays = {"weight": weight, **{k: x for k, x in batches._asdict().items() if k != "coats"}}
    stage = rows[type(batches).__name__] = {}
    for name, x in arrays.items():
        stage[name] = [list(shard.data.shape) for shard in x.addressable_shards]
    stage["coats"] = [list(coat.addressable_shards[0].data.shape) for coat in batches.coats]
    return state, batches

devices.Devices.place = watched
training.train(TINY, data=sys.argv[2], run=sys.argv[3])
try:
    devices.find(7)
except Exception as error:
    rows["error"] = str(error)
rows["six stacks"] = devices.find(6).count
print(json.dumps(rows))
"""


@pytest.fixture(scope="module")
def four(tiny_data, tmp_path_factory):
    """What a process with four devices says, and its weights."""
    folder = tmp_path_factory.mktemp("four")
    command = [sys.executable, "-c", SCRIPT, str(Path(__file__).parent), tiny_data, folder]
    flags = {"XLA_FLAGS": "--xla_force_host_platform_device_count=4", "JAX_PLATFORMS": "cpu"}
    run = subprocess.run(
        command, env=os.environ | flags, capture_output=True, text=True, timeout=300
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout), weights.read(folder / "weights.safetensors")


@pytest.mark.slow
def test_each_device_has_its_share_of_the_stacks_and_all_parameters(four, tiny):
    seen, steps = four[0]["Batch"], tiny.networks.steps_per_call
    assert seen["f"] == [[steps, 4, tiny.pairs]] * 4  # 16 stacks a step
    # Only some stacks have the lowest coat, fewer the next one: these go whole to every device.
    assert seen["coats"] == [[steps, 13, 5], [steps, 4, 5]]
    assert seen["weight"] == [[6 + 16, 16]] * 4  # the code and the coat
    seen = four[0]["LayeringBatch"]
    assert seen["curvature"] == [[steps, 3, 6, 6]] * 4  # 12 stacks a step
    assert seen["coats"] == [[steps, 3, 5], [steps, 2, 5]]  # all have a lowest coat
    assert seen["below"] == [[steps, 2, 6]] * 4
    assert seen["weight"] == [[6 + 16, 24]] * 4


@pytest.mark.slow
def test_four_devices_learn_what_one_does(four, tiny, tiny_data, tmp_path):
    one = train(tiny, data=tiny_data, run=tmp_path)
    model = four[1]
    assert model.header["cost"]["devices"] == 4
    assert one.header["cost"]["devices"] == 1
    for name, value in one.params.items():
        # Sums over stacks are taken in another order, which float32 shows in the seventh digit; 24
        # steps of 3e-3 through Muon's orthogonalised gradients may spread that to some 1e-4. SOAP
        # follows the sign of whatever gradient there is, also where it is rounding alone, which
        # moves the weights of its stages but not what they give: the figures below tell of that.
        if not name.startswith(("layerer.", "decoder.")):
            np.testing.assert_allclose(model.params[name], value, atol=1e-3, err_msg=name)
    for name, value in one.header["metrics"].items():
        assert model.header["metrics"][name] == pytest.approx(value, rel=1e-2)


@pytest.mark.slow
def test_stacks_that_do_not_divide_use_fewer_devices_or_are_refused(four):
    assert four[0]["six stacks"] == 3
    assert "a step sees 7 stacks, which 4 devices cannot share evenly" in four[0]["error"]


def test_one_device_takes_any_number_of_stacks():
    shared = devices.find(7)
    assert shared.count == 1
    state, batches = object(), object()
    assert shared.place(state, batches) == (state, batches)


def test_no_two_devices_for_a_prime(monkeypatch):
    monkeypatch.setattr(jax, "local_devices", lambda: [None] * 2)
    with pytest.raises(ParameterError, match="or show JAX one device"):
        devices.find(9)
