"""One definition, two libraries: what training needs agrees between NumPy and JAX under jit."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests.untrained import untrained

from urushi.nets import layerer, lobe
from urushi.nets.mlp import POLYNOMIALS


@pytest.mark.parametrize("activation", POLYNOMIALS)
def test_layering_agrees_and_its_gradients_are_finite(activation, random_lobes):
    model, rng = untrained(functions=18, activation=activation), np.random.default_rng(17)
    z = np.concatenate([random_lobes(40, rng), rng.normal(size=(40, 18))], axis=-1)
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


def test_lobes_agree_and_their_gradients_are_finite(random_lobes, pairs):
    lobes = random_lobes(300, np.random.default_rng(1)).astype(np.float32)[:, None]
    ours, theirs = lobe.f(lobes, *pairs), jax.jit(lobe.f)(lobes, *pairs)
    # The rounding of wi + wo, 1e-7, over the lobe's width in h at grazing angles.
    np.testing.assert_allclose(theirs, ours, rtol=2e-2, atol=1e-6)
    np.testing.assert_allclose(
        jax.jit(lobe.lobe_features)(lobes), lobe.lobe_features(lobes), atol=1e-5
    )

    def total(x, wi, wo):
        return jnp.sum(lobe.f(x, wi, wo)) + jnp.sum(lobe.lobe_features(x))

    assert np.isfinite(np.asarray(jax.jit(jax.grad(total))(lobes, *pairs))).all()
