"""The shipped weights were trained with the preset of their name, where there is still one."""

import json

import pytest

from urushi.nets import weights
from urushi.train import presets


@pytest.mark.parametrize("name", weights.SHIPPED)
def test_the_shipped_weights_were_trained_with_the_current_preset(name):
    described = weights.load_shipped(name).header["preset"]
    assert described["name"] == name
    if name not in presets.NAMES:
        pytest.skip(f"the preset '{name}' was replaced by 'default'")
    assert described == json.loads(json.dumps(presets.get(name).to_dict()))
