"""Coats that are hardly there: the bottom remains, its lobe included, and f changes gradually."""

import itertools

import numpy as np
import pytest

from urushi.geometry.direction_sets import cosine_pairs
from urushi.geometry.error_metrics import stack_error
from urushi.material import Material, encode, layer
from urushi.material.layer import PRESENT, layer_texels, presence
from urushi.reference import conductor, dielectric, diffuse


@pytest.fixture(scope="module")
def pairs():
    wi, wo = cosine_pairs(np.random.default_rng(3), 2000)
    return wi.astype(np.float32), wo.astype(np.float32)


def error(a: Material, b: Material, wi, wo) -> float:
    """E between two materials, the mean over channels."""
    return float(stack_error(a.f(wi, wo).T, b.f(wi, wo).T, wi[:, 2], wo[:, 2]).mean())


@pytest.mark.parametrize(
    "bottom",
    [
        conductor(0.02, r0=(0.9, 0.6, 0.3)),
        conductor(0.4, eta=(0.2, 0.9, 1.5), k=(3.9, 2.4, 1.9)),
        dielectric(0.1, 1.5),
        diffuse((0.8, 0.1, 0.02)),
    ],
    ids=["metal", "gold", "glass", "diffuse"],
)
def test_the_bottom_remains(trained, pairs, bottom):
    bare = encode(bottom, trained)
    # 1.001 is the index nearest to one. A coat of it reflects (0.0005)^2 of the light, and one
    # hundredth of the layerer's result counts; with the thin medium two. The layerer may be wrong
    # by half so far outside its training data.
    assert error(layer(dielectric(0.3, 1.001), bare), bare, *pairs) < 0.005
    thin = layer(dielectric(0.3, 1.001), bare, sigma_t=1e-4, albedo=0.5)
    assert error(thin, bare, *pairs) < 0.01


def test_f_changes_gradually(trained, pairs):
    bare = encode(conductor(0.2, r0=0.8), trained)
    coats = [layer(dielectric(0.1, eta), bare) for eta in np.linspace(1.001, 1.05, 25)]
    steps = [error(a, b, *pairs) for a, b in itertools.pairwise(coats)]
    # The two codes of nearly the same BRDF differ by several per cent; no step is as large.
    assert max(steps) < 0.05


def test_coats_that_are_there_are_not_blended():
    eta, depth = np.array([1.05, 0.9, 1.001, 1.5]), np.array([0.0, 0.0, 0.1, 3.0])
    assert (presence(eta, depth) >= PRESENT).all()
    assert presence(np.array(1.001), np.array(0.0)) < 0.02


def test_texels_and_materials_agree(trained):
    bare = encode(conductor(0.2, r0=(0.8, 0.5, 0.3)), trained)
    coat = {"alpha": 0.3, "eta": np.array([1.002, 1.002, 1.4]), "albedo": 0.5}
    together = layer_texels(
        trained, bare.anchors, sigma_t=0.01, g=0.0, rendered=bare.latents, **coat
    )
    alone = layer(dielectric(0.3, coat["eta"]), bare, albedo=0.5, sigma_t=0.01)
    np.testing.assert_array_equal(together, alone.latents)
