"""Projection by Adam: it finds codes again, is repeatable, and its loss stays a number."""

import jax.numpy as jnp
import numpy as np
import pytest

from urushi.errors import ParameterError
from urushi.fan2022 import networks, projection, training
from urushi.fan2022.architecture import AdamProjection, PaperArchitecture, init
from urushi.fan2022.inference import direction_inputs, evaluate


@pytest.fixture(scope="module")
def params():
    """Untrained networks whose values are positive nearly everywhere."""
    params = init(3)
    params["evaluation.3.bias"] = params["evaluation.3.bias"] + np.float32(0.5)
    return params


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


@pytest.mark.slow
def test_the_code_of_a_decoded_brdf_decodes_to_it_again(params, directions):
    """The values are found, not the code: many codes decode to about the same values.

    The code is as far from the start as published codes are. The rate falls while the code still
    moves, so that some error remains. JAX is faster than NumPy.
    """
    known = 1 + 0.05 * np.random.default_rng(4).normal(size=(1, 32)).astype(np.float32)
    f = np.asarray(evaluate(params, known[:, None], jnp.asarray(directions)))
    options = AdamProjection(steps=1000, pairs=24)
    at = projection.draws(options, f.shape[1])
    z, _ = training.project(params, directions, f, at, options.steps)

    def error(z):
        return np.abs(evaluate(params, z[:, None], jnp.asarray(directions)) - f).mean()

    assert error(z) < 0.25 * error(jnp.ones((1, 32)))


def test_the_gradient_is_that_of_the_loss(params, directions):
    """Adam's first step goes against the sign of the gradient: compared with finite differences."""
    f = np.full((1, 500), 0.4, np.float32)
    some = directions[:, :500]
    state = projection.step(params, projection.start(f), some, f, 1000)
    moved = np.sign(1 - state.z[0])
    np.testing.assert_allclose(np.abs(1 - state.z[0]), projection.RATE, rtol=1e-3)
    for index in np.argsort(-np.abs(state.first[0]))[:6]:
        losses = []
        for change in (-0.01, 0.01):
            z = np.ones((1, 32), np.float32)
            z[0, index] += change
            losses.append(
                projection.step(params, projection.start(f)._replace(z=z), some, f, 1000).loss[0]
            )
        assert np.sign(losses[1] - losses[0]) == moved[index]


def test_the_same_seed_gives_the_same_code_alone_or_with_others(params, directions):
    f = np.random.default_rng(5).gamma(0.5, size=(2, networks.PAIRS)).astype(np.float32)
    options = AdamProjection(steps=5, pairs=64)
    both, _ = projection.project(params, directions, f, options)
    np.testing.assert_array_equal(both, projection.project(params, directions, f, options)[0])
    alone, _ = projection.project(params, directions, f[1:], options)
    np.testing.assert_allclose(alone[0], both[1], atol=1e-4)  # sums in another order
    np.testing.assert_array_equal(
        projection.draws(options, 4096, 1), projection.draws(options, 4096, 1)
    )
    assert not np.array_equal(
        projection.draws(options, 4096, 1), projection.draws(options, 4096, 2)
    )
    assert projection.draws(AdamProjection(), 4096) is None


@pytest.mark.parametrize("value", [0.0, 1.0, 1e6, 1e30])
def test_the_loss_is_a_number_for_any_values_of_f_and_of_the_network(params, directions, value):
    """Even where the network's outputs cross -1, at which x / (1 + x) has a pole."""
    negative = {**params, "evaluation.3.bias": np.array([-1.0], np.float32)}
    f = np.full((1, networks.PAIRS), value, np.float32)
    state = projection.start(f)
    for index in projection.draws(AdamProjection(steps=8, pairs=128), networks.PAIRS):
        state = projection.step(negative, state, directions[:, index], f[:, index], 8)
        assert np.isfinite(state.loss).all() and (state.loss < 2).all()
        assert np.isfinite(state.z).all()


@pytest.mark.slow
def test_numpy_and_jax_agree(params, directions):
    f = np.random.default_rng(6).gamma(0.5, size=(2, 200)).astype(np.float32)
    some = directions[:, :200]
    ours, theirs = projection.start(f), projection.start(jnp.asarray(f))
    for _ in range(5):
        ours = projection.step(params, ours, some, f, 1000)
        theirs = projection.step(params, theirs, jnp.asarray(some), jnp.asarray(f), 1000)
    # Half of a step: Adam divides by the size of a gradient, also where it is nearly zero.
    np.testing.assert_allclose(ours.z, theirs.z, atol=projection.RATE / 2)
    np.testing.assert_allclose(ours.loss, theirs.loss, rtol=1e-3)


def test_encode_uses_the_projection_of_the_weights(params):
    """They take it from the architecture, which the weights file records."""
    arch = PaperArchitecture(AdamProjection(steps=3, pairs=32))
    assert PaperArchitecture.from_json(arch.to_json()) == arch
    own = networks.PaperNetworks(arch, params, {})
    other = networks.PaperNetworks(PaperArchitecture(AdamProjection()), params, {})
    assert own.fingerprint != other.fingerprint
    codes = own.encode(np.full((1, 2, networks.PAIRS), 0.3, np.float32))
    assert codes.shape == (1, 2, 32)
    assert 0 < np.abs(codes - 1).max() <= 3 * projection.RATE * 1.01


def test_a_texture_of_lambertian_brdfs_takes_few_projections(params, monkeypatch):
    """Codes are interpolated; at the levels themselves they are those of the projection."""
    projected = []

    def project(params, directions, f, adam):
        projected.extend(np.pi * f[:, 0])
        return np.repeat(np.sqrt(np.pi * f[:, :1]), 32, axis=1), None  # linear between levels

    monkeypatch.setattr(networks, "project", project)
    arch = PaperArchitecture(AdamProjection(steps=3, pairs=32))
    own = networks.PaperNetworks(arch, params, {})
    reflectance = np.random.default_rng(0).uniform(0, 1, (500, 3))
    f = np.repeat(reflectance[..., None] / np.pi, networks.PAIRS, axis=-1).astype(np.float32)
    codes = own.encode(f)
    assert len(projected) <= networks.LEVELS + 1 and max(projected) < 1.001
    expected = np.repeat(np.sqrt(reflectance)[..., None], 32, axis=-1)
    np.testing.assert_allclose(codes, expected, atol=1e-5)
    own.encode(f[:50])
    assert len(projected) <= networks.LEVELS + 1  # they are kept
    lobed = f[:20] * np.linspace(0.5, 1.5, f.shape[-1], dtype=np.float32)
    before = len(projected)
    own.encode(lobed)
    assert len(projected) == before + 60


@pytest.mark.parametrize("options", [{"steps": 0}, {"pairs": 2.5}, {"pairs": 1 << 21}])
def test_impossible_options_are_refused(options):
    with pytest.raises(ParameterError, match=r"give a whole number from 1 to"):
        AdamProjection(**options)
    for text in ('{"kind": "paper", "adam": {"steps": 3}}', '{"kind": "paper"}', "[]"):
        with pytest.raises(ParameterError, match="takes no options but the projection"):
            PaperArchitecture.from_json(text)


def test_pairs_are_unit_vectors_above_the_horizon_in_all_azimuths():
    for w in networks.projection_pairs():
        np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1, atol=1e-6)
        assert w[:, 2].min() > 0
        azimuth = np.arctan2(w[:, 1], w[:, 0])
        assert np.histogram(azimuth, bins=8, range=(-np.pi, np.pi))[0].min() > networks.PAIRS // 16


def test_equal_interfaces_are_projected_once(monkeypatch):
    projected = []

    def project(params, directions, f, options):
        projected.append(len(f))
        return np.repeat(f[:, :1], 32, axis=1), None

    monkeypatch.setattr(networks, "project", project)
    model = networks.PaperNetworks(PaperArchitecture(AdamProjection()), init(0), {})

    def rows(kind, columns, row, wi, wo):
        return (columns["alpha"] * columns["eta"])[row]

    monkeypatch.setattr(networks.analytic, "rows", rows)

    alpha = np.array([[0.1, 0.2], [0.1, 0.2]], np.float32)
    codes = model._top(alpha, np.float32(1.5))
    assert sum(projected) == 2
    np.testing.assert_allclose(codes[..., 0], alpha * 1.5, rtol=1e-6)
    model._top(alpha[:1], np.float32(1.5))
    assert sum(projected) == 2
