"""What the shipped networks have learnt, against physics that they do not contain.

Bounds are those of the design's goals with some room, not this training's figures.
"""

import numpy as np
import pytest

from urushi.material import encode, layer
from urushi.reference import analytic
from urushi.reference.simulate import simulate
from urushi.reference.stack import coat, conductor, dielectric, diffuse


def _pairs(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of cosine density on both sides, cosines at least 0.02."""
    rng = np.random.default_rng(seed)
    sides = []
    for _ in range(2):
        cos = np.maximum(np.sqrt(rng.random(count)), 0.02)
        phi = 2 * np.pi * rng.random(count)
        sin = np.sqrt(1 - cos**2)
        sides.append(np.stack([sin * np.cos(phi), sin * np.sin(phi), cos], -1).astype(np.float32))
    return sides[0], sides[1]


def _error(material, truth: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> float:
    """The metric E of the design, over all channels."""
    cosines = (wi[:, 2] * wo[:, 2])[:, None]
    return float(np.sum(np.abs(material.f(wi, wo) - truth) * cosines) / np.sum(truth * cosines))


@pytest.mark.parametrize("alpha", [0.25, 0.5, 0.9])
def test_conductors_are_encoded(alpha, trained):
    # Wider than the layering goal of 2 % on average: single materials.
    description = conductor(alpha, (0.95, 0.6, 0.2))
    wi, wo = _pairs(2000, 1)
    truth = analytic.f(description, wi, wo)
    assert _error(encode(description, trained), truth, wi, wo) < 0.05


def test_layering_agrees_with_the_random_walk(trained):
    bottom = conductor(0.4, (0.9, 0.6, 0.3))
    coated = layer(dielectric(0.3, 1.5), encode(bottom, trained), albedo=0.7, sigma_t=(0, 1, 2))
    stack = coat(bottom, alpha=0.3, eta=1.5, albedo=0.7, sigma_t=(0, 1, 2))
    wi, wo = _pairs(300, 2)
    truth, _ = simulate(stack, wi, wo, walks=4096, seed=3, progress=False)
    assert _error(coated, truth, wi, wo) < 0.05


def test_diffuse_albedo_is_the_reflectance(trained):
    wi, _ = _pairs(20, 4)
    wi = wi[wi[:, 2] > 0.2]
    albedo = encode(diffuse((0.2, 0.5, 0.8)), trained).albedo(wi)
    np.testing.assert_allclose(albedo, np.broadcast_to([0.2, 0.5, 0.8], albedo.shape), rtol=0.05)


def test_coated_materials_create_no_energy(trained):
    # A white bottom under clear and under white coats: the albedo may reach 1, plus the
    # networks' own error of a few per cent.
    cos_i = np.linspace(0.15, 1, 8)
    wi = np.stack([np.sqrt(1 - cos_i**2), 0 * cos_i, cos_i], axis=-1)
    for bottom in (conductor(0.3, 1.0), diffuse(0.95)):
        for sigma_t in (0.0, 1.0, 4.0):
            coated = layer(dielectric(0.3, 1.5), bottom, albedo=1.0, sigma_t=sigma_t, model=trained)
            assert (coated.albedo(wi) < 1.05).all()


def test_the_proposal_beats_the_cosine_on_glossy_materials(trained):
    # Second moments of f_cos / pdf from wi at 45 degrees: lower is a better proposal, and its
    # floor is the albedo squared. Cosine sampling of a lobe of width 0.1 is far above that.
    gold = encode(conductor(0.1, 0.9), trained)
    count = 20_000
    wi = np.tile(np.array([[np.sqrt(0.5), 0, np.sqrt(0.5)]], np.float32), (count, 1))
    wo, pdf = gold.sample(wi, np.random.default_rng(5).random((count, 3)))
    weight = gold.f(wi, wo)[:, 0] * wo[:, 2] / pdf
    cosine = np.mean(weight * np.pi * gold.f(wi, wo)[:, 0])  # E[(pi f)^2] under cosine density
    assert np.mean(weight**2) < 0.2 * cosine
