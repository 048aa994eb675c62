"""Packed latent textures."""

import numpy as np
import pytest

from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import stack_error
from urushi.textures import packing
from urushi.textures.store import Texture


@pytest.fixture
def codes(model):
    """Codes (35, 3, size) whose numbers have very different ranges."""
    rng = np.random.default_rng(0)
    count = model.arch.functions
    lobe = rng.uniform([0.05, 0, 0, 0, 1.3, 0], [0.9, 1, 1, 1, 1.9, 4], (35, 3, 6))
    rest = rng.normal(size=(35, 3, count)) * 10.0 ** rng.uniform(-3, -0.5, count)
    return np.concatenate([lobe, rest], axis=-1).astype(np.float32)


def layout_of(channels: int, errors: np.ndarray):
    return packing.texel_layout(channels, errors)


@pytest.mark.parametrize("channels", (1, 2, 3, 5))
@pytest.mark.parametrize("scale", (1e-6, 1e-4, 1e-2))
def test_a_layout_fills_a_power_of_two_with_every_number_once(channels, scale):
    errors = scale * np.random.default_rng(0).random(30)
    layout = layout_of(channels, errors)
    seconds = [byte for byte in layout.low if byte >= 0]
    assert sorted(seconds) == list(range(layout.size, layout.stride))
    assert channels * layout.stride <= layout.texel_bytes
    assert layout.texel_bytes.bit_count() == 1
    # one more byte would not fit into all channels
    assert layout.texel_bytes < channels * (layout.stride + 1) or layout.stride == 2 * layout.size


@pytest.mark.parametrize("scale", (1e-6, 1e-4, 1e-2))
def test_numbers_of_8_bits_change_f_by_less_than_the_limit(scale):
    errors = scale * np.random.default_rng(0).random(30)
    layout = layout_of(3, errors)
    coarse = np.array(layout.low) < 0
    assert np.square(errors[coarse]).sum() <= packing.LIMIT**2
    assert not coarse.any() or errors[coarse].max() <= errors[~coarse].min(initial=np.inf)


def test_packed_codes_give_the_same_f(model, lacquers):
    codes = lacquers(64)
    read = Texture.of(model, codes).codes()
    wi, wo = cosine_pairs(np.random.default_rng(1), 500)
    f, found = (model.networks.f(z[..., None, :], wi, wo) for z in (codes, read))
    assert stack_error(found, f, wi[:, 2], wo[:, 2]).mean() < 1e-3


def test_packing_is_as_fine_as_its_steps(model, codes):
    texture = Texture.of(model, codes)
    error = np.abs(texture.codes() - codes)
    half = 0.5 * texture.packed.step + 1e-3 * np.abs(codes)  # and half precision on the way
    assert (error <= half).all()
    ranges = np.ptp(codes, axis=(0, 1))
    np.testing.assert_allclose(texture.packed.step * texture.layout.levels, ranges, rtol=2e-3)


def test_numbers_that_are_known_take_fewer_bytes(model, codes):
    size, before = model.arch.latent, codes.copy()
    codes[..., : size // 2] = codes[:, :1, : size // 2]
    codes[..., -4:] = [1, 0, 2, -3]
    texture = Texture.of(model, codes)
    layout = texture.layout
    assert layout.constant[-4:].all() and not layout.constant[:-4].any()
    general = Texture.of(model, before).layout
    smaller = layout.texel_bytes < general.texel_bytes
    assert smaller or layout.levels.sum() > general.levels.sum()
    read = texture.codes()
    np.testing.assert_allclose(read[..., -4:], codes[..., -4:])
    assert (np.abs(read - codes) <= 0.5 * texture.packed.step + 1e-3 * np.abs(codes)).all()
