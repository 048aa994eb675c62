"""Coats that are hardly there: the bottom remains, and f changes gradually."""

import itertools

import numpy as np
import pytest

from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import stack_error
from urushi.material import Material, encode, layer
from urushi.material.lerp import brighter_lobes
from urushi.nets.lobe import f
from urushi.walk import coat, conductor, dielectric, diffuse, simulate


@pytest.fixture(scope="module")
def pairs():
    return cosine_pairs(np.random.default_rng(3), 2000)


def error(a: Material, b: Material, wi, wo) -> float:
    """E between two materials, the mean over channels."""
    return float(stack_error(a.f(wi, wo).T, b.f(wi, wo).T, wi[:, 2], wo[:, 2]).mean())


@pytest.mark.parametrize(
    "bottom",
    [
        conductor(0.4, eta=(0.2, 0.9, 1.5), k=(3.9, 2.4, 1.9)),
        diffuse((0.8, 0.1, 0.02)),
    ],
    ids=["gold", "diffuse"],
)
def test_the_bottom_remains(trained, pairs, bottom):
    bare = encode(bottom, trained)
    # 1.001 is the index nearest to one; its coat reflects (0.0005)^2 of the light. The tolerance is
    # the error of the networks.
    assert error(layer(dielectric(0.02, 1.001), bare), bare, *pairs) < 0.02
    thin = layer(dielectric(0.02, 1.001), bare, sigma_t=1e-4, albedo=0.5)
    assert error(thin, bare, *pairs) < 0.02


def test_the_bottom_remains_in_one_channel(trained, pairs):
    """Also one whose table is of all of f; within interpolation and half precision."""

    def lobes_over_white(wi, wo):
        narrow = np.float32([[0.03, 0.5, 1, 0, 1.5, 0], [0.3, 0.2, 1, 0, 1.5, 0]])
        return (f(narrow, wi[:, None], wo[:, None]) + 0.1) @ np.ones((2, 3), np.float32)

    bare = encode(lobes_over_white, trained)
    assert bare.table is not None and not bare.beside_lobe
    coated = layer(dielectric(0.1, (1.0, 1.5, 1.5)), bare)
    np.testing.assert_allclose(coated.f(*pairs)[:, 0], bare.f(*pairs)[:, 0], rtol=0.02)
    np.testing.assert_array_equal(coated.latents[0], bare.latents[0])


def test_code_and_table_agree(trained, pairs):
    """Both are light transport, at other pairs; codes approximate."""
    for bottom, eta in ((diffuse(0.5), 1.5), (conductor(0.2, 0.9), 1.3)):
        table = layer(dielectric(0.1, eta), encode(bottom, trained), sigma_t=0.5, albedo=0.3)
        assert error(Material(table.latents, trained), table, *pairs) < 0.01


@pytest.mark.parametrize(
    ("bottom", "eta"),
    [
        (conductor(0.1, eta=0.2, k=3.9), 1.003),
        (dielectric(0.1, 1.5), 1.007),
        (conductor(0.1, r0=0.8), 1.012),
    ],
    ids=["gold", "glass", "metal"],
)
def test_faint_coats_agree_with_the_walk(trained, pairs, bottom, eta):
    """The tolerance is that of the networks for sharp lobes under thin coats; the walks' noise
    is below 0.5 %.
    """
    few = [side[:300] for side in pairs]
    f, _ = simulate(coat(bottom, alpha=0.04, eta=eta), *few, walks=512, seed=5)
    coated = layer(dielectric(0.04, eta), encode(bottom, trained)).f(*few)
    assert stack_error(coated.T, f.T, few[0][:, 2], few[1][:, 2]).mean() < 0.04


@pytest.mark.parametrize("eta", [0.99, 1.001])
def test_rough_interfaces_darken_whatever_their_index(trained, pairs, eta):
    """Their facets mask and shadow each other: the walk reflects 7 % less light than the bottom."""
    few = [side[:300] for side in pairs]
    bottom = diffuse(0.6)
    f, _ = simulate(coat(bottom, alpha=0.3, eta=eta), *few, walks=512, seed=6)
    bare = encode(bottom, trained)
    coated = layer(dielectric(0.3, eta), bare).f(*few)
    errors = [
        stack_error(g.T, f.T, few[0][:, 2], few[1][:, 2]).mean() for g in (coated, bare.f(*few))
    ]
    assert errors[0] < 0.03 < errors[1]


@pytest.mark.parametrize("share", [0.01, 0.3, 0.9])
def test_the_lobe_of_a_blend_is_one_of_its_parts(share):
    """So that the rest, f of the blend less its lobe, is nowhere negative."""
    wi, wo = cosine_pairs(np.random.default_rng(4), 200)
    gold, glass = (0.1, 0, 0, 1, 0.2, 3.9), (0.3, 0, 0, 1, 1.5, 0)
    low, schlick = (0.05, 0, 0, 1, 0.7, 0), (0.2, 0.3, 0.9, 0, 1.5, 0)
    for a, b in itertools.product((gold, glass, low, schlick), repeat=2):
        a, b = (np.array([lobe], np.float32) for lobe in (a, b))
        blend = brighter_lobes(a, b, np.array([share]))
        mean = (1 - share) * f(a, wi, wo) + share * f(b, wi, wo)
        assert (f(blend, wi, wo) <= mean * (1 + 1e-5)).all()
