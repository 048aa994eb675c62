"""The shipped weights were trained with the preset of their name."""

import json

from urushi.nets import weights
from urushi.train import presets


def test_the_shipped_weights_were_trained_with_the_current_preset():
    described = weights.default_model().header["preset"]
    assert described == json.loads(json.dumps(presets.get(weights.DEFAULT).to_dict()))
