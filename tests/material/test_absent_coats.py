"""Coats without an interface: what remains. Those of a faint one are in `test_as_the_walk`."""

import numpy as np
import pytest
from tests.material.conftest import error, two_lobes

from urushi.core.direction_sets import cosine_pairs
from urushi.core.namespace import NUMPY
from urushi.material import Material, encode, layer
from urushi.walk import conductor, dielectric, diffuse
from urushi.walk.medium import hg

NONE = dielectric(0.3, 1)


PAIRS = cosine_pairs(np.random.default_rng(3), 2000)


def test_the_bottom_remains_in_one_channel(trained):
    """Of a bottom whose table is of all of f; within interpolation and half precision."""
    bare = encode(lambda *w: two_lobes(*w)[:, None] * np.ones(3), trained)
    assert bare.table is not None and not bare.beside_lobe
    coated = layer(dielectric(0.1, (1.0, 1.5, 1.5)), bare)
    np.testing.assert_allclose(coated.f(*PAIRS)[:, 0], bare.f(*PAIRS)[:, 0], rtol=0.02)
    np.testing.assert_array_equal(coated.latents[0], bare.latents[0])


def test_code_and_table_agree(trained):
    """Both are light transport, at other pairs; codes approximate."""
    for bottom, eta in ((diffuse(0.5), 1.5), (conductor(0.2, 0.9), 1.3)):
        table = layer(dielectric(0.1, eta), encode(bottom, trained), sigma_t=0.5, albedo=0.3)
        assert error(Material(table.latents, trained), table, *PAIRS).mean() < 0.01


@pytest.mark.parametrize("bottom", [conductor(0.01, (0.9, 0.5, 0.2)), diffuse(0.5)])
def test_no_interface_and_no_medium_is_the_bottom(trained, bottom):
    bare = encode(bottom, trained)
    assert layer(NONE, bare, albedo=0.5) == bare
    # One channel has a medium: the others are as they were, but for a table of their rest.
    tinted = layer(NONE, bare, sigma_t=(0, 0.5, 0))
    np.testing.assert_allclose(
        tinted.f(*PAIRS)[:, ::2], bare.f(*PAIRS)[:, ::2], rtol=0.02, atol=1e-4
    )


@pytest.mark.parametrize(("g", "most"), [(-0.8, 0.015), (-0.9, 0.05)])
def test_backward_peaks_of_light_scattered_once(g, most):
    """A dark medium over a black bottom scatters once. The grid of adding is wider than its peak:
    errors were 3.7 and 9.9 %. Nodes of the table leave 1 and 3.9 %."""
    wi, wo = cosine_pairs(np.random.default_rng(8), 4096)
    dark = {"albedo": 0.01, "sigma_t": 1.0, "g": g}
    coated = layer(dielectric(0.1, eta=1), diffuse(0.0), **dark)
    slopes = 1 / wi[:, 2] + 1 / wo[:, 2]
    single = 0.01 * hg(-(wi * wo).sum(axis=1), g, NUMPY) / (wi[:, 2] + wo[:, 2])
    single *= -np.expm1(-slopes)
    assert error(coated, single[:, None], wi, wo).max() < most
