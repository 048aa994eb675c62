"""Codes of a texture in less memory: packed into bytes, and as principal numbers."""

import numpy as np
import pytest
from benchmarks.measures import stack_error

from urushi.checks import CoatParameters, Widths
from urushi.core.direction_sets import cosine_pairs
from urushi.core.stretched import rounded
from urushi.material.layer import predicted
from urushi.nets import lobe as lobes
from urushi.nets.weights import Model, anisotropic_model, default_model
from urushi.textures import packing
from urushi.textures.packing import Texture
from urushi.textures.principal import projection_of


@pytest.fixture(scope="module")
def model() -> Model:
    return default_model()


@pytest.fixture(scope="module")
def lacquers(model):
    """From a number of texels: codes (n, 3, size) of lacquers over metals that shine and diffuse.

    A texel has one width of the lacquer, and in each channel a width of the metal, its reflectance
    and a diffuse reflectance.
    """

    def draw(count: int) -> np.ndarray:
        rng = np.random.default_rng(0)
        lobe = np.zeros((count, 3, 6))
        lobe[..., 0] = rng.uniform(0.05, 0.4, (count, 1))
        lobe[..., 3:5] = 1, 1.5
        metal = np.zeros((count, 3, 6))
        metal[..., 0] = rng.uniform(0.1, 0.4, (count, 3))
        metal[..., 1:3] = rng.uniform(0.1, 0.5, (count, 3, 1))
        metal[..., 4] = 1.5
        wi, wo = model.networks.pairs()
        f = lobes.f(lobe[..., None, :], wi, wo) + lobes.f(metal[..., None, :], wi, wo)
        f += rng.uniform(0.02, 0.4, (count, 3, 1)) / np.pi
        return model.networks.encode(f.astype(np.float32), lobe.astype(np.float32))

    return draw


@pytest.fixture
def codes(model):
    """Codes (35, 3, size) whose numbers have very different ranges."""
    rng = np.random.default_rng(0)
    count = model.arch.functions
    lobe = rng.uniform([0.05, 0, 0, 0, 1.3, 0], [0.9, 1, 1, 1, 1.9, 4], (35, 3, 6))
    rest = rng.normal(size=(35, 3, count)) * 10.0 ** rng.uniform(-3, -0.5, count)
    return np.concatenate([lobe, rest], axis=-1).astype(np.float32)


@pytest.mark.parametrize("channels", (1, 2, 3, 5))
@pytest.mark.parametrize("scale", (1e-6, 1e-4, 1e-2))
def test_a_layout_fills_a_power_of_two_with_the_numbers_of_greatest_effect(channels, scale):
    """Each number once, or twice; those of 8 bits change f by less than the limit."""
    errors = scale * np.random.default_rng(0).random(30)
    layout = packing.texel_layout(channels, errors, *np.zeros((2, 30), bool))
    seconds = [byte for byte in layout.low if byte >= 0]
    assert sorted(seconds) == list(range(layout.size, layout.stride))
    assert channels * layout.stride <= layout.texel_bytes
    assert layout.texel_bytes.bit_count() == 1
    # one more byte would not fit into all channels
    assert layout.texel_bytes < channels * (layout.stride + 1) or layout.stride == 2 * layout.size
    coarse = np.array(layout.low) < 0
    assert np.square(errors[coarse]).sum() <= packing.LIMIT**2
    assert not coarse.any() or errors[coarse].max() <= errors[~coarse].min(initial=np.inf)


def test_packed_codes_give_the_same_f(model, lacquers):
    codes = lacquers(64)
    read = Texture.of(model, codes).codes()
    wi, wo = cosine_pairs(np.random.default_rng(1), 500)
    f, found = (model.networks.f(z[..., None, :], wi, wo) for z in (codes, read))
    assert stack_error(found, f, wi[:, 2], wo[:, 2]).mean() < 1e-3


def test_packing_is_as_fine_as_its_steps_and_numbers_that_are_known_take_fewer_bytes(model, codes):
    size, general = model.arch.latent, Texture.of(model, codes)
    known = codes.copy()
    known[..., : size // 2] = known[:, :1, : size // 2]
    known[..., -4:] = [1, 0, 2, -3]
    texture = Texture.of(model, known)
    for packed, given in ((general, codes), (texture, known)):
        half = 0.5 * packed.step + 1e-3 * np.abs(given)  # and half precision on the way
        assert (np.abs(packed.codes() - given) <= half).all()
        ranges = np.ptp(given, axis=(0, 1))
        np.testing.assert_allclose(packed.step * packed.layout.levels, ranges, rtol=2e-3)
    assert texture.layout.constant[-4:].all() and not texture.layout.constant[:-4].any()
    smaller = texture.layout.texel_bytes < general.layout.texel_bytes
    assert smaller or texture.layout.levels.sum() > general.layout.levels.sum()
    np.testing.assert_allclose(texture.codes()[..., -4:], known[..., -4:])


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


def test_principal_numbers_give_the_f_of_codes_by_fewer_functions(model, lacquers):
    """And that of one code of a thousand that is unlike all others."""
    codes = lacquers(256)
    assert projected(model, codes)[0].shape[1] < model.arch.functions
    found = errors(model, codes)
    assert found.mean() < 3e-3
    assert found.max() < 3e-2
    codes = np.repeat(codes[:1], 1000, axis=0)
    codes[123] = lacquers(7)[5]
    assert errors(model, codes).max() < 3e-2


def test_principal_numbers_of_brushed_metals_under_a_coat():
    """Their functions belong to factors of the azimuth, and their stretches stay."""
    model, rng = anisotropic_model(), np.random.default_rng(0)
    metals = np.zeros((64, model.arch.latent), np.float32)
    metals[:] = np.append(np.zeros(model.arch.lobe), model.networks.empty_rest())
    metals[:, [0, 6]] = rng.uniform([0.1, 0.3], [0.2, 0.5], (64, 2))
    metals[:, 1:3], metals[:, 4] = rng.uniform(0.4, 0.9, (64, 1)), 1.5
    coat = CoatParameters(Widths(0.1, 0.1), 1.5, 0.0, 0.0, 0.0)
    codes = predicted(model, metals, CoatParameters.of_columns(np.array([*coat.columns()])))
    codes[:, -1] = rounded(codes[:, -1])
    functions, _, numbers = projected(model, codes[:, None])
    assert functions.shape[1] < model.arch.functions
    np.testing.assert_array_equal(numbers[:, 0, -1], codes[:, -1])
    found = errors(model, codes[:, None])
    assert found.mean() < 4e-3
    assert found.max() < 4e-2


def test_unlike_materials_keep_their_codes(model):
    codes = np.zeros((256, 3, model.arch.latent), np.float32)
    codes[..., :6] = 0.3, 0, 0, 1, 1.5, 0
    codes[..., 6:] = np.random.default_rng(0).normal(size=(256, 3, model.arch.functions))
    assert projected(model, codes)[2].shape[-1] == model.arch.functions
    assert errors(model, codes).max() < 1e-4


@pytest.mark.parametrize("bare", [False, True])
def test_principal_numbers_of_one_material(model, lacquers, bare):
    """Nothing varies, and the numbers of codes may be zero."""
    codes = np.repeat(lacquers(1), 8, axis=0)
    if bare:
        codes[..., model.arch.lobe :] = model.networks.empty_rest()
    functions, projection, numbers = projected(model, codes)
    np.testing.assert_allclose(projection.rests(numbers), codes[..., model.arch.lobe :], atol=2e-3)
    assert np.isfinite(functions).all()
