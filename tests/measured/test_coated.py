"""Measured BRDFs under coats: walk and readers agree; `walk/test_bottoms` has their sampling."""

import numpy as np
from tests.measured import writers

from urushi.measured import Merl, load_measured, tabulated
from urushi.walk import analytic, coat, conductor, monte_carlo, simulate


def vector(types, w):
    return types.Array3f(np.ascontiguousarray(w.T))


def test_walk_and_reader_agree(random_directions):
    """The table is noise, so that every bin and weight matters. Below the horizon, f is zero."""
    noise = Merl(np.random.default_rng(0).random((90, 90, 180, 3)))
    types = monte_carlo.backend()
    wi, wo = random_directions(20000, 1), random_directions(20000, 2)
    wi[:100], wo[:100] = wo[:100], wi[:100]
    wi[0] = wo[0] = (0, 0, 1)  # where azimuths are undefined
    wi[1] = wo[1]
    wi[2:6, 2] *= -1
    wo[4:8, 2] *= -1
    f, _ = noise.f_pdf(vector(types, wi), vector(types, wo))
    # Positions in the table are in single precision: an error of 1e-5 of a bin, times steps of up
    # to 1 along each of three axes.
    np.testing.assert_allclose(f.numpy().T, noise.f(wi, wo), atol=1e-4)
    below = noise.sample(vector(types, wi[2:6]), *(types.Float([x] * 4) for x in (0.1, 0.5, 0.5)))
    assert not any(values.numpy().any() for values in below[1:])


def test_a_tabulated_conductor_under_a_coat_is_the_coated_conductor(random_directions):
    """The table's lookups and lobes against the analytic bottom and its own sampling."""
    gold = conductor(0.3, (0.95, 0.6, 0.2))
    copy = Merl(tabulated.tabulated(lambda wi, wo: analytic.f(gold, wi, wo), (90, 90, 180)))
    wi, wo = random_directions(20, 11, 0.1), random_directions(20, 12, 0.1)
    layers = dict(alpha=0.2, eta=1.5, albedo=(0.9, 0.5, 0.1), sigma_t=0.3, g=0.3)
    f, se = simulate(coat(copy, **layers), wi, wo, walks=1 << 13, progress=False)
    expected, error = simulate(coat(gold, **layers), wi, wo, walks=1 << 13, progress=False)
    # The table's values are off by up to 0.5 %, at grazing angles by more.
    np.testing.assert_array_less(np.abs(f - expected), 4.5 * np.hypot(se, error) + 0.01 * expected)


def test_an_rgl_materials_table_is_its_mean_over_the_exchange(test_data, random_directions):
    material = load_measured(writers.rgl_path(test_data, "chm_mint"))
    wi, wo = random_directions(4000, 9, 0.1), random_directions(4000, 10, 0.1)
    expected = 0.5 * (material.f(wi, wo) + material.f(wo, wi))
    f = tabulated.interpolated(material.table(), wi.astype(float), wo.astype(float))
    weight = (wi[:, 2] * wo[:, 2])[:, None]
    # Files have few elevations with linear interpolation between; the table smooths the kinks.
    assert (np.abs(f - expected) * weight).sum() < 0.02 * (expected * weight).sum()
