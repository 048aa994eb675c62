"""Materials of the paper's networks have the same operations as those of Urushi's."""

import numpy as np
import pytest

import urushi
from urushi.errors import ParameterError
from urushi.fan2022 import networks
from urushi.fan2022.architecture import PaperArchitecture, init
from urushi.material import Material
from urushi.material.layer import layer_texels
from urushi.nets.weights import Model


@pytest.fixture(scope="module")
def paper():
    """Untrained networks whose values are positive nearly everywhere."""
    params = init(3)
    params["evaluation.3.bias"] = params["evaluation.3.bias"] + np.float32(0.5)
    return Model.of(PaperArchitecture(), params, {})


def test_encode_layer_lerp_save_and_load(paper, tmp_path, monkeypatch):
    project = networks.project
    monkeypatch.setattr(networks, "project", lambda p, d, f: project(p, d, f, steps=2))

    def grey(wi, wo):
        return np.full(len(wi), 0.3)

    bottom = urushi.encode(grey, paper)
    assert bottom.latents.shape == (1, 32)
    assert urushi.encode(grey, paper, refine=True) == bottom  # projection leaves nothing to refine
    coated = urushi.layer(urushi.dielectric(0.2, 1.5), bottom, albedo=0.5, sigma_t=1.0, g=0.3)
    blend = urushi.lerp(bottom, coated, 0.5)
    np.testing.assert_allclose(blend.latents, (bottom.latents + coated.latents) / 2, rtol=1e-6)
    coated.save(tmp_path / "coated.safetensors")
    assert urushi.load(tmp_path / "coated.safetensors", paper) == coated


def test_values_are_never_negative_and_zero_below_the_horizon(paper, directions):
    material = Material(np.random.default_rng(0).normal(size=(3, 32)), paper)
    wi, wo = directions[:500], directions[500:]
    f = material.f(wi, wo)
    above = (wi[:, 2] > 0) & (wo[:, 2] > 0)
    assert (f >= 0).all()
    assert not f[~above].any()
    assert f[above].any()


def test_samples_follow_the_density(paper, sphere_test):
    material = Material(np.ones((3, 32)), paper)
    wi = np.array([[0.6, 0.0, 0.8]], np.float32)
    u = np.random.default_rng(12).random((50_000, 3))
    wo, pdf = material.sample(np.repeat(wi, len(u), 0), u)
    np.testing.assert_allclose(pdf, material.pdf(np.repeat(wi, len(u), 0), wo), rtol=1e-3)
    assert sphere_test(wo, lambda w: material.pdf(np.repeat(wi, len(w), 0), w)) > 1e-3


def test_too_many_interfaces_at_once_are_refused(paper):
    z = np.ones((networks.MAX_TOPS + 1, 32), np.float32)
    alpha = np.linspace(0.1, 1, len(z))
    with pytest.raises(ParameterError, match="has 257 different interfaces"):
        layer_texels(paper, z, alpha=alpha, eta=1.5, albedo=0.0, sigma_t=0.0, g=0.0)
