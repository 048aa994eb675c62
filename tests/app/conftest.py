"""Fixtures of the commands' tests."""

import pytest

from urushi.eval import sphere
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


@pytest.fixture
def small_spheres(monkeypatch):
    """Pictures of spheres of 24 x 24 pixels, whose nodes take a fraction of the time."""
    monkeypatch.setattr(sphere, "RINGS", 12)
    sphere.nodes.cache_clear()
    sphere._white.cache_clear()
    yield
    sphere.nodes.cache_clear()
    sphere._white.cache_clear()
