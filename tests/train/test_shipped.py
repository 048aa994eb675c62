"""The shipped weights were trained with the preset of their name."""

import copy
import json

from urushi.nets import weights
from urushi.train import presets


def test_the_shipped_weights_were_trained_with_the_current_preset():
    described = copy.deepcopy(weights.default_model().header["preset"])
    for stage in described["stages"]:
        if stage["kind"] != "sampling":
            stage.setdefault("energy_share", 0.0)  # an option that is newer than these weights
    assert described == json.loads(json.dumps(presets.get(weights.DEFAULT).to_dict()))
