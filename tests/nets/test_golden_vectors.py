"""The golden vectors of the page's core are values of the shipped networks."""

import dataclasses
import importlib.util
from pathlib import Path

import numpy as np
import pytest

from urushi import files
from urushi.nets.weights import anisotropic_model, default_model

SCRIPT = Path(__file__).parents[2] / "viewer/tests/golden.py"


@pytest.mark.slow
@pytest.mark.skipif(not SCRIPT.exists(), reason="the source distribution has no page")
@pytest.mark.filterwarnings("ignore:layer.*:urushi.errors.UrushiWarning")  # a medium of depth 50
@pytest.mark.parametrize(
    ("name", "model"), [("default", default_model), ("anisotropic", anisotropic_model)]
)
def test_golden_vectors_are_values_of_the_shipped_networks(name, model) -> None:
    """Of every fourth stack, in the double precision of the vectors, which are stored in single."""
    spec = importlib.util.spec_from_file_location("golden", SCRIPT)
    golden = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(golden)
    path = golden.FOLDER / f"{name}_vectors.safetensors"
    description, stored = files.read_tensors(path, "vectors")
    double = {key: value.astype(np.float64) for key, value in model().params.items()}
    networks = dataclasses.replace(model(), params=double)
    above = (stored["wi"][:, 2] > 0) & (stored["wo"][:, 2] > 0)
    for row, stack in list(enumerate(description["stacks"]))[::4]:
        material = golden.material_of(stack, networks)
        cure = f"run `python viewer/tests/golden.py {name}`"
        np.testing.assert_allclose(
            material.latents, stored["latents"][row], rtol=1e-5, atol=1e-5, err_msg=cure
        )
        f = golden.values_of(material, stored["wi"], stored["wo"])
        np.testing.assert_allclose(f[above], stored["f"][row][above], rtol=1e-4, err_msg=cure)
