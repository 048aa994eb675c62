"""Several devices learn the same as one; a process with four virtual devices replaces them."""

import dataclasses
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
from dataclasses import replace
from conftest import TINY
from urushi.train import devices, training

rows = {}
place = devices.Devices.place

def watched(self, state, batches):
    state, batches = place(self, state, batches)
    weight = state.params["layerer.0.weight"]
    arrays = {"weight": weight, **{k: x for k, x in batches._asdict().items() if k != "coats"}}
    stage = rows[type(batches).__name__] = {}
    for name, x in arrays.items():
        stage[name] = [list(shard.data.shape) for shard in x.addressable_shards]
    stage["coats"] = [list(coat.addressable_shards[0].data.shape) for coat in batches.coats]
    return state, batches

devices.Devices.place = watched
training.train(replace(TINY, stages=TINY.stages[:2]), data=sys.argv[2], run=sys.argv[3])
try:
    devices.find(7)
except Exception as error:
    rows["error"] = str(error)
rows["six stacks"] = devices.find(6).count
print(json.dumps(rows))
"""


@pytest.fixture(scope="module")
def four(tiny_data, tmp_path_factory):
    """Shapes on four devices, and the weights of the first two stages.

    Decoding has the same batches as the joint stage, and sampling uses one device.
    """
    folder = tmp_path_factory.mktemp("four")
    command = [sys.executable, "-c", SCRIPT, str(Path(__file__).parent), tiny_data, folder]
    flags = {"XLA_FLAGS": "--xla_force_host_platform_device_count=4", "JAX_PLATFORMS": "cpu"}
    run = subprocess.run(
        command, env=os.environ | flags, capture_output=True, text=True, timeout=600
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout), weights.read(folder / "weights.safetensors")


@pytest.mark.research
def test_each_device_has_its_share_of_the_stacks_and_all_parameters(four, tiny):
    shapes, steps = four[0]["Batch"], tiny.stages[0].schedule.steps_per_call
    assert shapes["f"] == [[steps, 4, tiny.pairs]] * 4  # 16 stacks a step
    # Only some stacks have the lowest coat, and fewer the next one: every device gets all coats.
    assert shapes["coats"] == [[steps, 13, 5], [steps, 4, 5]]
    assert shapes["weight"] == [[12 + 18, 16]] * 4  # the code, with six features of the lobe, coat
    shapes = four[0]["LayeringBatch"]
    assert shapes["curvature"] == [[steps, 3, 6, 6]] * 4  # 12 stacks a step
    assert shapes["coats"] == [[steps, 3, 5], [steps, 2, 5]]  # all have a lowest coat
    assert shapes["below"] == [[steps, 2, 12]] * 4
    assert shapes["weight"] == [[12 + 18, 24]] * 4


@pytest.mark.research
def test_four_devices_learn_the_same_as_one(four, tiny, tiny_data, tmp_path):
    one = train(dataclasses.replace(tiny, stages=tiny.stages[:2]), data=tiny_data, run=tmp_path)
    model = four[1]
    assert model.header["cost"]["devices"] == 4
    assert one.header["cost"]["devices"] == 1
    for name, value in one.params.items():
        # Sums over stacks have another order, which changes the seventh digit in float32; 8 steps
        # of 3e-3 with Muon's orthogonalised gradients may increase that to 1e-4. SOAP normalises
        # every gradient, even if it is only rounding, which changes the layerer's weights but not
        # its values: the metrics below compare the values.
        if not name.startswith("layerer."):
            np.testing.assert_allclose(model.params[name], value, atol=1e-3, err_msg=name)
    for name, value in one.header["metrics"].items():
        assert model.header["metrics"][name] == pytest.approx(value, rel=1e-2)


@pytest.mark.research
def test_stacks_that_do_not_divide_use_fewer_devices_or_are_refused(four):
    assert four[0]["six stacks"] == 3
    assert "a step uses 7 stacks, which 4 devices cannot share evenly" in four[0]["error"]


def test_one_device_takes_any_number_of_stacks():
    shared = devices.find(7)
    assert shared.count == 1
    state, batches = object(), object()
    assert shared.place(state, batches) == (state, batches)


def test_a_prime_number_of_stacks_is_refused(monkeypatch):
    monkeypatch.setattr(jax, "local_devices", lambda: [None] * 2)
    with pytest.raises(ParameterError, match="or show JAX one device"):
        devices.find(9)
