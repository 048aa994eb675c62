"""Many texels: the same codes as one by one, for any broadcasting and any number of cores."""

import tracemalloc

import numpy as np
import pytest

from urushi import parallel
from urushi.checks import CoatParameters
from urushi.core.probe_pairs import probe_pairs
from urushi.material import energy
from urushi.material.albedo_rule import INTERPOLATED_COSINES
from urushi.material.energy import limit_albedo
from urushi.material.layer import layer_texels
from urushi.material.values import codes_of
from urushi.nets import lobe, lobe_fit
from urushi.nets.layerer import layer
from urushi.nets.weights import Model

#: Probe pairs of untrained models, and numbers of a code.
PROBES, L = 96, 14

H, W = 60, 70  # three channels of these are several blocks

#: Sums of some hundred terms of size about 1 in float32, in another order.
ROUNDING = dict(atol=3e-5, rtol=0)

COATS = {
    "scalars": ((), (), (), (), ()),
    "grey": ((H, W, 1), (), (H, W, 1), (H, W, 1), (1, 1, 1)),
    "mixed": ((H, W, 1), (), (3,), (H, W, 3), (W, 1)),
    "rgb": ((H, W, 3),) * 5,
}

#: Every shape of a bottom's codes, each with one of the coats.
PAIRS = (
    ((), "grey"), ((3,), "mixed"), ((1, 1, 1), "rgb"), ((W, 1), "scalars"),
    ((H, 1, 3), "mixed"), ((H, W, 1), "grey"), ((H, W, 3), "rgb"),
)  # fmt: skip


@pytest.fixture(scope="module")
def model(model) -> Model:
    """A basis of so low an albedo that nothing is scaled: rows are as the networks give them."""
    rows = model.params["basis.rows"].copy()
    rows[:, 0] -= 15
    return Model.of(model.arch, dict(model.params) | {"basis.rows": rows}, {})


def _coat(shapes):
    rng = np.random.default_rng(1)
    low, high = [0.01, 1.05, 0, 0, -0.8], [1, 2, 1, 8, 0.9]
    values = [rng.uniform(*bounds, shape) for *bounds, shape in zip(low, high, shapes, strict=True)]
    return dict(zip(("alpha", "eta", "albedo", "sigma_t", "g"), values, strict=True))


def _plainly(model, z, coat):
    """All rows in one pass of the layering network."""
    columns = np.broadcast_arrays(*coat.values())
    shape = np.broadcast_shapes(z.shape[:-1], columns[0].shape)
    rows = [np.broadcast_to(c, shape).astype(np.float32).ravel() for c in columns]
    z = np.broadcast_to(z, (*shape, z.shape[-1])).reshape(-1, z.shape[-1])
    return layer(model.params, model.arch, z, tuple(rows)).reshape(*shape, z.shape[-1])


def glossy(rng, shape) -> np.ndarray:
    """Values float32 (*shape, PROBES) of a lobe over a diffuse surface."""
    alpha, reflectance = rng.uniform(0.1, 0.8, (*shape, 1)), rng.uniform(0.1, 0.6, (*shape, 1))
    f = lobe.shape(alpha, *probe_pairs(PROBES)) * rng.uniform(0.1, 0.3, (*shape, 1))
    return (f + reflectance / np.pi).astype(np.float32)


@pytest.mark.parametrize(("bottom", "name"), PAIRS)
def test_broadcast_inputs_are_layered_like_plain_rows(bottom, name, model, draw_codes):
    z = draw_codes(bottom, np.random.default_rng(2))
    coat = _coat(COATS[name])
    coated = layer_texels(model, z, CoatParameters(**coat))
    expected = _plainly(model, z, coat)
    assert coated.shape == expected.shape and coated.dtype == np.float32
    np.testing.assert_allclose(coated, expected, **ROUNDING)


def test_bits_do_not_depend_on_the_number_of_cores(model, draw_codes, monkeypatch):
    rng = np.random.default_rng(3)
    z, f = draw_codes((H, W, 3), rng), glossy(rng, (H, W))
    results = []
    for count in (1, 2, 5):
        monkeypatch.setattr(parallel, "available_cores", lambda count=count: count)
        results.append(
            (
                layer_texels(model, z, CoatParameters(**_coat(COATS["rgb"]))),
                limit_albedo(model, codes_of(model, f)),
            )
        )
    for coated, codes in results[1:]:
        np.testing.assert_array_equal(coated, results[0][0])
        np.testing.assert_array_equal(codes, results[0][1])


def test_texels_are_encoded_like_plain_rows(model):
    f = np.moveaxis(glossy(np.random.default_rng(4), (H, W)), -1, 1).copy()
    values = np.moveaxis(f, 1, -1)  # as a renderer gives them, not contiguous
    codes = limit_albedo(model, codes_of(model, values))
    assert codes.shape == (H, W, L) and codes.dtype == np.float32
    expected = model.networks.encode(values.reshape(-1, PROBES))
    np.testing.assert_allclose(codes.reshape(-1, L), expected, **ROUNDING)


@pytest.mark.parametrize("operation", ["layer", "layer one bottom", "encode"])
def test_memory_is_the_result_and_some_blocks(operation, model, draw_codes, monkeypatch):
    # 98,304 rows. Beyond the result there are the parameters (five numbers a row at most, in two
    # precisions, and their checks) and on each of two cores a few activations of a block. The fit
    # of lobes has a few values at each pair and width of its grid; the energy limit measures the
    # lobes of a block by rules of six nodes at 41 angles, with some ten numbers at each.
    monkeypatch.setattr(parallel, "available_cores", lambda: 2)
    side = 256, 128, 3
    rng = np.random.default_rng(5)
    coat = dict(alpha=0.1, eta=1.5, albedo=rng.random(side), sigma_t=rng.random(side), g=0)
    z = draw_codes(side, rng)
    f = rng.random((20_000, PROBES), np.float32)
    run = {
        "layer": lambda: layer_texels(model, z, CoatParameters(**coat)),
        "layer one bottom": lambda: layer_texels(model, z[0, 0], CoatParameters(**coat)),
        "encode": lambda: limit_albedo(model, codes_of(model, f)),
    }[operation]
    parallel._blas()
    tracemalloc.start()
    size = run().nbytes
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    block = parallel.ROWS * 256 * 4
    parameters = 2 * 98_304 * (8 + 8 + 4)
    fit = lobe_fit.BLOCK * PROBES * len(lobe_fit.GRID) * 8 if operation == "encode" else 0
    lobes = energy.BLOCK * 2 * INTERPOLATED_COSINES * 6 * 10 * 8
    assert peak < size + parameters + 2 * 6 * (block + fit) + lobes


def test_one_texel_and_none(model):
    z = np.ones(L, np.float32)
    coat = dict(alpha=0.1, eta=1.5, albedo=0.5, sigma_t=1, g=0)
    alone = layer_texels(model, z, CoatParameters(**coat))
    assert alone.shape == (L,)
    np.testing.assert_allclose(
        layer_texels(model, z[None, None], CoatParameters(**coat))[0, 0], alone, **ROUNDING
    )
    assert layer_texels(model, np.ones((0, 3, L)), CoatParameters(**coat)).shape == (0, 3, L)
    assert limit_albedo(model, codes_of(model, np.ones((0, 3, PROBES)))).shape == (0, 3, L)
    assert limit_albedo(model, codes_of(model, np.ones(PROBES))).shape == (L,)
