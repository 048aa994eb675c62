"""Many texels: the same codes as one by one, for any broadcasting and any number of cores."""

import tracemalloc

import numpy as np
import pytest
from tests.material.conftest import with_gain

from urushi import parallel
from urushi.checks import CoatParameters
from urushi.core.probe_pairs import probe_pairs
from urushi.material import energy
from urushi.material.albedo_rule import albedo_rule
from urushi.material.energy import limit_albedo
from urushi.material.layer import layer_material, predicted
from urushi.material.material import Material
from urushi.nets import lobe, lobe_fit
from urushi.nets.layerer import layer
from urushi.nets.weights import Model

#: Probe pairs of untrained models, and numbers of a code.
PROBES, L = 96, 14

H, W = 60, 70  # three channels of these are several blocks

#: Sums of some hundred terms of size about 1 in float32, in another order.
ROUNDING = dict(atol=3e-5, rtol=0)


@pytest.fixture(scope="module")
def model(model) -> Model:
    """A basis of so low an albedo that nothing is scaled: rows are as the networks give them."""
    return with_gain(model, -15)


def _coats(count: int) -> CoatParameters:
    rng = np.random.default_rng(1)
    low, high = [0.01, 1.05, 0, 0, -0.8], [1, 2, 1, 8, 0.9]
    return CoatParameters(*(rng.uniform(*bounds, count) for bounds in zip(low, high, strict=True)))


def glossy(rng, shape) -> np.ndarray:
    """Values float32 (*shape, PROBES) of a lobe over a diffuse surface."""
    alpha, reflectance = rng.uniform(0.1, 0.8, (*shape, 1)), rng.uniform(0.1, 0.6, (*shape, 1))
    f = lobe.shape(alpha, *probe_pairs(PROBES)) * rng.uniform(0.1, 0.3, (*shape, 1))
    return (f + reflectance / np.pi).astype(np.float32)


@pytest.mark.parametrize("count", [1, H * W])
def test_rows_are_layered_as_in_one_pass_of_the_network(count, model, draw_codes):
    z, coats = draw_codes((count,), np.random.default_rng(2)), _coats(H * W)
    coated = layer_material(coats, Material(z, model), fast=True).latents
    columns = (x.astype(np.float32) for x in coats)
    expected = layer(model.params, model.arch, z, tuple(columns))
    np.testing.assert_allclose(coated, expected, **ROUNDING)


def test_bits_do_not_depend_on_the_number_of_cores(model, draw_codes, monkeypatch):
    rng = np.random.default_rng(3)
    below, f = Material(draw_codes((H * W,), rng), model), glossy(rng, (H, W))
    coated, codes = [], []
    for count in (1, 2, 5):
        monkeypatch.setattr(parallel, "available_cores", lambda count=count: count)
        coated.append(layer_material(_coats(H * W), below, fast=True).latents)
        codes.append(limit_albedo(model, model.networks.encode(f)))
    for first, *others in (coated, codes):
        assert all(np.array_equal(x, first) for x in others)


def test_texels_are_encoded_like_plain_rows(model):
    f = np.moveaxis(glossy(np.random.default_rng(4), (H, W)), -1, 1).copy()
    values = np.moveaxis(f, 1, -1)  # as a renderer gives them, not contiguous
    codes = limit_albedo(model, model.networks.encode(values))
    assert codes.shape == (H, W, L) and codes.dtype == np.float32
    expected = model.networks.encode(values.reshape(-1, PROBES))
    np.testing.assert_allclose(codes.reshape(-1, L), expected, **ROUNDING)
    for shape in ((0, 3), ()):  # none, and one
        f = np.ones((*shape, PROBES))
        assert limit_albedo(model, model.networks.encode(f)).shape == (*shape, L)


@pytest.mark.parametrize("operation", ["layer", "encode"])
def test_memory_is_the_result_and_some_blocks(operation, model, draw_codes, monkeypatch):
    # 32,768 rows. Beyond the result there are the parameters (five numbers a row at most, in two
    # precisions, and their checks) and on each of two cores a few activations of a block. The fit
    # of lobes has a few values at each pair and width of its grid. The energy limit measures lobes
    # of a block at many facets in each direction, with some ten numbers at each.
    monkeypatch.setattr(parallel, "available_cores", lambda: 2)
    count, rng = 32_768, np.random.default_rng(5)
    z, coats = draw_codes((count,), rng), _coats(count)
    f = rng.random((3_000, PROBES), np.float32)
    run = {
        "layer": lambda: limit_albedo(model, predicted(model, z, coats)),
        "encode": lambda: limit_albedo(model, model.networks.encode(f)),
    }[operation]
    parallel._blas()
    tracemalloc.start()
    size = run().nbytes
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    block = parallel.ROWS * 256 * 4
    parameters = 5 * count * (8 + 4)
    fit = lobe_fit.BLOCK * PROBES * len(lobe_fit.GRID) * 8 if operation == "encode" else 0
    lobes = energy.LOBES * 2 * len(albedo_rule().directions) * energy.FACETS * 10 * 8
    assert peak < size + parameters + 2 * 6 * (block + fit) + lobes
