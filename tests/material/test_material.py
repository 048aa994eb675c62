"""A material's f is reciprocal and positive; its pdf, samples and albedo belong together."""

import pickle

import numpy as np
import pytest
from tests.directions import above, at_cosines

from urushi.errors import ParameterError
from urushi.material import Material
from urushi.material.encode import encode
from urushi.walk import dielectric

UP = np.array([[0.0, 0.6, 0.8]], np.float32)


def test_f_is_reciprocal_positive_above_and_zero_below_the_horizon(every, directions):
    wi, wo = directions, np.roll(directions, 1, axis=0)
    f = every.f(wi, wo)
    assert np.array_equal(f, every.f(wo, wi))
    above = (wi[:, 2] > 0) & (wo[:, 2] > 0)
    assert f.shape == (1000, 3) and f.dtype == np.float32
    assert (f[above] > 0).all() and np.isfinite(f).all()
    assert (f[~above] == 0).all() and not above.all()
    assert (every.pdf(wi, wo)[~above] == 0).all()


def test_a_pickled_material_is_the_same(every, directions):
    # Such as processes send to each other, also after its evaluation.
    wi, wo = directions, np.roll(directions, 1, axis=0)
    f = every.f(wi, wo)
    received = pickle.loads(pickle.dumps(every))
    assert received == every
    assert np.array_equal(received.f(wi, wo), f)


def test_many_rows_are_the_same_as_few(material):
    # More rows than one block: blocks change nothing but the order of float32 sums.
    rng = np.random.default_rng(1)
    wi = above(70_000, rng)
    wo = wi[::-1]
    f, pdf = material.f(wi, wo), material.pdf(wi, wo)
    rows = rng.integers(0, len(wi), 50)
    np.testing.assert_allclose(f[rows], material.f(wi[rows], wo[rows]), rtol=1e-4)
    np.testing.assert_allclose(pdf[rows], material.pdf(wi[rows], wo[rows]), rtol=1e-3)
    u = rng.random((len(wi), 3))
    few, many = material.sample(wi[rows], u[rows]), material.sample(wi, u)
    for one, all_of_them in zip(few, many, strict=True):
        np.testing.assert_allclose(one, all_of_them[rows], rtol=1e-3, atol=1e-5)
    # More than are integrated at once, and two of them alone
    few = material.directional_albedo(wi[rows[:20]])[:2]
    alone = [material.directional_albedo(wi[r : r + 1])[0] for r in rows[:2]]
    np.testing.assert_allclose(few, alone, 1e-5)


def test_samples_come_with_their_density(every, directions):
    u = np.random.default_rng(2).random((1000, 3))
    wo, pdf = every.sample(directions, u)
    assert wo.shape == (1000, 3) and pdf.shape == (1000,) and wo.dtype == pdf.dtype == np.float32
    assert np.array_equal(pdf, every.pdf(directions, wo))
    below = directions[:, 2] <= 0
    assert (pdf[below] == 0).all() and (pdf[~below] > 0).all()
    np.testing.assert_allclose(np.linalg.norm(wo, axis=1), 1, atol=1e-5)


@pytest.mark.parametrize("cos_i", [1.0, 0.6, 0.1])
def test_albedo_by_quadrature_is_albedo_by_sampling(every, cos_i):
    # Five standard errors of 100,000 samples, and the rule's 0.001.
    wi = at_cosines([cos_i])
    count = 100_000
    many = np.repeat(wi, count, axis=0)
    wo, pdf = every.sample(many, np.random.default_rng(3).random((count, 3)))
    weight = every.f(many, wo) * wo[:, 2:] / pdf[:, None]
    mean, error = weight.mean(axis=0), weight.std(axis=0) / np.sqrt(count)
    albedo = every.directional_albedo(wi)[0]
    assert (np.abs(albedo - mean) < 5 * error + 1e-3 * mean).all()


@pytest.mark.parametrize("alpha", [0.1, 0.5])
def test_albedo_of_an_interface_with_total_reflection(alpha, model):
    # Near normal incidence the edge lies at one half angle, here between nodes of a midpoint rule.
    interface = encode(dielectric(alpha, eta=0.5), model)
    angles = (np.arange(20_000) + 0.5) * (0.5 * np.pi / 20_000)
    wo = np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=-1)
    normal = np.array([[0.0, 0.0, 1.0]])
    f = interface.f(np.repeat(normal, len(wo), axis=0), wo)[:, 0]
    albedo = np.sum(f * np.sin(2 * angles)) * (0.5 * np.pi**2 / 20_000)
    assert interface.directional_albedo(normal)[0, 0] == pytest.approx(albedo, abs=2e-3)


def test_albedo_at_the_horizon(material):
    lowest, low = material.directional_albedo([[1, 0, 1e-30], [1, 0, 1e-5]])
    # All nodes lie in the last degrees, where the rule is coarse.
    np.testing.assert_allclose(lowest, low, rtol=0.05)


def test_albedo_below_the_horizon_is_zero_and_isotropic(material):
    wi = np.array([[0.6, 0, 0.8], [0, -0.6, 0.8], [0.6, 0, -0.8]], np.float32)
    albedo = material.directional_albedo(wi)
    assert albedo.shape == (3, 3) and (albedo[2] == 0).all()
    np.testing.assert_allclose(albedo[0], albedo[1], rtol=1e-4)


def test_no_directions_and_one_channel(material, model):
    none, grey = np.zeros((0, 3), np.float32), Material(np.ones((1, 14)), model)
    assert material.f(none, none).shape == material.directional_albedo(none).shape == (0, 3)
    assert material.pdf(none, none).shape == (0,)
    assert material.sample(none, none)[0].shape == (0, 3)
    assert grey.f(UP, UP).shape == grey.directional_albedo(UP).shape == (1, 1)


def test_a_material_is_a_value(material, model, other_model):
    same = Material(material.latents.copy(), model)
    assert same == material and hash(same) == hash(material)
    assert material != Material(material.latents + 1, model)
    assert material != Material(material.latents, other_model)
    with pytest.raises(ValueError, match="read-only"):
        material.latents[0, 0] = 1


@pytest.mark.parametrize(
    "latents",
    [
        *(np.ones(14), np.ones((3, 13)), np.ones((0, 14)), np.full((3, 14), np.nan)),
        *(np.ones((3, 14), complex), "codes", [[1.0], [1.0, 2.0]], None),
    ],
)
def test_bad_latents_are_refused(latents, model):
    with pytest.raises(ParameterError, match=r"latents .*(; give \([13], 14\)$|numbers?|finite)"):
        Material(latents, model)


@pytest.mark.parametrize(
    "bad", [UP * 2, np.array([[np.nan, 0, 1]]), UP[0], UP[:, :2], "up", np.zeros((1, 3))]
)
def test_bad_directions_are_refused(bad, material):
    for call, *given in (
        (material.f, bad, UP),
        (material.f, UP, bad),
        (material.pdf, bad, UP),
        (material.sample, bad, np.zeros((1, 3))),
        (material.directional_albedo, bad),
    ):
        with pytest.raises(ParameterError):
            call(*given)


@pytest.mark.parametrize(
    "u", [np.zeros((2, 3)), np.zeros((1, 2)), [[0, 0, 1.1]], [[0, 1, 0]], [[0, 0, np.nan]]]
)
def test_bad_random_numbers_are_refused(u, material):
    with pytest.raises(ParameterError, match="^u "):
        material.sample(UP, u)


def test_numbers_that_single_precision_rounds_to_one_are_below_it(material):
    wo, pdf = material.sample(UP, np.full((1, 3), 1 - 2.0**-40))
    assert np.isfinite(wo).all() and pdf[0] > 0
