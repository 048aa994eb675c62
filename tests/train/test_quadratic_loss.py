"""Quadratic forms: slope and curvature of the stacks' loss, and re-encoded lower parts."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from urushi.core.probe_pairs import probe_pairs
from urushi.nets.architecture import init
from urushi.nets.decoder import decode
from urushi.nets.encoder import encode
from urushi.nets.features import direction_features
from urushi.nets.layerer import layer
from urushi.train import examples
from urushi.train.losses import stack_loss
from urushi.train.stages import layering
from urushi.train.store import Store

#: Each compiles a training step for seconds.
pytestmark = pytest.mark.research


@pytest.fixture(scope="module")
def depths(tiny, tiny_data):
    return examples.load(Store(tiny_data, tiny.data), tiny.arch, tiny.pairs)


@pytest.fixture(scope="module")
def params(tiny):
    drawn = init(tiny.arch, 3)
    rng = np.random.default_rng(4)  # also for biases and the scale, which start at zero
    return {k: v + 0.05 * rng.standard_normal(v.shape).astype(np.float32) for k, v in drawn.items()}


def test_the_slope_is_that_of_the_loss(tiny, depths, params):
    held = depths[1].examples()
    forms = layering.measure_quadratic_losses(params, tiny.arch, held)
    per_stack = len(held.f) // len(held.probes)
    for stack in (0, 7, len(held.probes) - 1):
        items = np.flatnonzero(held.stack == stack)
        assert len(items) == per_stack == 2

        def loss(z, items=items):
            rest = decode(params, tiny.arch, z[None, None], held.features[items])
            f_hat = held.top[items] + rest
            return stack_loss(f_hat, held.f[items])

        slope = jax.grad(loss)(jnp.asarray(forms.z[stack]))
        np.testing.assert_allclose(forms.slope[stack], slope, rtol=2e-3, atol=1e-5)


def test_the_curvature_is_exact_where_the_decoded_values_are_exact(tiny, params):
    # Without errors the loss is its Gauss-Newton form up to third order in the code's change.
    rng = np.random.default_rng(5)
    z = rng.standard_normal((3, tiny.arch.latent - tiny.arch.lobe)).astype(np.float32)
    features = rng.standard_normal((3, 64, 8)).astype(np.float32)
    top = 0.2 * rng.random((3, 64)).astype(np.float32)
    f = top + decode(params, tiny.arch, z[:, None], features)
    slope, curvature = layering.quadratic_expansion(
        params, tiny.arch, jnp.asarray(z), features, top, f
    )
    np.testing.assert_allclose(slope, 0.0, atol=1e-4)
    d = rng.standard_normal(z.shape).astype(np.float32)
    for size in (0.01, 0.02):
        moved = jnp.asarray(z + size * d)
        expected = [
            float(stack_loss(
                top[i, None] + decode(params, tiny.arch, moved[i, None, None], features[i, None]),
                f[i, None],
            ))
            for i in range(3)
        ]  # fmt: skip
        # The third order is a relative error in proportion to the size, here up to 10 times the
        # size. The weights of halves, which are constant in the form, add EASE = 3e-3 in 1e-2.
        predicted = layering.loss_increase(moved, z, np.zeros_like(z), curvature)
        np.testing.assert_allclose(predicted, expected, rtol=10 * size)


def test_lower_parts_are_decoded_and_encoded_again(tiny, depths, params):
    held = depths[2].examples()
    forms = layering.measure_quadratic_losses(params, tiny.arch, held)
    arch = tiny.arch
    bottoms = np.concatenate([held.lobes, encode(params, arch, held.probes)], axis=-1)
    lower = layer(params, arch, bottoms, tuple(held.coats[:, 1].T))
    own, code = np.split(lower, [arch.lobe], axis=-1)
    f = decode(params, arch, code[:, None], direction_features(*probe_pairs(arch.probes)))
    below = np.concatenate([own, encode(params, arch, f)], axis=-1)
    np.testing.assert_allclose(forms.bottoms, bottoms, atol=1e-5)
    np.testing.assert_allclose(forms.below, below, atol=1e-4)
    whole = layer(params, arch, lower, tuple(held.coats[:, 0].T))
    np.testing.assert_allclose(forms.z, whole[:, arch.lobe :], atol=1e-5)
    np.testing.assert_array_equal(
        layering.loss_increase(forms.z, forms.z, forms.slope, forms.curvature), 0.0
    )
