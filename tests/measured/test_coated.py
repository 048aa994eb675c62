"""Measured BRDFs under coats: walk and readers agree, and samples have the stated density."""

import drjit as dr
import numpy as np
import pytest
from tests.measured import writers

from urushi.core.directions import square_to_cosine_hemisphere
from urushi.core.random import stream
from urushi.measured import Merl, load_measured, tabulated
from urushi.walk import analytic, coat, conductor, monte_carlo, simulate

SAMPLES = 1 << 18


@pytest.fixture(scope="module")
def plastic():
    return Merl(tabulated.tabulated(lambda wi, wo: writers.plastic(wi, wo, 0.1), (90, 90, 180)))


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


@pytest.mark.parametrize("cos_i", [1.0, 0.6, 0.1])
def test_samples_integrate_the_brdf_and_their_density(plastic, cos_i):
    types = monte_carlo.backend()
    wi = types.Array3f(float(np.sqrt(1 - cos_i**2)), 0, cos_i) + dr.zeros(types.Array3f, SAMPLES)
    rng = stream(types.PCG32, dr.arange(types.UInt64, SAMPLES), 1)
    u = [rng.next_float32() for _ in range(5)]
    _, weight, pdf = plastic.sample(wi, *u[:3])
    grid = square_to_cosine_hemisphere(types.Array3f, *u[3:])
    f, density = plastic.f_pdf(wi, grid)
    weight, f = weight.numpy().mean(0), f.numpy().mean(0) * np.pi
    error = np.hypot(weight.std(), f.std()) / SAMPLES**0.5
    assert abs(weight.mean() - f.mean()) < 4 * error
    assert weight.std() / weight.mean() < 0.5  # the lobes follow the BRDF
    total = (density * dr.pi / grid.z).numpy()
    assert abs(total.mean() - 1) < 4 * total.std() / SAMPLES**0.5
    assert (pdf.numpy() > 0).all()
    below = plastic.sample(wi * types.Array3f(1, 1, -1), *u[:3])[1:]
    assert not any(values.numpy().any() for values in below)


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
