"""What tests of commands share."""

import pytest

from urushi.nets import shipped, weights
from urushi.nets.architecture import Architecture, init


@pytest.fixture
def untrained(monkeypatch, tmp_path):
    """Untrained networks: for what does not depend on how good they are."""
    folder = tmp_path / "weights"
    folder.mkdir()
    for seed, name in enumerate(shipped.NAMES):
        weights.save(folder / f"{name}.safetensors", Architecture(), init(Architecture(), seed), {})
    monkeypatch.setattr(shipped, "folder", lambda: folder)
    shipped.load.cache_clear()
    yield
    shipped.load.cache_clear()
