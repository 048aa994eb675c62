"""MERL tables: exact at bin centres, reciprocal, no invalid bin leaks, and the walk reads them.

`walk/test_bottoms` has their sampling.
"""

import numpy as np
import pytest
from tests.directions import above
from tests.measured import writers

from urushi.core.directions import directions_at
from urushi.measured import Merl, Rgl, load_measured, tabulated
from urushi.measured.tabulated import fill_nearest
from urushi.walk import coat, monte_carlo, simulate


@pytest.fixture(scope="module")
def analytic(tmp_path_factory):
    """The analytic BRDF read from a file, which has -1 where a direction is beyond 85 degrees."""
    wi, wo = writers.merl_directions()
    rgb = writers.plastic(wi, wo)
    missing = np.minimum(wi[:, 2], wo[:, 2]) < np.cos(np.radians(85))
    rgb[missing] = -1
    path = tmp_path_factory.mktemp("merl") / "any_name.txt"
    brdf = load_measured(writers.write_merl(path, rgb))
    path.unlink()  # 35 MB
    return brdf


def test_values_are_those_of_the_analytic_brdf(analytic):
    """At the centres of bins, and between them."""
    wi, wo = writers.merl_directions()
    valid = np.minimum(wi[:, 2], wo[:, 2]) > np.cos(np.radians(84))
    rows = np.random.default_rng(0).choice(np.flatnonzero(valid), 20000, replace=False)
    # Directions are float32, so that the smallest half angles (5e-5) are known to 1e-3 of a bin.
    np.testing.assert_allclose(
        analytic.f(wi[rows], wo[rows]), writers.plastic(wi[rows], wo[rows]), rtol=1e-4
    )
    wi, wo = above(20000, 1, 0.2), above(20000, 2, 0.2)
    expected = writers.plastic(wi.astype(float), wo.astype(float))
    # Linear interpolation is off by (step / width)^2 / 8 times a number of order 1: steps of up to
    # 2 degrees, a lobe 17 degrees wide: 0.2 %, and more where Schlick's fifth power rises.
    error = np.abs(analytic.f(wi, wo) / expected - 1)
    assert np.median(error) < 1e-3
    assert error.max() < 0.02


def test_f_is_exactly_reciprocal_and_isotropic(analytic, monkeypatch):
    """And does not depend on the blocks in which it is computed."""
    wi, wo = above(5000, 3), above(5000, 4)
    wi[0], wo[0] = (0, 0, 1), (0, 0, 1)
    f = analytic.f(wi, wo)
    np.testing.assert_array_equal(f, analytic.f(wo, wi))
    turn = np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]])
    # Rounding of the turned float32 directions, where f is steepest.
    np.testing.assert_allclose(analytic.f(wi @ turn, wo @ turn), f, rtol=1e-3)
    monkeypatch.setattr(tabulated, "NUMBERS", 300)
    np.testing.assert_array_equal(analytic.f(wi, wo), f)


def test_below_the_horizon_f_is_zero(analytic):
    """Of RGL materials, too."""
    up, down, level = (0.6, 0, 0.8), (0.6, 0, -0.8), (1, 0, 0)
    wi, wo = np.array([up, down, down, up]), np.array([down, up, down, level])
    for brdf in (analytic, Rgl(writers.rgl_fields(np.random.default_rng(0)))):
        assert not brdf.f(wi, wo).any()
        assert brdf.f(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0, 3)
        assert (brdf.f([up, (0, 0, 1)], [up, (0, 0, 1)]) > 0).all()


def test_no_invalid_bin_leaks_into_a_constant_brdf(tmp_path):
    wi, wo = writers.merl_directions()
    rng = np.random.default_rng(5)
    rgb = np.tile(writers.COLOUR, (len(wi), 1))
    rgb[np.minimum(wi[:, 2], wo[:, 2]) < 0.17] = -1  # beyond 80 degrees, and below the horizon
    rgb[rng.random(len(rgb)) < 0.3, 1] = -1  # one negative channel is enough
    rgb[(wi[:, 2] <= 0) | (wo[:, 2] <= 0)] = 1e6  # not marked as invalid, but never used
    brdf = load_measured(writers.write_merl(tmp_path / "constant", rgb))
    f = brdf.f(above(50000, 6), above(50000, 7))
    # Directions reach down to the horizon; values are rounded to float32.
    np.testing.assert_allclose(f, np.broadcast_to(writers.COLOUR, f.shape), rtol=1e-6)


def test_phi_d_closes_after_half_a_turn():
    phi_d = (np.arange(180) + 0.5) * np.pi / 180
    table = np.ones((90, 90, 180, 3)) * (2 + np.sin(2 * phi_d))[:, None]
    angles = np.full(3, 0.4), np.full(3, 0.5), np.array([-1e-4, 0.0, np.pi - 1e-4])
    f = Merl(table).f(*directions_at(*angles))[:, 0]
    assert f[0] == pytest.approx(f[2], rel=1e-6)
    assert f == pytest.approx(2, abs=5e-4)  # sin: slope 2 times 1e-4, and no jump


def test_the_fill_takes_the_nearest_valid_bin_of_row_or_column():
    """And the nearest slice, whose one valid bin fills everything."""
    alone, one = np.full((4, 5, 6, 3), -1.0), np.zeros((4, 5, 6), bool)
    alone[2, 3, 1], one[2, 3, 1] = 0.25, True
    fill_nearest(alone, one)
    assert (alone == 0.25).all()
    rng = np.random.default_rng(8)
    values = rng.random((6, 9, 10, 1))
    valid = rng.random((6, 9, 10)) < 0.4
    valid[:, :, 0] = True  # one valid bin in every row, so that one round suffices
    filled = values.copy()
    fill_nearest(filled, valid)
    assert np.array_equal(filled[valid], values[valid])
    for i, j, k in np.argwhere(~valid):
        distances = [(abs(a - j), values[i, a, k, 0]) for a in range(9) if valid[i, a, k]]
        for b in range(10):
            if valid[i, j, b]:
                distances.append((min(abs(b - k), 10 - abs(b - k)), values[i, j, b, 0]))
        nearest = min(distance for distance, _ in distances)
        assert filled[i, j, k, 0] in [value for d, value in distances if d == nearest]


def test_walk_and_reader_agree():
    """The table is noise, so that every bin and weight matters. Below the horizon, f is zero."""
    noise = Merl(np.random.default_rng(0).random((90, 90, 180, 3)))
    types = monte_carlo.backend()
    wi, wo = above(20000, 1), above(20000, 2)
    wi[:100], wo[:100] = wo[:100], wi[:100]
    wi[0] = wo[0] = (0, 0, 1)  # where azimuths are undefined
    wi[1] = wo[1]
    wi[2:6, 2] *= -1
    wo[4:8, 2] *= -1
    to_light, to_eye = (types.Array3f(np.ascontiguousarray(w.T)) for w in (wi, wo))
    # Positions in the table are in single precision: an error of 1e-5 of a bin, times steps of up
    # to 1 along each of three axes.
    expected = noise.f(wi, wo)
    np.testing.assert_allclose(noise.f_pdf(to_light, to_eye)[0].numpy().T, expected, atol=1e-4)
    below = noise.sample(to_light, *(types.Float([x] * 20000) for x in (0.1, 0.5, 0.5)))[1:]
    assert not any(values.numpy()[..., 2:6].any() for values in below)
    # A coat that is nothing leaves each channel as it is.
    f, _ = simulate(coat(noise, 0.4, 1), wi[8:500], wo[8:500], walks=16)
    np.testing.assert_allclose(f, expected[8:500], atol=1e-4)
