"""Projection by Adam: it finds codes again, is repeatable, and its loss stays a number."""

import numpy as np
import pytest
from fan2022 import networks, projection
from fan2022.architecture import PaperArchitecture
from fan2022.inference import direction_inputs, evaluate

from urushi.errors import ParameterError


@pytest.fixture(scope="module")
def directions():
    return direction_inputs(*networks.projection_pairs())[None]


def test_compression_is_the_authors_for_values_and_bounded_for_all():
    x = np.array([0.0, 0.5, 3.0, 1e30, np.float32(3e38)], np.float32)
    np.testing.assert_allclose(projection.compressed(x[:3]), x[:3] / (1 + x[:3]))
    assert (np.abs(projection.compressed(np.concatenate([x, -x]))) <= 1).all()


def test_the_rate_falls_as_the_authors_script_prints():
    """compress.py: x .003^.24 at steps 200, 400 and 600 of 1,000; its README prints the last."""
    rates = np.array([projection.rate(taken, 1000) for taken in range(1000)])
    np.testing.assert_array_equal(1 + np.flatnonzero(np.diff(rates)), [200, 400, 600])
    np.testing.assert_allclose(rates[[0, 200, 400]], [1e-3, 2.480e-4, 6.150e-5], rtol=1e-3)
    assert f"{rates[-1]:.7f}" == "0.0000153"


@pytest.mark.research
def test_the_code_of_a_decoded_brdf_decodes_to_it_again(positive, directions):
    """The values are found, not the code: many codes decode to about the same values.

    The code is as far from the start as published codes are. The rate falls while the code still
    moves, so that some error remains.
    """
    known = 1 + 0.05 * np.random.default_rng(4).normal(size=(1, 32)).astype(np.float32)
    f = evaluate(positive, known[:, None], directions)
    z, error = projection.project(positive, directions, f, PaperArchitecture(pairs=24))
    first = np.abs(evaluate(positive, np.ones((1, 1, 32), np.float32), directions) - f).mean()
    assert np.abs(evaluate(positive, z[:, None], directions) - f).mean() < 0.25 * first
    assert error[0] < 0.5 * first  # at the 24 pairs of the last step


def test_the_same_seed_gives_the_same_code_alone_or_with_others(positive, directions):
    f = np.random.default_rng(5).gamma(0.5, size=(2, networks.PAIRS)).astype(np.float32)
    options = PaperArchitecture(steps=5, pairs=64)
    whole, _ = projection.project(positive, directions, f, options)
    again, _ = projection.project(positive, directions, f, options)
    np.testing.assert_array_equal(whole, again)
    alone, _ = projection.project(positive, directions, f[1:], options)
    np.testing.assert_allclose(alone[0], whole[1], atol=1e-4)  # sums in another order
    draws = [projection.draws(options, 4096, seed) for seed in (1, 1, 2)]
    np.testing.assert_array_equal(*draws[:2])
    assert not np.array_equal(*draws[1:])
    assert projection.draws(PaperArchitecture(), 4096) is None


def test_the_loss_is_a_number_for_any_values_of_f_and_of_the_network(positive, directions):
    """Even where the network's outputs cross -1, at which x / (1 + x) has a pole."""
    negative = {**positive, "evaluation.3.bias": np.array([-1.0], np.float32)}
    f = np.array([[0.0], [1e30]], np.float32).repeat(networks.PAIRS, axis=1)
    z, error = projection.project(negative, directions, f, PaperArchitecture(steps=8, pairs=64))
    assert np.isfinite(z).all() and np.isfinite(error).all()


def test_encode_uses_the_projection_of_the_weights(paper, positive):
    """They take it from the architecture, which the weights file records."""
    assert PaperArchitecture.from_json(paper.arch.to_json()) == paper.arch
    other = networks.PaperNetworks(PaperArchitecture(), positive, {})
    assert paper.fingerprint != other.fingerprint
    codes = paper.encode(np.full((1, 2, networks.PAIRS), 0.3, np.float32))
    assert codes.shape == (1, 2, 32)
    assert 0 < np.abs(codes - 1).max() <= paper.arch.steps * projection.RATE * 1.01


@pytest.fixture
def projected(monkeypatch):
    """The first values of all BRDFs that are projected; their codes are the roots of pi f."""
    found = []

    def project(params, directions, f, arch):
        found.extend(f[:, 0])
        return np.repeat(np.sqrt(np.pi * f[:, :1]), 32, axis=1), None

    monkeypatch.setattr(projection, "project", project)
    return found


def test_a_texture_of_lambertian_brdfs_takes_few_projections(positive, projected):
    """Codes are interpolated; at the levels themselves they are those of the projection."""
    own = networks.PaperNetworks(PaperArchitecture(), positive, {})
    reflectance = np.random.default_rng(0).uniform(0, 1, (500, 3))
    f = np.repeat(reflectance[..., None] / np.pi, networks.PAIRS, axis=-1).astype(np.float32)
    codes = own.encode(f)
    assert len(projected) <= networks.LEVELS + 1 and max(projected) < 1.001 / np.pi
    expected = np.repeat(np.sqrt(reflectance)[..., None], 32, axis=-1)
    np.testing.assert_allclose(codes, expected, atol=1e-5)
    own.encode(f[:50])
    assert len(projected) <= networks.LEVELS + 1  # they are kept
    before = len(projected)
    own.encode(f[:20] * np.linspace(0.5, 1.5, f.shape[-1], dtype=np.float32))
    assert len(projected) == before + 60


def test_equal_interfaces_are_projected_once(positive, projected, monkeypatch):
    def rows(kind, columns, row, wi, wo):
        return (columns["alpha"] * columns["eta"])[row]

    monkeypatch.setattr(networks.analytic, "rows", rows)
    own = networks.PaperNetworks(PaperArchitecture(), positive, {})
    alpha = np.array([[0.1, 0.2], [0.1, 0.2]], np.float32)
    codes = own._top(alpha, np.float32(1.5))
    np.testing.assert_allclose(codes[..., 0], np.sqrt(np.pi * alpha * 1.5), rtol=1e-6)
    own._top(alpha[:1], np.float32(1.5))
    assert len(projected) == 2


@pytest.mark.parametrize("options", [{"steps": 0}, {"pairs": 2.5}, {"pairs": 1 << 21}])
def test_impossible_options_are_refused(options):
    with pytest.raises(ParameterError, match=r"give a whole number from 1 to"):
        PaperArchitecture(**options)
