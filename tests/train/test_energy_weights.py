"""Energy weights: integrals by training pairs, and the share of peaks."""

import functools
import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from urushi.checks import Widths
from urushi.core import direction_sets
from urushi.nets import lobe
from urushi.nets.architecture import Architecture, init
from urushi.nets.decoder import decode
from urushi.nets.features import direction_features
from urushi.train import losses
from urushi.train.batches import Batch
from urushi.train.losses import squared_errors, stack_weights
from urushi.train.stages import decoding, joint
from urushi.train.stages.layering import quadratic_expansion

#: Each compiles a training step for seconds.
pytestmark = pytest.mark.research

PAIRS = 1 << 18


DRAWN = {1: direction_sets.training_pairs, 2: direction_sets.anisotropic_pairs}


@functools.cache
def pairs_of(widths):
    """Training pairs, and the weights that make their means integrals of cos^2 cos^2."""
    wi, wo = DRAWN[widths](np.random.default_rng(1), PAIRS)
    features = jnp.asarray(direction_features(wi, wo, widths))
    return wi, wo, np.asarray(losses.cosines_over_density(features), np.float64)


@pytest.fixture(params=[1, 2])
def pairs(request):
    return pairs_of(request.param)


def test_the_mean_over_training_pairs_is_the_integral_over_both_hemispheres(pairs):
    _, _, weights = pairs
    error = weights.std() / math.sqrt(PAIRS)
    expected = (2 * math.pi / 3) ** 2  # of cos^2 over a hemisphere, squared
    # Five standard errors, and half a per cent for pairs below the lowest cosine.
    assert weights.mean() == pytest.approx(expected, abs=5 * error, rel=0.005)
    assert error < 0.01 * expected


@pytest.mark.parametrize(
    ("number", "widths"),
    [(1, (0.02, 0.02)), (1, (0.2, 0.2)), (2, (0.02, 0.02)), (2, (0.03, 0.2)), (2, (0.5, 0.1))],
)
def test_the_energy_of_a_narrow_lobe_is_that_of_an_independent_estimate(number, widths):
    """Importance sampling of the half vector by its slopes is the other estimate."""
    wi, wo, weights = pairs_of(number)
    alpha = Widths(*(np.float64(width) for width in widths))
    values = lobe.shape(alpha, wi.astype(np.float64), wo.astype(np.float64)) * weights
    rng = np.random.default_rng(2)
    count = 1 << 20
    cosine = rng.random(count)  # wi uniform over the hemisphere
    turn, radius2 = 2 * math.pi * rng.random(count), rng.random(count)
    sine = np.sqrt(1 - cosine**2)
    wi = np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine], -1)
    tangent = np.sqrt(radius2 / (1 - radius2))  # GGX slopes of width one (Walter 2007, eq. 35)
    turn = 2 * math.pi * rng.random(count)
    x, y = alpha.u * tangent * np.cos(turn), alpha.v * tangent * np.sin(turn)
    h = np.stack([x, y, np.ones(count)], -1) / np.sqrt(1 + x * x + y * y)[:, None]
    across = (h * wi).sum(-1)
    wo = 2 * across[:, None] * h - wi
    inside = (across > 0) & (wo[:, 2] > 0)
    slopes = 1 / (math.pi * alpha.u * alpha.v * (1 + tangent**2) ** 2)
    density = slopes / h[:, 2] ** 3 / (4 * np.abs(across)) / (2 * math.pi)
    wo[~inside] = wi[~inside]
    squares = (wi[:, 2] * wo[:, 2]) ** 2
    other = np.where(inside, lobe.shape(alpha, wi, wo) * squares / density, 0)
    error = math.hypot(values.std() / math.sqrt(PAIRS), other.std() / math.sqrt(count))
    assert error < 0.02 * other.mean()
    assert values.mean() == pytest.approx(other.mean(), abs=5 * error)


def test_weights_have_mean_one_and_do_not_follow_scale():
    wi, wo, _ = (part[:4096] for part in pairs_of(2))
    features = jnp.asarray(direction_features(wi, wo, 2)).reshape(64, 64, -1)
    f = 0.1 + np.random.default_rng(3).random((64, 64)).astype(np.float32)
    weights = np.asarray(losses.energy_weights(jnp.asarray(f), features))
    assert (weights >= 0).all()
    assert (weights.max(-1) < losses.LARGEST_WEIGHT).all()
    np.testing.assert_allclose(weights.mean(-1), 1, rtol=1e-5)
    twice = np.asarray(losses.energy_weights(jnp.asarray(2 * f), features))
    np.testing.assert_allclose(twice, weights, rtol=1e-5)


@pytest.mark.parametrize("share", [0.0, 0.7, 1.0])
def test_the_slope_is_that_of_the_weighted_loss(share):
    arch = Architecture(latent=12, decoder=(8,), widths=2)
    rng = np.random.default_rng(4)
    params = {k: v + 0.05 * rng.standard_normal(v.shape) for k, v in init(arch, 3).items()}
    params = {k: v.astype(np.float32) for k, v in params.items()}
    features = jnp.asarray(direction_features(*(w[:64] for w in pairs_of(2)[:2]), 2))[None]
    z = jnp.asarray(rng.standard_normal((1, arch.latent - arch.lobe)), jnp.float32)
    top, f = rng.random((2, 1, 64)).astype(np.float32)

    def loss(z):
        f_hat = top + decode(params, arch, z[:, None], features)
        weights = 1 - share + share * losses.energy_weights(f_hat, features)
        squares = squared_errors(f_hat, f)
        return jnp.mean(weights * stack_weights(weights * squares) * squares)

    slope, _ = quadratic_expansion(params, arch, z, features, top, f, share)
    np.testing.assert_allclose(slope, jax.grad(loss)(z), rtol=1e-3, atol=1e-6)


@pytest.mark.parametrize("widths", [1, 2])
def test_joint_and_decoding_loss_weigh_pairs_alike(widths, monkeypatch):
    """Where all pairs scatter alike, the decoding stage has the fit of the joint one."""
    arch = Architecture(
        latent=12, decoder=(8,), encoder=(8,), layerer=(8,), sampler=(4,), probes=6, widths=widths
    )
    some = [w[:64] for w in pairs_of(widths)[:2]]
    params, rng = init(arch, 3), np.random.default_rng(5)
    features = jnp.asarray(direction_features(*some, widths)).reshape(4, 16, -1)
    batch = Batch(
        lobes=np.tile(np.array(lobe.no_lobe(widths), np.float32), (4, 1)),
        probes=rng.random((4, 6), np.float32),
        coats=(),
        features=features,
        top=np.zeros((4, 16), np.float32),
        f=rng.random((4, 16), np.float32),
    )
    at_probes = features[0, :6]
    plain, weighted = (
        joint.joint_loss(params, arch, batch, at_probes, share)[1]["fit"] for share in (0.0, 0.9)
    )
    assert abs(weighted / plain - 1) > 0.01
    monkeypatch.setattr(decoding, "scatter_weights", jnp.ones_like)
    trained = {**params, **decoding.fresh_scatter(arch, 0)}
    again = decoding.weighted_loss(trained, params, arch, batch, 0.9)[1]["fit"]
    assert again == pytest.approx(float(weighted), rel=1e-5)
