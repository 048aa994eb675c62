"""The shipped weights were trained with the preset of their name."""

import copy
import json

import pytest

from urushi.nets import weights
from urushi.train import presets


@pytest.mark.parametrize(
    ("name", "model"),
    [(weights.DEFAULT, weights.default_model), ("anisotropic", weights.anisotropic_model)],
)
def test_the_shipped_weights_were_trained_with_the_current_preset(name, model):
    described = copy.deepcopy(model().header["preset"])
    for stage in described["stages"]:
        if stage["kind"] != "sampling":
            stage.setdefault("energy_share", 0.0)  # an option that is newer than some weights
    assert described == json.loads(json.dumps(presets.get(name).to_dict()))
