"""The shipped weights were trained with the preset of their name."""

import dataclasses
import json

import pytest

from urushi.nets import weights
from urushi.train import presets


@pytest.mark.parametrize(
    ("name", "model"),
    [(weights.DEFAULT, weights.default_model), ("anisotropic", weights.anisotropic_model)],
)
def test_the_shipped_weights_were_trained_with_the_current_preset(name, model):
    """The header states every number; an option that is newer than the weights has its default.

    Options that no longer exist had the only value that is left.
    """
    preset, stated = presets.get(name), dict(model().header["preset"])
    current = json.loads(json.dumps(preset.to_dict()))
    stages = stated.pop("stages"), current.pop("stages"), preset.stages
    stated.pop("memory", None)  # it bounded the memory, and the data were below the bound
    assert stated == current
    for told, own, stage in zip(*stages, strict=True):
        assert told.pop("weigh_pairs", True)
        assert told["schedule"].pop("precision", "float32") == "float32"
        assert told == {key: value for key, value in own.items() if key in told}
        defaults = {field.name: field.default for field in dataclasses.fields(stage)}
        assert all(own[key] == defaults[key] for key in own.keys() - told.keys())
