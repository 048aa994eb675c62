"""Mip levels represent averages of BRDFs, after a change too."""

import numpy as np
import pytest

from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import stack_error
from urushi.material import energy
from urushi.material.albedo_rule import albedo_rule
from urushi.textures import mip_pyramid
from urushi.textures.mip_pyramid import coarse_levels, level_sizes
from urushi.textures.store import TextureStore


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


def test_levels_are_the_averages_of_brdfs(model, lacquers, monkeypatch):
    monkeypatch.setattr(mip_pyramid, "BAND_TEXELS", 64)  # so that a level has several bands
    codes = lacquers(256).reshape(16, 16, 3, -1)
    wi, wo = cosine_pairs(np.random.default_rng(1), 100)
    f, top, plain = values(model, codes, wi, wo), tops(model, codes, wi, wo), codes
    for level in pyramid_levels(model, codes)[1:]:
        f, top, plain = (mip_pyramid.half_resolution(x, 0, len(x)) for x in (f, top, plain))
        whole = values(model, level, wi, wo)
        of_rest = whole - tops(model, level, wi, wo) + top
        rest, found, naive = (
            stack_error(x, f, wi[:, 2], wo[:, 2]).mean()
            for x in (of_rest, whole, values(model, plain, wi, wo))
        )
        # A mean of logarithms, of metals whose widths differ by a factor of four
        assert rest < 0.04
        # One lobe stands for up to 256 with widths from 0.05 to 0.4, at a quarter of the light.
        assert found < 0.06
        assert found < 0.6 * naive


def test_every_level_keeps_the_light(model, lacquers):
    """Under light from all sides."""
    codes = lacquers(64).reshape(8, 8, 3, -1)
    cosines = albedo_rule().cosines
    weights = np.abs(np.gradient(cosines)) * cosines

    def light(z):
        return energy.directional_albedos(model, z.reshape(-1, z.shape[-1])) @ (
            weights / weights.sum()
        )

    whole = light(codes).reshape(64, 3).mean(axis=0)
    # Averages of different lobes are unlike the training data: E is about a percent.
    np.testing.assert_allclose(light(pyramid_levels(model, codes)[-1]), whole, rtol=0.02)
    assert (
        light(codes.mean(axis=(0, 1))) < 0.97 * whole
    ).all()  # plain averages of codes lose more light


@pytest.mark.parametrize("side", (4, 64))
def test_levels_of_a_constant_texture_are_constant(model, lacquers, side):
    code = lacquers(1)[0]
    whole = pyramid_levels(model, np.broadcast_to(code, (side, side, *code.shape)))
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


def test_a_store_has_levels_within_what_it_can_store(model, lacquers):
    """Encoded averages may lie outside of what the first level's codes span."""
    codes = (
        lacquers(64).reshape(8, 8, 3, -1).astype(np.float16).astype(np.float32)
    )  # the precision in which codes are written
    store = TextureStore(model, 3, 8, 8, mipmaps=True)
    store.write(slice(None), codes.reshape(64, 3, -1))
    expected = np.concatenate([z.reshape(-1, 3, z.shape[-1]) for z in pyramid_levels(model, codes)])
    error = np.abs(store.read(slice(None)) - expected)
    assert (error <= 0.6 * store.packed.step + 1e-3).all()
    # an edit that widens all ranges
    store.write(np.arange(2), 1.5 * codes[0, :2])
    codes[0, :2] *= 1.5
    expected = np.concatenate([z.reshape(-1, 3, z.shape[-1]) for z in pyramid_levels(model, codes)])
    # Averages are rounded twice, and the averaged codes were rounded before.
    error = np.abs(store.read(slice(None)) - expected)
    assert (error <= 2 * store.packed.step + 0.05).all()
