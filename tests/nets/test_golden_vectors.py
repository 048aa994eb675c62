"""The golden vectors of the page's core are those of the shipped networks."""

from pathlib import Path

import pytest

from urushi import files
from urushi.nets.weights import anisotropic_model, default_model

FOLDER = Path(__file__).parents[2] / "viewer/tests/core/golden"


@pytest.mark.skipif(not FOLDER.exists(), reason="the source distribution has no page")
@pytest.mark.parametrize(
    ("name", "model"), [("default", default_model), ("anisotropic", anisotropic_model)]
)
def test_golden_vectors_are_of_the_shipped_networks(name, model) -> None:
    description, _ = files.read_tensors(FOLDER / f"{name}_vectors.safetensors", "vectors")
    assert description["weights"] == model().fingerprint, (
        f"run `python viewer/tests/golden.py {name}`"
    )
