"""Fixtures of the commands' tests."""

import pytest
from tests.untrained import untrained as untrained_model

from urushi.nets import weights


@pytest.fixture
def untrained(monkeypatch, tmp_path):
    """Untrained networks: for what does not depend on how good they are."""
    folder = tmp_path / "weights"
    folder.mkdir()
    two = untrained_model(widths=2, functions=13, azimuthal=(1, 1, 1, 1, 1))
    for name, model in {"default": untrained_model(), "anisotropic": two}.items():
        weights.save(folder / f"{name}.safetensors", model.arch, model.params, {})
    monkeypatch.setattr(weights, "SHIPPED", folder)
    weights.shipped.cache_clear()
    yield
    weights.shipped.cache_clear()
