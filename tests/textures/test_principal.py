"""Principal numbers give the f of codes, by fewer functions."""

import numpy as np
import pytest

from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import stack_error
from urushi.textures.principal import projection_of


def projected(model, codes: np.ndarray):
    """Functions, projection and principal numbers (T, C, 1 + N) of codes (T, C, L)."""
    tops, rests = np.split(codes, [model.arch.lobe], axis=-1)
    functions, projection = projection_of(model, np.moveaxis(tops, 1, 0), np.moveaxis(rests, 1, 0))
    return functions, projection, projection.numbers(rests)


def errors(model, codes: np.ndarray) -> np.ndarray:
    """E of f by the principal numbers of codes (T, C, L)."""
    _, projection, numbers = projected(model, codes)
    found = np.concatenate([codes[..., : model.arch.lobe], projection.rests(numbers)], axis=-1)
    wi, wo = cosine_pairs(np.random.default_rng(1), 500)
    f, ours = (model.networks.f(z[..., None, :], wi, wo) for z in (codes, found))
    return stack_error(ours, f, wi[:, 2], wo[:, 2])


def test_they_give_the_f_of_the_codes(model, lacquers):
    codes = lacquers(256)
    assert projected(model, codes)[0].shape[1] < model.arch.functions
    found = errors(model, codes)
    assert found.mean() < 2e-3
    assert found.max() < 1e-2


def test_unlike_materials_keep_their_codes(model):
    codes = np.zeros((256, 3, model.arch.latent), np.float32)
    codes[..., :6] = 0.3, 0, 0, 1, 1.5, 0
    codes[..., 6:] = np.random.default_rng(0).normal(size=(256, 3, model.arch.functions))
    assert projected(model, codes)[2].shape[-1] == model.arch.functions
    assert errors(model, codes).max() < 1e-4


def test_rare_codes_are_represented_too(model, lacquers):
    """One code of a thousand is unlike all others."""
    codes = np.repeat(lacquers(1), 1000, axis=0)
    codes[123] = lacquers(7)[5]
    assert errors(model, codes).max() < 1e-2


@pytest.mark.parametrize("bare", [False, True])
def test_one_material(model, lacquers, bare):
    """Nothing varies, and the numbers of codes may be zero."""
    codes = np.repeat(lacquers(1), 8, axis=0)
    if bare:
        codes[..., model.arch.lobe :] = model.networks.empty_rest()
    functions, projection, numbers = projected(model, codes)
    np.testing.assert_allclose(projection.rests(numbers), codes[..., model.arch.lobe :], atol=2e-3)
    assert np.isfinite(functions).all()
