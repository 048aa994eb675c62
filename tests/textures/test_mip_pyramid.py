"""Mip levels represent averages of BRDFs, after a change too."""

import numpy as np
import pytest

from urushi.checks import CoatParameters
from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import stack_error
from urushi.material import energy
from urushi.material.albedo_rule import albedo_rule
from urushi.material.values import codes_of
from urushi.material.energy import limit_albedo
from urushi.material.layer import layer_texels
from urushi.textures import mip_pyramid, packing
from urushi.textures.mip_pyramid import coarse_levels, level_sizes
from urushi.textures.store import TextureStore


def coats(model, height: int, width: int) -> np.ndarray:
    """Codes (height, width, 3, size) of coats that differ in everything from texel to texel."""
    rng = np.random.default_rng(0)
    bottom = limit_albedo(model, codes_of(model, np.full((1, len(model.networks.pairs()[0])), 0.2)))
    shape = height, width, 3
    return layer_texels(
        model,
        bottom,
        CoatParameters(
            alpha=rng.uniform(0.05, 0.4, shape),
            eta=1.5,
            albedo=rng.random(shape),
            sigma_t=2 * rng.random(shape),
            g=0.0,
        ),
    )


def pyramid_levels(model, codes: np.ndarray) -> list[np.ndarray]:
    """All levels of codes (H, W, C, size), the first included."""
    height, width, channels, size = codes.shape
    sizes = level_sizes(width, height)
    first = codes.reshape(-1, channels, size)
    whole = np.concatenate([first, coarse_levels(model, width, height, first.__getitem__)])
    ends = np.cumsum([w * h for w, h in sizes])[:-1]
    parts = np.split(whole, ends)
    return [p.reshape(h, w, channels, size) for p, (w, h) in zip(parts, sizes, strict=True)]


def values(model, codes: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    return model.networks.f(codes[..., None, :], wi, wo)


def tops(model, codes: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """The part of `values` of the codes' lobes."""
    return model.networks.top(codes[..., None, :], wi, wo)


def test_levels_are_the_averages_of_brdfs(trained, monkeypatch):
    monkeypatch.setattr(mip_pyramid, "BAND_TEXELS", 64)  # so that a level has several bands
    codes = coats(trained, 16, 16)
    wi, wo = cosine_pairs(np.random.default_rng(1), 100)
    f, top, plain = values(trained, codes, wi, wo), tops(trained, codes, wi, wo), codes
    for level in pyramid_levels(trained, codes)[1:]:
        f, top, plain = (mip_pyramid.half_resolution(x, 0, len(x)) for x in (f, top, plain))
        whole = values(trained, level, wi, wo)
        of_rest = whole - tops(trained, level, wi, wo) + top
        rest, found, naive = (
            stack_error(x, f, wi[:, 2], wo[:, 2]).mean()
            for x in (of_rest, whole, values(trained, plain, wi, wo))
        )
        # The networks were not trained for averages of different rests.
        assert rest < 0.02
        # One lobe stands for up to 256 with widths from 0.05 to 0.4, at a quarter of the light.
        assert found < 0.06
        assert found < 0.3 * naive


def test_every_level_keeps_the_light(trained):
    """Under light from all sides."""
    codes = coats(trained, 8, 8)
    cosines = albedo_rule().cosines
    weights = np.abs(np.gradient(cosines)) * cosines

    def light(z):
        return energy.directional_albedos(trained, z.reshape(-1, z.shape[-1])) @ (
            weights / weights.sum()
        )

    whole = light(codes).reshape(64, 3).mean(axis=0)
    # Averages of different lobes are unlike the training data: E is about a percent.
    np.testing.assert_allclose(light(pyramid_levels(trained, codes)[-1]), whole, rtol=0.01)
    assert (
        light(codes.mean(axis=(0, 1))) < 0.97 * whole
    ).all()  # plain averages of codes lose more light


@pytest.mark.parametrize("side", (4, 64))
def test_levels_of_a_constant_texture_are_constant(trained, side):
    bottom = limit_albedo(
        trained, codes_of(trained, np.full((1, len(trained.networks.pairs()[0])), 0.2))
    )
    whole = pyramid_levels(trained, np.broadcast_to(bottom, (side, side, *bottom.shape)))
    for level in whole[1:]:
        np.testing.assert_allclose(level, whole[0][: len(level), : len(level)], atol=1e-4)


@pytest.mark.parametrize(("width", "height"), [(37, 29), (16, 64), (1, 9), (1, 1)])
def test_plain_averages_go_through_the_same_bands(model, monkeypatch, width, height):
    """They must be those of whole levels, also of odd sizes."""
    monkeypatch.setattr(mip_pyramid, "BAND_TEXELS", 20)
    for name in ("lifted", "dropped"):
        monkeypatch.setattr(mip_pyramid, name, lambda model, numbers: numbers)
    level = np.random.default_rng(0).normal(size=(height, width, 2, model.arch.latent))
    for found in pyramid_levels(model, level.astype(np.float32)):
        np.testing.assert_allclose(found, level, atol=1e-5)
        level = mip_pyramid.half_resolution(level, 0, len(level))


def test_a_store_has_levels_within_what_it_can_store(trained):
    """Encoded averages may lie outside of what the first level's codes span."""
    codes = (
        coats(trained, 8, 8).astype(np.float16).astype(np.float32)
    )  # the precision in which codes are written
    store = TextureStore(trained, 3, 8, 8, mipmaps=True)
    store.write(slice(None), codes.reshape(64, 3, -1))
    expected = np.concatenate(
        [z.reshape(-1, 3, z.shape[-1]) for z in pyramid_levels(trained, codes)]
    )
    error = np.abs(store.read(slice(None)) - expected)
    assert (error <= 0.6 * store.packed.step + 1e-3).all()
    # an edit that widens all ranges
    store.write(np.arange(2), 1.5 * codes[0, :2])
    codes[0, :2] *= 1.5
    expected = np.concatenate(
        [z.reshape(-1, 3, z.shape[-1]) for z in pyramid_levels(trained, codes)]
    )
    # Averages are rounded twice, and the averaged codes were rounded before.
    error = np.abs(store.read(slice(None)) - expected)
    assert (error <= 2 * store.packed.step + 0.05).all()
