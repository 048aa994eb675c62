"""Principal numbers of a texture give the f of its codes, by fewer functions."""

import numpy as np
import pytest

from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import stack_error
from urushi.textures import packing
from urushi.textures.principal import principal_texture
from urushi.textures.store import TextureStore


def stored(model, codes) -> TextureStore:
    store = TextureStore(model, codes.shape[1], len(codes))
    store.write(slice(None), codes)
    return store


@pytest.fixture(scope="module")
def store(model, lacquers) -> TextureStore:
    return stored(model, lacquers(256))


def test_they_give_the_f_of_the_codes(model, store):
    principal = principal_texture(model, store)
    assert principal.functions.shape[1] < model.arch.functions
    assert principal.layout.texel_bytes < store.layout.texel_bytes
    codes = store.read(slice(None))
    found = principal.codes(packing.unpack(principal.layout, principal.packed))
    wi, wo = cosine_pairs(np.random.default_rng(1), 500)
    f, ours = (model.networks.f(z[..., None, :], wi, wo) for z in (codes, found))
    error = stack_error(ours, f, wi[:, 2], wo[:, 2])
    assert error.mean() < 2e-3
    assert error.max() < 1e-2


def test_their_functions_give_the_logarithm_of_their_codes(model, store):
    principal = principal_texture(model, store)
    numbers = packing.unpack(principal.layout, principal.packed)[:8, 0]
    rest = principal.codes(numbers)[:, model.arch.lobe :]
    rows = model.networks.basis.rows[::97].astype(np.float64)
    mean, functions = principal.functions[::97, :1], principal.functions[::97, 1:]
    gain, others = numbers[:, principal.first], numbers[:, principal.first + 1 :]
    found = mean + gain + functions @ others.T
    # single precision of numbers that are far larger than their sums
    np.testing.assert_allclose(found, rows[:, :1] + rows[:, 1:] @ rest.T, atol=2e-3)
    assert np.abs(functions).max() <= 1


def test_a_brighter_texture_has_the_same_components(model, lacquers):
    codes = lacquers(64)
    brighter = codes.copy()
    model.networks.gains(brighter)[...] += 1
    first, second = (principal_texture(model, stored(model, z)) for z in (codes, brighter))
    numbers, other = (packing.unpack(x.layout, x.packed) for x in (first, second))
    gains = other[..., first.first] - numbers[..., first.first]
    np.testing.assert_allclose(gains, 1, atol=0.01)  # codes are written in half precision


def test_a_texture_of_unlike_materials_keeps_its_codes(model):
    codes = np.zeros((256, 3, model.arch.latent), np.float32)
    codes[..., :6] = 0.3, 0, 0, 1, 1.5, 0
    codes[..., 6:] = np.random.default_rng(0).normal(size=(256, 3, model.arch.functions))
    assert principal_texture(model, stored(model, codes)) is None


def test_rare_texels_are_represented_too(model, lacquers):
    """One texel of a thousand is unlike all others."""
    codes = np.repeat(lacquers(1), 1000, axis=0)
    codes[123] = lacquers(7)[5]
    store = stored(model, codes)
    principal = principal_texture(model, store)
    part = principal.packed._replace(bytes=principal.packed.bytes[123:124])
    found = principal.codes(packing.unpack(principal.layout, part))
    wi, wo = cosine_pairs(np.random.default_rng(1), 500)
    f, ours = (model.networks.f(z[..., None, :], wi, wo) for z in (store.read([123]), found))
    assert stack_error(ours, f, wi[:, 2], wo[:, 2]).max() < 1e-2


def test_a_texture_of_one_material_and_of_none(model, lacquers):
    """Nothing varies, and the numbers of codes may be zero."""
    bare = lacquers(1)
    bare[..., model.arch.lobe :] = model.networks.empty_rest()
    for codes in (lacquers(1), bare):
        store = stored(model, np.repeat(codes, 8, axis=0))
        principal = principal_texture(model, store)
        found = principal.codes(packing.unpack(principal.layout, principal.packed))
        np.testing.assert_allclose(found, store.read(slice(None)), atol=2e-3)
        assert np.isfinite(principal.functions).all()
