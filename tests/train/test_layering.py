"""The layering network's examples, loss and batches."""

import jax.numpy as jnp
import numpy as np
import pytest

from urushi.checks import CoatParameters
from urushi.nets import basis as bases
from urushi.nets import layerer
from urushi.nets import lobe as lobes
from urushi.nets.basis import Basis
from urushi.nets.first_crossing import FirstCrossing
from urushi.train import layering, training


@pytest.fixture(scope="module")
def basis(tiny, store) -> Basis:
    params, _, _ = training.fitted_basis(tiny, store)
    return Basis.of(*(params[f"basis.{name}"] for name in ("rows", "measure", "prior")))


@pytest.fixture(scope="module")
def found(tiny, basis, store):
    return layering.layerings(basis, tiny.arch, store)[0]


def test_examples_are_the_codes_of_the_data(basis, store, found):
    """Of bottoms, each under several coats, and of what is coated."""
    held = store.read(("lobe", "table", "over", "coated"))
    each = held["over"].shape[1]
    assert len(found.code) == each * len(held["lobe"])
    np.testing.assert_array_equal(found.bottom[::each, :6], held["lobe"])
    np.testing.assert_array_equal(found.coat, held["over"].reshape(-1, 5))
    logs = bases.decode_log(found.code[:, None], basis.probe_rows)
    coated = held["coated"].reshape(len(logs), -1)
    assert np.abs(np.exp(logs - coated) - 1).mean() < 0.02


def test_the_error_of_a_code_is_that_of_its_light(basis, found):
    """q is the mean square of relative errors by light: a gain of 1 % is an error of 1 %."""
    step = np.zeros((len(found.code), found.code.shape[1]), np.float32)
    step[:, 0] = 0.01
    size = np.linalg.norm((found.root @ step[..., None])[..., 0], axis=-1)
    f = np.exp(bases.decode_log(found.code[:, None], basis.probe_rows))
    top = lobes.of_coat(found.coat[:, 0], found.coat[:, 1])
    light = f + lobes.f(top[:, None], *basis.pairs())
    share = (f @ basis.measure) / (light @ basis.measure)
    floor = layering.FLOOR * basis.measure.sum()
    np.testing.assert_allclose(size, 0.01 * np.sqrt(share + floor), rtol=1e-3)


@pytest.fixture(scope="module")
def crossing(tiny, basis) -> FirstCrossing:
    return FirstCrossing.of(basis, tiny.arch.crossing)


def test_the_untrained_network_keeps_the_first_crossing(tiny, found, crossing):
    params = layering.fresh(tiny.arch, 0)
    coat = CoatParameters(*found.coat.T)
    z = layerer.layer(params, tiny.arch, found.bottom, coat, crossing)
    np.testing.assert_allclose(z[:, 6:], found.start, atol=1e-5)


def test_the_network_of_jax_is_that_of_numpy(tiny, found, crossing):
    rng = np.random.default_rng(0)
    params = {
        name: 0.3 * rng.standard_normal(x.shape).astype(np.float32)
        for name, x in layering.fresh(tiny.arch, 0).items()
    }
    coat = CoatParameters(*found.coat.T)
    z = layerer.layer(params, tiny.arch, found.bottom, coat, crossing)
    away = (found.root @ (z[:, 6:] - found.code)[..., None])[..., 0]
    moved = layering.Layerings(*map(jnp.asarray, found))
    squares = np.asarray(layering.squares(params, tiny.arch, moved))
    np.testing.assert_allclose(squares, (away * away).sum(axis=-1), rtol=1e-3)


def test_bottoms_without_a_rest_count_as_dark_ones(tiny, found):
    """The gain of no rest would be far outside the range of the network's inputs."""
    bottom = np.repeat(found.bottom[:1], 2, axis=0)
    bottom[:, 6:] = 0
    bottom[:, 6] = bases.EMPTY_GAIN, layerer.LEAST_GAIN
    none, dark = layerer.start(tiny.arch, bottom, CoatParameters(*found.coat[:2].T), None)
    np.testing.assert_array_equal(none, dark)


def test_batches_do_not_depend_on_the_division_into_steps(found):
    whole = layering.batches(found, 16, 0)(0, 8)
    parts = layering.batches(found, 16, 0)
    first, last = parts(0, 3), parts(3, 5)
    np.testing.assert_array_equal(whole.code, np.concatenate([first.code, last.code]))
    assert whole.root.shape[:2] == (8, 16)
