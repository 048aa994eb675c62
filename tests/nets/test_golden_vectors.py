"""The golden vectors of the page's core are those of the shipped networks."""

from pathlib import Path

import pytest

from urushi import files
from urushi.nets.weights import default_model

VECTORS = Path(__file__).parents[2] / "viewer/tests/core/golden/default_vectors.safetensors"


@pytest.mark.skipif(not VECTORS.exists(), reason="the source distribution has no page")
def test_golden_vectors_are_of_the_shipped_networks() -> None:
    description, _ = files.read_tensors(VECTORS, "vectors")
    assert description["weights"] == default_model().fingerprint, (
        "run `python viewer/tests/golden.py default`"
    )
