"""Coats over materials with a table, against closed forms and the walk."""

from dataclasses import replace

import numpy as np
import pytest
from tests.untrained import untrained

from urushi.checks import CoatParameters
from urushi.core import fresnel
from urushi.core.error_metrics import stack_error
from urushi.core.namespace import NUMPY
from urushi.core.table import node_pairs, table_of_values
from urushi.material import Material, encode, layer, load
from urushi.material.coated_table import coated_rest
from urushi.material.layer import layer_material
from urushi.walk import dielectric, diffuse

SCATTERING = {"albedo": (0.95, 0.85, 0.7), "sigma_t": 1.0, "g": 0.3}


def sheen(wi, wo):
    """Reciprocal values that no layered material has: a wide lobe, and light at grazing angles."""
    h = wi + wo
    cos_h = h[:, 2] / np.linalg.norm(h, axis=1)
    lobe = 0.2**2 / (np.pi * (cos_h**2 * (0.2**2 - 1) + 1) ** 2)
    grazing = np.exp(-3 * (np.maximum(wi[:, 2], 0.05) + np.maximum(wo[:, 2], 0.05)))
    return np.stack([0.05 * lobe + 0.1, 0.1 * lobe + 0.3 * grazing, 0.02 + 0.6 * grazing], axis=1)


@pytest.fixture(scope="module")
def trained():
    """Any networks: tables are computed without them."""
    return untrained(0)


@pytest.fixture(scope="module")
def bottom(trained) -> Material:
    return encode(sheen, trained, table=True)


@pytest.fixture(scope="module")
def coated(bottom) -> Material:
    return layer(dielectric(0.1, 1.4), bottom, **SCATTERING)


def parameters(alpha, eta, albedo=0.0, sigma_t=0.0, g=0.0) -> CoatParameters:
    return CoatParameters(*(np.float64(x) for x in (alpha, eta, albedo, sigma_t, g)))


def error(f_hat, f, wi, wo) -> float:
    return float(stack_error(f_hat.T, f.T, wi[:, 2], wo[:, 2]).mean())


def with_table(f, model, channels: int = 1) -> Material:
    """A material with the table of f (N,) and codes that mean nothing."""
    plain = encode(diffuse(0.5), model)
    table = table_of_values(np.repeat(f(*node_pairs())[:, None], channels, axis=1))
    return Material(plain.latents[:channels], model, table=table)


def test_a_smooth_coat_over_black_velvet_dims_it_twice(trained):
    """The bottom reflects hardly any light again: f = T T f' exp(-sigma / c' ...) / eta^2."""
    faint = lambda wi, wo: 1e-4 * (1 + 3 * wi[:, 2] * wo[:, 2])  # noqa: E731
    eta, sigma_t = 1.5, 0.4
    rest = coated_rest(with_table(faint, trained), parameters(0.01, eta, 0.0, sigma_t))[:, 0]
    wi, wo = (w.astype(np.float64) for w in node_pairs())
    inside, passed = [], 1.0
    for w in (wi, wo):
        below = w[:, :2] / eta
        z = np.sqrt(1 - (below**2).sum(axis=1))
        inside.append(np.concatenate([below, z[:, None]], axis=1))
        one, zero = np.full(len(w), eta), np.zeros(len(w))
        passed = passed * (1 - fresnel.exact(w[:, 2], one, zero, NUMPY)) * np.exp(-sigma_t / z)
    expected = passed * faint(*inside) / eta**2
    steep = (wi[:, 2] > 0.3) & (wo[:, 2] > 0.3)
    # f in half precision of ln f is 0.5 % off, and interpolated between the nodes of its table.
    ratio = rest[steep] / expected[steep]
    np.testing.assert_allclose(ratio, 1, atol=0.05)
    assert np.median(np.abs(ratio - 1)) < 0.004


def test_reciprocal_to_the_bit_and_zero_below_the_horizon(coated, directions):
    assert coated.beside_lobe
    wi, wo = directions, np.roll(directions, 1, axis=0)
    f = coated.f(wi, wo)
    np.testing.assert_array_equal(f, coated.f(wo, wi))
    above = (wi[:, 2] > 0) & (wo[:, 2] > 0)
    assert (f[above] > 0).all() and not f[~above].any()


def test_files_keep_the_kind_of_table(bottom, coated, trained, tmp_path):
    coated.save(tmp_path / "a")
    again = load(tmp_path / "a", trained)
    assert again == coated and hash(again) == hash(coated) and again.beside_lobe
    assert Material(coated.latents, trained, table=coated.table) != coated
    bottom.save(tmp_path / "b")
    assert not load(tmp_path / "b", trained).beside_lobe


def test_each_of_many_channels_is_as_it_is_alone(trained):
    """Four media, none a sum of the others: albedo and depth of the coat, up and down."""
    bottom = encode(lambda wi, wo: sheen(wi, wo)[:, :1], trained)
    bottom = replace(bottom, table=table_of_values(sheen(*node_pairs())[:, :1]))
    media = [(0.02, 0.18), (0.0, 0.23), (0.0, 0.18), (0.0, 0.13)]
    latents, table = np.repeat(bottom.latents, 4, axis=0), np.repeat(bottom.table, 4, axis=-1)
    four = replace(bottom, latents=latents, table=table)

    def layered(below, media):
        columns = [(0.2, 1.5, albedo, depth, 0.0) for albedo, depth in media]
        return layer_material(CoatParameters.of_columns(np.array(columns).T), below).table

    alone = [layered(bottom, [medium])[..., 0] for medium in media]
    np.testing.assert_allclose(layered(four, media), np.stack(alone, axis=-1), atol=0.01)
