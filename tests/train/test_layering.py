"""The layering network's examples, loss and batches."""

import dataclasses

import numpy as np
import pytest

from urushi.checks import CoatParameters
from urushi.nets import basis as bases
from urushi.nets import layerer
from urushi.nets import lobe as lobes
from urushi.nets.transmittance import both_ways
from urushi.nets.weights import Model, anisotropic_model, default_model
from urushi.train import layering, training
from urushi.train.distribution import draw_coats_of_two


@pytest.fixture(scope="module")
def model(tiny, store) -> Model:
    return training.fitted_basis(tiny, store)[0]


@pytest.fixture(scope="module")
def found(model, store):
    return training.layerings(model, store)[0]


@pytest.fixture(scope="module")
def brushed() -> layering.Layerings:
    """Examples of two widths: lobes of metals, random codes as their coated materials."""
    model, rng = anisotropic_model(), np.random.default_rng(0)
    lobe = np.tile(np.float32([0.1, 0.9, 1, 0, 1.5, 0, 0.3]), (2, 1))
    bottom = np.concatenate([lobe, 0.3 * rng.standard_normal((2, model.arch.rest))], axis=1)
    coats = draw_coats_of_two(rng, 8).reshape(2, 4, 6)
    logs = 0.5 * rng.standard_normal((2, 4, model.arch.probes)).astype(np.float32)
    return layering.examples(model.networks.basis, bottom.astype(np.float32), coats, logs)


def test_examples_are_the_codes_of_the_data(model, store, found):
    """Of bottoms, each under several coats, and of what is coated."""
    held = store.read(("lobe", "table", "over", "coated"))
    each = held["over"].shape[1]
    assert len(found.code) == each * len(held["lobe"])
    np.testing.assert_array_equal(found.bottom[::each, :6], held["lobe"])
    np.testing.assert_array_equal(found.coat, held["over"].reshape(-1, 5))
    logs = bases.decode_log(found.code[:, None], model.networks.basis.probe_rows(0.0))
    coated = held["coated"].reshape(len(logs), -1)
    assert np.abs(np.exp(logs - coated) - 1).mean() < 0.02


def test_the_error_of_a_code_is_that_of_its_light(model, found):
    """q is the mean square of relative errors by light: a gain of 1 % is an error of 1 %."""
    size = 0.01 * np.linalg.norm(found.root[..., 0], axis=-1)
    basis = model.networks.basis
    f = np.exp(bases.decode_log(found.code[:, None], basis.probe_rows(0.0)))
    top = lobes.of_coat(found.coat[:, 0], found.coat[:, 1])
    passed = both_ways(top[:, None], *basis.pairs())
    light = passed * f + lobes.f(top[:, None], *basis.pairs())
    share = ((passed * f) @ basis.measure) / (light @ basis.measure)
    floor = layering.FLOOR * (passed @ basis.measure)
    np.testing.assert_allclose(size, 0.01 * np.sqrt(share + floor), rtol=1e-3)


def test_the_untrained_network_keeps_codes(tiny, found):
    params = layering.fresh(tiny.arch, 0)
    z = layerer.layer(params, tiny.arch, found.bottom, CoatParameters(*found.coat.T))
    np.testing.assert_allclose(z[:, 6:], found.bottom[:, 6:], atol=1e-6)


def test_bottoms_of_rests_too_faint_to_see_count_as_without(tiny, found):
    """The gain of no rest is far outside the range of the network's inputs, and numbers of rests at
    the level of rounding errors are arbitrary."""
    params = layering.fresh(tiny.arch, 0)
    rng = np.random.default_rng(3)
    params |= {n: rng.standard_normal(x.shape).astype(np.float32) for n, x in params.items()}
    bottoms = np.tile(found.bottom[:1], (3, 1))
    bottoms[:, 6:] = 0
    bottoms[:, 6] = bases.EMPTY_GAIN, layerer.LEAST_GAIN, layerer.LEAST_GAIN - 1
    bottoms[2, 7:] = rng.uniform(-90, 90, bottoms.shape[1] - 7)
    z = layerer.layer(params, tiny.arch, bottoms, CoatParameters(*found.coat[:1].T))
    np.testing.assert_array_equal(z[1:], z[[0, 0]])


def test_a_network_of_two_widths_begins_as_that_of_one(brushed):
    """For equal widths and functions without a factor."""
    own = default_model()
    two = dataclasses.replace(anisotropic_model().arch, layerer=own.arch.layerer)
    params = layering.widened(own, two)
    bottom = brushed.bottom.copy()
    bottom[:, 6] = bottom[:, 0]
    bottom[:, 7 + own.arch.rest :] = 0
    coat = brushed.coat.copy()
    coat[:, 5] = coat[:, 0]
    z = layerer.layer(params, two, bottom, CoatParameters.of_columns(coat.T))
    below = np.delete(bottom, 6, axis=1)[:, : own.arch.latent]
    expected = own.networks.layer(below, CoatParameters(*coat[:, :5].T))
    np.testing.assert_allclose(z[:, 7 : 7 + own.arch.rest], expected[:, 6:], atol=2e-3)
    assert not z[:, 7 + own.arch.rest :].any()


def test_mirror_images_are_examples_of_the_same_error(brushed):
    """x and y exchanged: f is that of the exchanged directions, and an error counts as before."""
    model = anisotropic_model()
    images = layering.mirrored(brushed, model.arch.factors[1:])
    again = layering.mirrored(images, model.arch.factors[1:])
    for a, b in zip(brushed, again, strict=True):
        np.testing.assert_array_equal(a, b)
    wi, wo = model.networks.pairs()
    turned = wi[:, [1, 0, 2]], wo[:, [1, 0, 2]]
    for row in range(0, len(brushed.code), 3):
        f = model.networks.f(brushed.bottom[row][None], wi, wo)
        image = model.networks.f(images.bottom[row][None], *turned)
        np.testing.assert_allclose(image, f, rtol=1e-3)
    error = np.random.default_rng(1).standard_normal(brushed.code.shape)
    changed = layering.mirrored(brushed._replace(code=error), model.arch.factors[1:]).code
    sizes = [
        np.linalg.norm((x.root @ d[..., None])[..., 0], axis=1)
        for x, d in ((brushed, error), (images, changed))
    ]
    np.testing.assert_allclose(sizes[0], sizes[1], rtol=1e-4)


def test_a_change_of_the_stretch_counts_by_the_change_of_f(brushed):
    """q of a small change of ln s is about the light-weighted square of the change of ln f."""
    basis = anisotropic_model().networks.basis
    code, root, coat = (x[0] for x in (brushed.code, brushed.root, brushed.coat))
    step = 1 / 64
    ends = [basis.probe_rows(code[-1] + way * step)[:, 1:] @ code[:-1] for way in (-1, 1)]
    middle = np.exp(basis.probe_rows(code[-1])[:, 1:] @ code[:-1])
    top = lobes.f(lobes.of_coat(*CoatParameters.of_columns(coat)[:2]), *basis.pairs())
    weights = basis.measure * (middle / ((middle + top) @ basis.measure) + layering.FLOOR)
    expected = weights @ np.square((ends[1] - ends[0]) / (2 * step))
    assert np.square(root[:, -1]).sum() == pytest.approx(expected, rel=0.2)


def test_every_example_comes_once_an_epoch_shuffled_as_a_whole():
    """The order is a function of seed and place."""
    size = 2413
    first, second = (layering.shuffled(size, 0, epoch * size, size) for epoch in (0, 1))
    for items in (first, second):
        assert sorted(items) == list(range(size))
        # The mean of the first half of the sequence is that of a sample of 1,206 of 2,413.
        assert abs(items[:1206].mean() - items.mean()) < 4 * items.std() / np.sqrt(2 * 1206)
    assert (first != second).any()
    whole = np.concatenate([first, second])
    for start, count in ((0, 5), (1200, 3000), (2412, 2), (4000, 800)):
        found = layering.shuffled(size, 0, start, count)
        np.testing.assert_array_equal(found, whole[start : start + count])
    assert (layering.shuffled(size, 1, 0, 100) != whole[:100]).any()
