"""Coats over materials with a table, against closed forms and the walk."""

from dataclasses import replace

import numpy as np
import pytest
from tests.untrained import untrained

import urushi
from urushi.checks import CoatParameters
from urushi.core import direction_sets, fresnel
from urushi.core.error_metrics import stack_error
from urushi.core.namespace import NUMPY
from urushi.core.table import interpolated, node_pairs, table_of_values
from urushi.material import Material, encode, layer, load
from urushi.material.coated_table import coated_rest
from urushi.material.layer import layer_material
from urushi.measured.tabulated import MeasuredSurface, bin_centres
from urushi.nets.lobe import f as lobe_f
from urushi.nets.lobe import of_coat
from urushi.walk import conductor, dielectric, diffuse

COATS = {
    "smooth": {"alpha": 0.03, "eta": 1.5},
    "rough": {"alpha": 0.3, "eta": 1.5},
    "tinted": {"alpha": 0.1, "eta": 1.5, "albedo": 0.0, "sigma_t": (0.1, 0.4, 1.2)},
    "scattering": {
        "alpha": 0.1, "eta": 1.4, "albedo": (0.95, 0.85, 0.7), "sigma_t": 1.0, "g": 0.3,
    },
}  # fmt: skip


def sheen(wi, wo):
    """Reciprocal values that no layered material has: a wide lobe, and light at grazing angles."""
    h = wi + wo
    cos_h = h[:, 2] / np.linalg.norm(h, axis=1)
    lobe = 0.2**2 / (np.pi * (cos_h**2 * (0.2**2 - 1) + 1) ** 2)
    grazing = np.exp(-3 * (np.maximum(wi[:, 2], 0.05) + np.maximum(wo[:, 2], 0.05)))
    return np.stack([0.05 * lobe + 0.1, 0.1 * lobe + 0.3 * grazing, 0.02 + 0.6 * grazing], axis=1)


class Sheen(MeasuredSurface):
    """`sheen` as a measured BRDF, for the walk."""

    def f(self, wi, wo):
        return sheen(wi, wo).astype(np.float32)

    def table(self):
        from urushi.core.directions import directions_at

        angles = np.broadcast_arrays(*bin_centres((64, 32, 32)))
        wi, wo = directions_at(*(x.ravel() for x in angles))
        wi, wo = (np.where(w[:, 2:] > 0.02, w, [0, 0, 1]) for w in (wi, wo))
        return sheen(wi, wo).reshape(64, 32, 32, 3).astype(np.float32)


@pytest.fixture(scope="module")
def trained():
    """Any networks: tables are computed without them."""
    return untrained(0)


@pytest.fixture(scope="module")
def bottom(trained) -> Material:
    return encode(sheen, trained, table=True)


def coated(bottom, coat) -> Material:
    medium = {name: value for name, value in coat.items() if name not in ("alpha", "eta")}
    return layer(dielectric(coat["alpha"], coat["eta"]), bottom, **medium)


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


@pytest.mark.parametrize("name", ["smooth", pytest.param("scattering", marks=pytest.mark.slow)])
def test_as_the_walk_over_a_measured_bottom(name, bottom):
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(1), 200)
    stack = urushi.coat(Sheen(), **COATS[name])
    walk, _ = urushi.simulate(stack, wi, wo, walks=2048, progress=False)
    assert error(coated(bottom, COATS[name]).f(wi, wo), walk, wi, wo) < 0.03


def test_a_narrow_lobe_below_a_rough_coat(trained):
    """Few pairs of directions of the interface meet the lobe of polished metal."""
    metal = of_coat(np.float64(0.02), np.float64(4.0))  # of an index of 4, reflects a third
    shiny = with_table(lambda wi, wo: lobe_f(metal, wi, wo), trained)
    table = table_of_values(coated_rest(shiny, parameters(0.3, 1.5)))
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(2), 200)
    top = lobe_f(of_coat(np.float64(0.3), np.float64(1.5)), wi, wo)
    stack = urushi.coat(conductor(0.02, eta=6.0, k=0.0), alpha=0.3, eta=1.5)  # 6 = 4 * 1.5
    walk, _ = urushi.simulate(stack, wi, wo, walks=8192, progress=False)
    assert error(interpolated(table, wi, wo) + top[:, None], walk[:, :1], wi, wo) < 0.08


def test_reciprocal_to_the_bit_and_zero_below_the_horizon(bottom, directions):
    material = coated(bottom, COATS["scattering"])
    assert material.beside_lobe
    wi, wo = directions, np.roll(directions, 1, axis=0)
    f = material.f(wi, wo)
    np.testing.assert_array_equal(f, material.f(wo, wi))
    above = (wi[:, 2] > 0) & (wo[:, 2] > 0)
    assert (f[above] > 0).all() and not f[~above].any()


def test_coats_nest(trained):
    """Two clear coats of one index are one, apart from the inner interface, which is not there."""
    red = with_table(lambda wi, wo: np.full(len(wi), 0.5 / np.pi), trained)
    once = layer(dielectric(0.05, 1.3), red, sigma_t=0.2)
    twice = layer(dielectric(0.1, 1.5), once, sigma_t=0.3)
    assert once.beside_lobe and twice.beside_lobe
    stack = urushi.coat(
        urushi.coat(diffuse(0.5), alpha=0.05, eta=1.3, sigma_t=0.2), alpha=0.1, eta=1.5, sigma_t=0.3
    )
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(3), 200)
    walk, _ = urushi.simulate(stack, wi, wo, walks=8192, progress=False)
    assert error(twice.f(wi, wo), walk[:, :1], wi, wo) < 0.03


def test_files_keep_the_kind_of_table(bottom, trained, tmp_path):
    material = coated(bottom, COATS["rough"])
    material.save(tmp_path / "a")
    again = load(tmp_path / "a", trained)
    assert again == material and hash(again) == hash(material) and again.beside_lobe
    whole = Material(material.latents, trained, table=material.table)
    assert whole != material
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
