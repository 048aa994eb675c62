"""Metals under films: the reflectance is that of a mirror at its mirror direction, the table f."""

import numpy as np
import pytest

from urushi.app.page_files import FILMS, filmed_material
from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import energy_weight
from urushi.core.fresnel import exact
from urushi.core.namespace import NUMPY
from urushi.nets import lobe as lobes
from urushi.nets.weights import find


@pytest.mark.parametrize("name", FILMS)
def test_the_table_is_f(name):
    """Within 0.3 %: interpolation in logarithms of half precision."""
    metal = FILMS[name]
    wi, wo = cosine_pairs(np.random.default_rng(0), 4096, lowest_cosine=0.01)
    expected, found = metal.f(wi, wo), filmed_material(metal, find(None)).f(wi, wo)
    weight = energy_weight(wi[:, 2], wo[:, 2])[:, None]
    assert (np.abs(found - expected) * weight).sum() < 0.003 * (expected * weight).sum()


@pytest.mark.parametrize("name", FILMS)
def test_without_a_film_it_is_the_metal(name):
    """By the exact term of a conductor; the series of the film ends at five orders."""
    metal = FILMS[name]._replace(thickness=0.0)
    wi, wo = cosine_pairs(np.random.default_rng(1), 256, lowest_cosine=0.1)
    cosine = lobes.cosine_to_facet(wi, wo)
    bare = [exact(cosine, eta, k, NUMPY) for eta, k in zip(metal.eta, metal.k, strict=True)]
    white = lobes.f(np.array([metal.alpha, 1, 1, 0, 1.5, 0], np.float32), wi, wo)
    np.testing.assert_allclose(metal.f(wi, wo), white[:, None] * np.stack(bare, -1), rtol=0.02)
