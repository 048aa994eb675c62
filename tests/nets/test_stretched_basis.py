"""The basis of two widths: symmetries, codes of one width, stretch, and least squares."""

import numpy as np
import pytest
from tests.directions import at_cosines

from urushi.core.direction_sets import cosine_pairs
from urushi.core.namespace import NUMPY, Components
from urushi.core.probe_pairs import pair_measure
from urushi.core.stretched import FACTORS, stretched
from urushi.core.table import SHAPE, node_pairs
from urushi.nets import lobe as lobes
from urushi.nets.basis import decode
from urushi.nets.code_fit import log_stretch, solve_codes
from urushi.nets.networks import Architecture
from urushi.nets.weights import Model, anisotropic_model, default_model

AZIMUTHAL = (2, 2, 1, 1, 1)


@pytest.fixture(scope="module")
def model() -> Model:
    """The shipped functions of one width, and smooth further ones."""
    rows = default_model().params["basis.rows"]
    count = rows.shape[1] - 1 + sum(AZIMUTHAL)
    arch = Architecture(count, 384, (8,), widths=2, azimuthal=AZIMUTHAL)
    params = {name: np.zeros(shape) for name, shape in arch.parameter_shapes().items()}
    axes = np.meshgrid(*(np.linspace(0, 1, n) for n in SHAPE), indexing="ij")
    u, v, w = (x.ravel() for x in axes)
    more = np.stack([u, u * v, v, v * v, w * v, u * (1 - u), v * (1 - v)], axis=-1)
    params["basis.rows"] = np.concatenate([rows, more], axis=1)
    params["basis.measure"] = pair_measure(384)
    params["basis.prior"] = 1e-3 * np.eye(count)
    return Model.of(arch, params, {})


@pytest.fixture(scope="module")
def codes(model) -> np.ndarray:
    """Codes (3, L) with stretches of their own."""
    rng = np.random.default_rng(0)
    rest = 0.2 * rng.normal(size=(3, model.arch.functions))
    stretch = np.array([[-0.5], [0.0], [0.75]])
    lobe = np.tile(lobes.no_lobe(2), (3, 1))
    return np.concatenate([lobe, rest, stretch], axis=1).astype(np.float32)


PAIRS = cosine_pairs(np.random.default_rng(1), 400, lowest_cosine=0.02)


def test_symmetries_to_the_bit(model, codes):
    """Of lobes and rests."""
    wi, wo = PAIRS
    codes = np.array(codes)
    codes[:, :7] = [(0.1, 0, 0, 1, 1.5, 0, 0.4), (0.3, 0.8, 1, 0, 1.5, 0, 0.05), lobes.no_lobe(2)]
    f = model.networks.f(codes[:, None], wi, wo)
    np.testing.assert_array_equal(f, model.networks.f(codes[:, None], wo, wi))
    for sign in np.float32([[1, -1, 1], [-1, 1, 1], [-1, -1, 1]]):
        np.testing.assert_array_equal(f, model.networks.f(codes[:, None], wi * sign, wo * sign))


def test_codes_of_one_width_are_codes_of_two(model):
    own = default_model()
    z = np.concatenate([lobes.NO_LOBE, np.linspace(-0.3, 0.3, own.arch.functions)])[None]
    z = z.astype(np.float32)
    lobe = lobes.with_two_widths(z[:, :6])
    zeros = np.zeros((1, sum(AZIMUTHAL) + 1), np.float32)
    two = np.concatenate([lobe, z[:, 6:], zeros], axis=1)
    np.testing.assert_allclose(model.networks.f(two, *PAIRS), own.networks.f(z, *PAIRS), rtol=1e-4)


def test_a_stretched_lobe_is_round():
    """The GGX distribution of two widths depends on the stretched half angle alone."""
    both, apart = (Components(*w.T.astype(float)) for w in (PAIRS[0] + PAIRS[1], 0 * PAIRS[0]))
    a, b = 0.1, 0.4
    (u, _, _), _ = stretched(both, apart, b / a, NUMPY)
    order = np.argsort(((both.x / a) ** 2 + (both.y / b) ** 2) / both.z**2)
    assert (np.diff(u[order]) >= -1e-12).all()


def test_a_table_is_the_sum_of_its_terms(model, codes):
    """At the nodes, of a stretch of one; nodes where a direction grazes are moved up."""
    z = codes[1:2]
    wi, wo = node_pairs()
    above = (wi[:, 2] > 0.05) & (wo[:, 2] > 0.05) & (np.arange(len(wi)) % 7 == 0)
    both, apart = (Components(*w[above].T.astype(float)) for w in (wi + wo, wi - wo))
    _, factors = stretched(both, apart, 1.0, NUMPY)
    terms = model.networks.table(z).reshape(-1, 1 + FACTORS)[above]
    logs = (terms * np.stack([np.ones_like(factors[0]), *factors], axis=-1)).sum(axis=1)
    expected = model.networks.f(z, wi[above], wo[above])
    np.testing.assert_allclose(np.exp(logs), expected, rtol=0.02)


@pytest.mark.parametrize("width", [0.05, 0.1, 0.2, 0.4])
def test_the_stretch_is_that_of_the_lobe(model, width):
    """Within 0.2, which f hardly shows; of round lobes within a step, with diffuse light too."""
    pairs, measure = model.networks.pairs(), model.networks.basis.measure

    def stretch(u, v, diffuse=0.0):
        lobe = np.float32([u, 0.9, 1, 0, 1.5, 0, v])
        return float(log_stretch(lobes.f(lobe, *pairs)[None] + diffuse, measure)[0])

    assert abs(stretch(width, width)) < 0.04 and abs(stretch(width, width, 0.1)) < 0.04
    expected = np.log(2)
    assert stretch(width / 2, 2 * width) == pytest.approx(expected, abs=0.2)
    assert stretch(2 * width, width / 2) == pytest.approx(-expected, abs=0.2)


def test_codes_are_those_of_their_values(model, codes):
    basis, rest = model.networks.basis, codes[:, 7:]
    values = np.stack([decode(z[:-1], basis.probe_rows(z[-1])) for z in rest])
    found = solve_codes(basis, values, np.ones_like(values), rest[:, -1])
    again = np.stack([decode(z[:-1], basis.probe_rows(z[-1])) for z in found])
    np.testing.assert_array_equal(found[:, -1], rest[:, -1])
    off = np.abs(again - values) @ basis.measure / (values @ basis.measure)
    assert off.max() < 0.01


def test_channels_share_the_stretch(model):
    pairs, lobe = model.networks.pairs(), np.float32([0.1, 0.9, 1, 0, 1.5, 0, 0.4])
    own = lobes.f(lobe, *pairs)
    f = np.stack([own, 0.5 * own + 0.2, 0.1 * own + 0.3])
    codes = model.networks.encode(f, np.float32(lobes.no_lobe(2)))
    assert (codes[:, -1] == codes[0, -1]).all() and codes[0, -1] > 0.4


@pytest.mark.parametrize("degrees", [0, 10, 40, 70])
def test_f_is_continuous_where_azimuths_mean_nothing(degrees):
    """Around mirror directions and equal directions, within 0.001 degrees: the factors fade.

    A smooth f changes by less than a thousandth there.
    """
    networks, rng = anisotropic_model().networks, np.random.default_rng(3)
    rest = rng.standard_normal((4, networks.arch.rest)).astype(np.float32)
    rest[:, -1] = -0.5, 0, 0.5, 1
    z = np.concatenate([np.tile(np.float32(lobes.no_lobe(2)), (4, 1)), rest], axis=1)
    turn, polar = np.linspace(0, 2 * np.pi, 25), np.radians(degrees)
    wi = at_cosines(np.cos(polar), np.arctan2(0.6, 0.8)).astype(float)
    away = 2e-5 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
    for centre in (wi * [-1, -1, 1], wi):
        wo = centre + away
        wo /= np.linalg.norm(wo, axis=1, keepdims=True)
        pairs = np.broadcast_to(wi, wo.shape), wo
        f = networks.rest_at_all(z, networks.basis.functions_at(*pairs))
        assert (f.max(axis=1) / f.min(axis=1) - 1).max() < 0.02
