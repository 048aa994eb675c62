"""The layering stage: a widened layerer says the same, its batches, and what it learns."""

import jax
import jax.numpy as jnp
import numpy as np
import optax
import pytest

from urushi.data.store import Store
from urushi.errors import ParameterError
from urushi.nets.architecture import init
from urushi.nets.features import coat_features
from urushi.nets.layerer import layer
from urushi.train import examples
from urushi.train.soap import soap
from urushi.train.stages.layering import LayeringBatches, layering_loss, widened
from urushi.train.stages.stage import quadratic_loss


@pytest.fixture(scope="module")
def narrow(tiny):
    return init(tiny.first_arch, 3)


@pytest.fixture(scope="module")
def made(tiny, tiny_data, narrow):
    depths = examples.load(Store.open(tiny_data), tiny.arch, tiny.pairs, memory=1 << 20)
    return [
        quadratic_loss.measure_quadratic_losses(narrow, tiny.first_arch, depth.first())
        for depth in depths[1:]
    ]


@pytest.fixture(scope="module")
def wide(tiny, narrow):
    return widened(narrow, tiny.first_arch, "layerer", tiny.arch.layerer, seed=1)


def test_a_widened_layerer_says_what_it_said(tiny, narrow, wide):
    rng = np.random.default_rng(0)
    z = rng.standard_normal((50, tiny.arch.latent)).astype(np.float32)
    coats = coat_features(*rng.uniform([0.01, 1.05, 0, 0, -0.8], [1, 2, 1, 8, 0.9], (50, 5)).T)
    coats = coats.astype(np.float32)
    before = layer(narrow, tiny.first_arch, z, coats)
    np.testing.assert_allclose(layer(wide, tiny.arch, z, coats), before, atol=1e-6)
    assert wide["layerer.0.weight"].shape[1] == tiny.arch.layerer[0] > tiny.first_arch.layerer[0]


@pytest.mark.parametrize("widths", [(15,), (16, 16), ()])
def test_what_is_no_widening_is_refused(tiny, narrow, widths):
    with pytest.raises(ParameterError, match="cannot be widened"):
        widened(narrow, tiny.first_arch, "layerer", widths, seed=1)


def test_every_stack_of_a_depth_is_seen_once_an_epoch(made):
    # 32 stacks of one coat by 8, 8 of two by 2: four steps are an epoch of both.
    batches = LayeringBatches(made, (8, 2), seed=2)
    epoch = batches.take(4, 4)
    assert epoch.z.shape[:2] == (4, 10)
    of_two, of_one = (x.reshape(-1, x.shape[-1]) for x in np.split(epoch.z, [2], 1))
    for seen, held in zip((of_one, of_two), made, strict=True):
        assert sorted(row.tobytes() for row in seen) == sorted(row.tobytes() for row in held.z)
    # Deepest first: the lowest coat is the last of two, the only of one.
    rows = [np.flatnonzero((made[1].z == z).all(-1))[0] for z in of_two]
    np.testing.assert_array_equal(epoch.coats[0][:, :2].reshape(8, 5), made[1].coats[rows, 1])
    np.testing.assert_array_equal(epoch.coats[1].reshape(8, 5), made[1].coats[rows, 0])
    np.testing.assert_array_equal(epoch.top, epoch.coats[1])
    np.testing.assert_array_equal(epoch.below.reshape(8, -1), made[1].below[rows])
    np.testing.assert_array_equal(batches.take(5, 1).z[0], epoch.z[1])


def test_the_loss_starts_at_zero_and_what_is_learnt_lowers_it(tiny, made, wide):
    batch = jax.tree.map(lambda x: x[0], LayeringBatches(made, (32, 8), seed=2).take(0, 1))
    params = {name: jnp.asarray(value) for name, value in wide.items()}
    slope = jax.jit(jax.value_and_grad(layering_loss, has_aux=True), static_argnums=1)
    (_, terms), _ = slope(params, tiny.arch, batch)
    assert float(terms["fit"]) == pytest.approx(0.0, abs=1e-6)
    matrices = {name: x for name, x in params.items() if x.ndim == 2}
    rule = soap(optax.constant_schedule(1e-3))
    state = rule.init(matrices)
    for _ in range(60):
        (_, terms), gradient = slope(params, tiny.arch, batch)
        update, state = rule.update({name: gradient[name] for name in matrices}, state)
        params |= optax.apply_updates({name: params[name] for name in matrices}, update)
    assert float(terms["loss"]) < -1e-3
