"""What tests of commands share."""

import pytest

from urushi.nets import weights
from urushi.nets.architecture import Architecture, init


@pytest.fixture
def untrained(monkeypatch, tmp_path):
    """Untrained networks: for what does not depend on how good they are."""
    folder = tmp_path / "weights"
    folder.mkdir()
    for seed, name in enumerate(weights.SHIPPED):
        weights.save(folder / f"{name}.safetensors", Architecture(), init(Architecture(), seed), {})
    monkeypatch.setattr(weights, "shipped_folder", lambda: folder)
    weights.load_shipped.cache_clear()
    yield
    weights.load_shipped.cache_clear()
