"""The shipped weights are what the preset of their name describes."""

import json

from urushi.nets.default import default_model
from urushi.train import presets


def test_the_shipped_weights_were_trained_by_the_preset_as_it_stands():
    described = default_model().header["preset"]
    assert described == json.loads(json.dumps(presets.get(described["name"]).to_dict()))
