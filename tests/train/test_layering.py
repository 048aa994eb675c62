"""The layering stage: widening keeps the layerer's values, batches are complete, and it learns."""

import dataclasses

import jax
import numpy as np
import pytest

from urushi.errors import ParameterError
from urushi.nets.architecture import init
from urushi.nets.layerer import layer
from urushi.nets.lobe import of_coat
from urushi.train import examples
from urushi.train.optimiser import compile_steps, start
from urushi.train.stages import layering
from urushi.train.stages.layering import layering_batches, layering_loss, widened
from urushi.train.store import Store


@pytest.fixture(scope="module")
def narrow(tiny):
    return init(tiny.architectures()[0], 3)


@pytest.fixture(scope="module")
def measured(tiny, tiny_data, narrow):
    depths = examples.load(Store(tiny_data, tiny.data), tiny.arch, tiny.pairs)
    return [
        layering.measure_quadratic_losses(narrow, tiny.architectures()[0], depth.examples())
        for depth in depths[1:]
    ]


@pytest.fixture(scope="module")
def wide(tiny, narrow):
    return widened(narrow, tiny.architectures()[0], "layerer", tiny.arch.layerer, seed=1)


def test_widening_keeps_the_values(tiny, narrow, wide):
    rng = np.random.default_rng(0)
    z = rng.standard_normal((50, tiny.arch.latent)).astype(np.float32)
    z[:, : tiny.arch.lobe] = of_coat(np.float32(0.3), np.float32(1.5))
    coats = rng.uniform([0.01, 0.5, 0, 0, -0.8], [1, 3, 1, 8, 0.9], (50, 5)).astype(np.float32).T
    before = layer(narrow, tiny.architectures()[0], z, tuple(coats))
    np.testing.assert_allclose(layer(wide, tiny.arch, z, tuple(coats)), before, atol=1e-6)
    assert (
        wide["layerer.0.weight"].shape[1]
        == tiny.arch.layerer[0]
        > tiny.architectures()[0].layerer[0]
    )


@pytest.mark.parametrize("widths", [(15,), (16, 16), ()])
def test_narrower_layers_or_another_number_of_them_are_refused(tiny, narrow, widths):
    with pytest.raises(ParameterError, match="cannot be widened"):
        widened(narrow, tiny.architectures()[0], "layerer", widths, seed=1)


def test_every_stack_of_a_depth_comes_once_an_epoch(measured):
    # 32 stacks of one coat, 8 in a step; 8 of two coats, 2 in a step: four steps are an epoch.
    take = layering_batches(measured, (8, 2), seed=2)
    epoch = take(4, 4)
    assert epoch.z.shape[:2] == (4, 10)
    of_two, of_one = (x.reshape(-1, x.shape[-1]) for x in np.split(epoch.z, [2], 1))
    for drawn, losses in zip((of_one, of_two), measured, strict=True):
        assert sorted(row.tobytes() for row in drawn) == sorted(row.tobytes() for row in losses.z)
    # Deepest first: the lowest coat is the last of two coats, or the only one.
    rows = [np.flatnonzero((measured[1].z == z).all(-1))[0] for z in of_two]
    np.testing.assert_array_equal(epoch.coats[0][:, :2].reshape(8, 5), measured[1].coats[rows, 1])
    np.testing.assert_array_equal(epoch.coats[1].reshape(8, 5), measured[1].coats[rows, 0])
    np.testing.assert_array_equal(epoch.below[:, :2].reshape(8, -1), measured[1].below[rows])
    np.testing.assert_array_equal(take(5, 1).z[0], epoch.z[1])


def test_the_loss_starts_at_zero_and_training_lowers_it(tiny, measured, wide):
    schedule = dataclasses.replace(tiny.stages[1].schedule, steps=64, learning_rate=2e-3)

    def loss(params, batch):
        return layering_loss(params, tiny.arch, batch)

    batch = layering_batches(measured, (32, 8), seed=2)(0, 1)
    first = jax.tree.map(lambda x: x[0], batch)
    _, terms = jax.jit(layering_loss, static_argnums=1)(wide, tiny.arch, first)
    assert float(terms["fit"]) == pytest.approx(0.0, abs=1e-6)

    batches = jax.tree.map(lambda x: np.repeat(x, 4, axis=0), batch)
    run, state = compile_steps(loss, schedule), start(wide, schedule)
    for _ in range(0, schedule.steps, 4):
        state, terms = run(state, batches)
    assert float(terms["loss"]) < -1e-3
