"""Channels of the same code are evaluated once: the values are those of channels on their own."""

import drjit as dr
import numpy as np
import pytest
from tests.mitsuba.probes import vector
from tests.untrained import untrained

from urushi.core.direction_sets import cosine_pairs
from urushi.material.material import Material
from urushi.mitsuba import spectrum
from urushi.nets.weights import Model
from urushi.textures.baking import Baked
from urushi.textures.store import TexelGrid

COUNT = 500

#: The codes of three channels.
SAME, OTHER = [0, 0, 0], [0, 0, 1]


@pytest.fixture(scope="module", params=[1, 2], ids=["one width", "two widths"])
def model(request) -> Model:
    return untrained(3, functions=8, widths=request.param)


@pytest.fixture
def codes(model) -> np.ndarray:
    """Two codes (2, L) of dielectrics."""
    codes = np.random.default_rng(1).normal(size=(2, model.arch.latent)).astype(np.float32)
    codes[:, : model.arch.lobe] = [(0.2, 0, 0, 1, 1.5, 0, 0.1)[: model.arch.lobe]] * 2
    return codes


@pytest.fixture
def points() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Directions wi, wo (N, 3) and uv (N, 2)."""
    pairs = cosine_pairs(np.random.default_rng(0), COUNT, lowest_cosine=0.02)
    return *pairs, np.random.default_rng(4).random((COUNT, 2))


def values(mi, latents, wi, wo, uv) -> np.ndarray:
    """f (C, N)."""
    si = spectrum.points(uv)
    si.wi, active = vector(wi), dr.full(mi.Bool, True, COUNT)
    f, _ = latents.f_and_pdf(latents.vertex(si, active), si, vector(wo), active)
    return np.stack([x.numpy() for x in f])


def test_a_constant_of_one_code(rgb, model, codes, points):
    from urushi.mitsuba.latents.codes import ConstantLatents

    shared, separate = (
        ConstantLatents(Material(codes[channels], model)) for channels in (SAME, OTHER)
    )
    found, expected = (values(rgb, x, *points) for x in (shared, separate))
    assert found.shape == (3, COUNT)
    assert (found == found[0]).all()
    # The compiler may contract the products of one kernel and not of the other.
    np.testing.assert_allclose(found[0], expected[0], rtol=1e-5)
    assert not np.allclose(expected[0], expected[2], rtol=1e-2)
    assert shared.channels == 3
    np.testing.assert_array_equal(shared.at(np.zeros((1, 2)))[0], codes[SAME])


def test_a_texture_of_one_code_a_texel(rgb, model, codes, points):
    """The values are those of the codes that are looked up."""
    from urushi.mitsuba.latents.over_axes import AxisLatents
    from urushi.mitsuba.latents.texels import texel_axes

    grid, texels = TexelGrid(2, 2), codes[[SAME, [1, 1, 1], SAME, [1, 1, 1]]]
    latents = AxisLatents(Baked.of_texels(model, texels, grid), texel_axes(grid))
    assert latents.channels == 3
    expected = model.networks.f(codes[:, None], *points[:2])
    found = values(rgb, latents, *points)
    assert found.shape == (3, COUNT)
    assert (found == found[0]).all()
    # One texel is drawn. Logarithms of small half angles are rounded.
    assert (np.abs(found[0] / expected - 1).min(axis=0) < 2e-3).all()
