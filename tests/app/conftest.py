"""Fixtures of the commands' tests."""

import pytest
from tests.untrained import untrained as untrained_model

from urushi.nets import weights
from urushi.nets.architecture import Architecture, init

ANISOTROPIC = Architecture(latent=30, widths=2)


@pytest.fixture
def untrained(monkeypatch, tmp_path):
    """Untrained networks: for what does not depend on how good they are."""
    folder = tmp_path / "weights"
    folder.mkdir()
    model = untrained_model()
    weights.save(folder / "default.safetensors", model.arch, model.params, {})
    weights.save(folder / "anisotropic.safetensors", ANISOTROPIC, init(ANISOTROPIC, 0), {})
    monkeypatch.setattr(weights, "SHIPPED", folder)
    weights.shipped.cache_clear()
    yield
    weights.shipped.cache_clear()
