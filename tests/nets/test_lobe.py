"""The analytic lobe: reciprocal to the bit, and finite; NumPy and JAX under jit agree."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.untrained import untrained

from urushi.nets import layerer, lobe
from urushi.nets.mlp import POLYNOMIALS


def random_lobes(count: int, seed: int) -> np.ndarray:
    """Lobes (count, 6) of all kinds in double precision.

    Dielectrics of eta in [0.5, 3], metals by Fresnel's equations and by Schlick's, and none.
    """
    rng = np.random.default_rng(seed)
    alpha = 0.01 ** rng.random(count)
    eta, none = rng.uniform(0.5, 3, count), np.zeros(count)
    kinds = [
        lobe.of_coat(alpha, eta),
        np.stack([alpha, none, none, none + 1, eta, rng.uniform(0, 8, count)], axis=-1),
        np.stack([alpha, rng.random(count), none + 1, none, none + 1.5, none], axis=-1),
        np.tile(np.array(lobe.NO_LOBE), (count, 1)),
    ]
    return np.choose(rng.integers(4, size=count)[:, None], kinds)


LOBES = random_lobes(300, 1).astype(np.float32)[:, None]


def test_f_is_reciprocal_to_the_bit_and_finite(pairs):
    """At the horizon, at the mirror direction, and below the surface, too."""
    slanted = [math.sqrt(1 - 1e-6), 0, 1e-3]
    corners = [[0, 0, 1], [1, 0, 0], slanted, [-slanted[0], 0, 1e-3], [0.6, 0, -0.8]]
    both = np.float32([[wi, wo] for wi in corners for wo in corners])
    wi, wo = (np.concatenate(sides) for sides in zip(pairs, both.swapaxes(0, 1), strict=True))
    f = lobe.f(LOBES, wi, wo)
    assert f.dtype == np.float32
    assert np.array_equal(f, lobe.f(LOBES, wo, wi))
    assert np.isfinite(f).all() and (f[:, : len(pairs[0])] >= 0).all()


def test_a_mirror_like_surface_has_the_peak_of_ggx():
    """Head-on: D = 1 / (pi alpha^2), G = 1."""
    expected = 0.04 / (4 * math.pi * 1e-4)
    up = np.float32([0, 0, 1])
    head_on = lobe.f(np.array(lobe.of_coat(np.array(0.01), np.array(1.5))), up, up)
    assert head_on == pytest.approx(expected, rel=1e-5)


def test_features_are_finite_and_of_about_unit_size():
    features = lobe.lobe_features(random_lobes(4000, 5).astype(np.float32))
    assert features.dtype == np.float32
    assert features.shape == (4000, lobe.LOBE_FEATURES[1])
    assert np.isfinite(features).all()
    assert np.abs(features).max() < 8


def test_the_width_of_an_invisible_lobe_does_not_matter():
    none = np.tile(np.array(lobe.NO_LOBE), (5, 1))
    none[:, 0], none[:, 4] = np.geomspace(0.01, 1, 5), np.linspace(0.5, 3, 5)
    features = lobe.lobe_features(none)
    assert np.array_equal(features, np.broadcast_to(features[0], features.shape))


def test_lobes_agree_and_their_gradients_are_finite(pairs):
    ours, theirs = lobe.f(LOBES, *pairs), jax.jit(lobe.f)(LOBES, *pairs)
    # The rounding of wi + wo, 1e-7, over the lobe's width in h at grazing angles.
    np.testing.assert_allclose(theirs, ours, rtol=2e-2, atol=1e-6)
    features = jax.jit(lobe.lobe_features)(LOBES)
    np.testing.assert_allclose(features, lobe.lobe_features(LOBES), atol=1e-5)

    def total(x, wi, wo):
        return jnp.sum(lobe.f(x, wi, wo)) + jnp.sum(lobe.lobe_features(x))

    assert np.isfinite(np.asarray(jax.jit(jax.grad(total))(LOBES, *pairs))).all()


@pytest.mark.parametrize("activation", POLYNOMIALS)
def test_layering_agrees_and_its_gradients_are_finite(activation):
    model, rng = untrained(functions=18, activation=activation), np.random.default_rng(17)
    z = np.concatenate([random_lobes(40, 17), rng.normal(size=(40, 18))], axis=-1)
    coats = rng.uniform([0.01, 0.5, 0, 0, -0.9], [1, 3, 1, 8, 0.9], (40, 5))
    z, coats = z.astype(np.float32), coats.T.astype(np.float32)

    def layered(params, z, coats):
        return layerer.layer(params, model.arch, z, tuple(coats))

    params = {name: jnp.asarray(x) for name, x in model.params.items() if "layerer" in name}
    ours, theirs = layered(model.params, z, coats), jax.jit(layered)(params, z, coats)
    assert isinstance(ours, np.ndarray) and ours.dtype == theirs.dtype == np.float32
    np.testing.assert_allclose(ours, theirs, atol=3e-5)
    gradient = jax.jit(jax.grad(lambda *x: jnp.mean(layered(*x))))(params, z, coats)
    assert all(bool(jnp.isfinite(g).all()) for g in gradient.values())
