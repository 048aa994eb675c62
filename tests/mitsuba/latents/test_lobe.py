"""f and densities of codes of every kind of lobe in Dr.Jit are NumPy's; derivatives of f."""

import drjit as dr
import numpy as np
import pytest
from tests.directions import pairs_near_mirrors
from tests.mitsuba.probes import vector
from tests.untrained import untrained

from urushi.core.direction_sets import cosine_pairs
from urushi.core.table import interpolated
from urushi.material.material import Material
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.codes import ConstantLatents
from urushi.mitsuba.latents.over_axes import AxisLatents, texel_axes
from urushi.nets import lobe as numpy_lobe
from urushi.nets import transmittance
from urushi.nets.weights import Model
from urushi.textures.baking import Baked
from urushi.textures.store import TexelGrid

#: alpha, normal, grazing, exact, eta, k; one for each kind of code that is recorded.
LOBES = {
    "dielectric": [(0.1, 0, 0, 1, 1.5, 0)] * 3,
    "sharp dielectric": [(0.01, 0, 0, 1, 1.5, 0)] * 3,
    "total reflection": [(0.2, 0, 0, 1, 0.625, 0)] * 3,
    "one of three reflects totally": [
        (0.3, 0, 0, 1, 1.4, 0),
        (0.05, 0, 0, 0.5, 0.8, 0),
        (0.2, 0, 0, 1, 0.8, 2.0),
    ],
    "no interface": [(0.3, 0, 0, 1, 1.0, 0)] * 3,
    "metal": [(0.01, 0, 0, 1, 0.2, 3.9), (0.01, 0, 0, 1, 0.4, 2.4), (0.01, 0, 0, 1, 1.4, 1.6)],
    "rough metal": [(0.1, 0, 0, 1, 0.2, 3.9), (0.1, 0, 0, 1, 0.4, 2.4), (0.1, 0, 0, 1, 1.4, 1.6)],
    "dielectrics": [(0.1, 0, 0, 1, 1.5, 0), (0.2, 0, 0, 1, 1.2, 0), (0.5, 0, 0, 1, 2.5, 0)],
    "schlick": [(0.3, 0.9, 1, 0, 1.5, 0), (0.2, 0.7, 1, 0, 1.5, 0), (0.1, 0.3, 1, 0, 1.5, 0)],
    "blend": [(0.3, 0.5, 0.4, 0.2, 1.5, 0), (0.2, 0.1, 0.1, 1, 1.5, 1), (0.1, 0, 0, 1, 1.2, 0)],
    "none": [numpy_lobe.NO_LOBE] * 3,
}

#: Lobes whose gradients single precision resolves.
SMOOTH = ("dielectric", "dielectrics", "total reflection", "rough metal", "schlick", "none")


@pytest.fixture(scope="module")
def model() -> Model:
    """A small basis of smooth random functions."""
    return untrained(3)


def codes(name: str) -> np.ndarray:
    """Codes (3, 14) of these lobes and a random rest."""
    rest = np.random.default_rng(1).normal(size=(3, 8))
    return np.concatenate([LOBES[name], rest], axis=1).astype(np.float32)


def directions() -> tuple[np.ndarray, np.ndarray]:
    """Pairs: at random, grazing, about mirror directions, and exactly mirrored or opposite."""
    wi, wo = pairs_near_mirrors(2048)
    wo[::8], wo[1::8] = wi[::8] * [-1, -1, 1], wi[1::8]
    return wi, wo


def constant(model, z, tensor=None):
    return ConstantLatents(Material(z, model), tensor)


def textured(model, *codes):
    """A texture of 4 x 2 texels, in turn of these codes."""
    grid, texels = TexelGrid(4, 2), np.stack(codes * (8 // len(codes)))
    return AxisLatents(Baked.of_texels(model, texels, grid), texel_axes(grid))


def evaluated(mi, latents, wi, wo) -> tuple:
    """f (N) of each channel and the density (N), Dr.Jit floats, at random places."""
    uv = np.random.default_rng(4).random((len(wi), 2))
    si, active = spectrum.points(uv), mi.Bool(np.ones(len(wi), bool))
    si.wi = vector(wi)
    return latents.f_and_pdf(latents.vertex(si, active), si, vector(wo), active)


@pytest.mark.parametrize("name", LOBES)
@pytest.mark.parametrize("codes_of", [constant, textured])
def test_codes_agree_with_numpy_and_are_reciprocal_to_the_last_bit(rgb, model, name, codes_of):
    z = codes(name)
    wi, wo = directions()
    exact = z.astype(np.float64), *(w[:, None].astype(np.float64) for w in (wi, wo))
    table = model.networks.table(z)
    assert table is not None
    passed = transmittance.both_ways(exact[0][:, :6], *exact[1:])
    expected = model.networks.top(*exact) + passed * interpolated(table, wi, wo)
    latents = codes_of(model, z)
    values, pdf = evaluated(rgb, latents, wi, wo)
    f = np.stack([x.numpy() for x in values], axis=-1)
    assert np.isfinite(f).all()
    # Half vectors of float32 directions lose digits: |h_xy|^2 of a lobe of width 0.01 by 1e-3.
    # Coordinates of tables lose digits at grazing angles.
    np.testing.assert_allclose(f, expected, rtol=5e-3)
    back = np.stack([x.numpy() for x in evaluated(rgb, latents, wo, wi)[0]], axis=-1)
    np.testing.assert_array_equal(f, back)
    check_density(pdf, Material(z, model), wi, wo, codes_of)


def check_density(pdf, material: Material, wi, wo, codes_of) -> None:
    """Of one code the weights of lobes are linear between 129 cosines; logarithms are rounded."""
    tolerance = 0.1 if codes_of is constant else 1e-3
    np.testing.assert_allclose(pdf.numpy(), material.pdf(wi, wo), rtol=tolerance)


@pytest.mark.parametrize("widths", [1, 2])
@pytest.mark.parametrize("codes_of", [constant, textured])
def test_channels_of_one_code_are_evaluated_once(rgb, codes_of, widths):
    """And have the values of channels on their own; of texels, one is drawn."""
    model = untrained(3, functions=8, widths=widths)
    z = np.random.default_rng(1).normal(size=(2, model.arch.latent)).astype(np.float32)
    z[:, : model.arch.lobe] = [(0.2, 0, 0, 1, 1.5, 0, 0.1)[: model.arch.lobe]] * 2
    wi, wo = cosine_pairs(np.random.default_rng(0), 500, lowest_cosine=0.02)
    expected = model.networks.f(z[:, None], wi, wo)
    assert not np.allclose(*expected, rtol=1e-2)
    same = codes_of(model, z[[0, 0, 0]], *([z[[1, 1, 1]]] if codes_of is textured else []))
    assert same.channels == 3
    np.testing.assert_array_equal(same.at(np.zeros((1, 2)))[0], z[[0, 0, 0]])
    values, _ = evaluated(rgb, same, wi, wo)
    f = np.array([x.numpy() for x in values])
    assert f.shape == (3, 500) and (f == f[0]).all()
    # Logarithms of small half angles are rounded.
    own = expected if codes_of is textured else expected[:1]
    assert (np.abs(f[0] / own - 1).min(axis=0) < 2e-3).all()
    other, pdf = evaluated(rgb, codes_of(model, z[[0, 0, 1]]), wi, wo)
    for x, code in zip(other, (0, 0, 1), strict=True):
        np.testing.assert_allclose(x.numpy(), expected[code], rtol=2e-3)
    check_density(pdf, Material(z[[0, 0, 1]], model), wi, wo, codes_of)


def slopes(model, codes, wi, wo):
    """Derivatives (C, N, size) of f by the codes (C, size), differences in double precision."""
    step = 1e-6 * np.eye(codes.shape[1])
    step[5] *= codes[0, 5] > 0  # k, of metals alone
    low, high = (
        model.networks.f(codes[:, None, None] + sign * step, wi[:, None], wo[:, None])
        for sign in (-1, 1)
    )
    return (high - low) / 2e-6


@pytest.mark.parametrize("name", SMOOTH)
def test_f_has_the_gradients_of_all_numbers(rgb, model, name):
    """Single precision of lobes of width 0.1, summed over 400 pairs: 1e-3."""
    rest = np.random.default_rng(1).normal(size=(3, model.arch.rest))
    codes = np.concatenate([LOBES[name], rest], axis=1)
    rng = np.random.default_rng(2)
    w = rng.normal(size=(2, 400, 3))
    w[1, ::2] = w[0, ::2] * [-1, -1, 1] + 0.1 * rng.normal(size=(200, 3))
    w[..., 2] = np.abs(w[..., 2]) + 0.05
    wi, wo = w / np.linalg.norm(w, axis=-1, keepdims=True)
    # At the critical angle the slope is infinite.
    critical = np.abs(1 - numpy_lobe.cosine_to_facet(wi, wo) ** 2 - codes[0, 4] ** 2) < 0.02
    wi, wo = wi[~critical], wo[~critical]
    tensor = rgb.TensorXf(codes.astype(np.float32))
    dr.enable_grad(tensor)
    f, _ = evaluated(rgb, constant(model, codes.astype(np.float32), tensor), wi, wo)
    weights = np.random.default_rng(3).uniform(0.5, 1.5, (3, len(wi)))
    each = zip(f, weights.astype(np.float32), strict=True)
    dr.backward(sum(dr.sum(x * rgb.Float(weight)) for x, weight in each))
    found = dr.grad(tensor).numpy()
    parts = weights[..., None] * slopes(model, codes, wi, wo)
    error = np.abs(found - parts.sum(axis=1)) / (np.abs(parts).sum(axis=1) + 1e-6)
    assert np.isfinite(found).all()
    assert error.max() < 1e-3


def test_derivatives_by_directions_are_differences(rgb, model):
    latents, wo = textured(model, codes("dielectrics")), rgb.Vector3f(-0.5, 0.17, 0.6)

    def f(x):
        si = spectrum.points(np.zeros((1, 2)))
        si.wi = dr.normalize(rgb.Vector3f(0.31 + x, 0.2, 0.9))
        vertex, active = latents.vertex(si, rgb.Bool(True)), rgb.Bool(True)
        return latents.f_and_pdf(vertex, si, dr.normalize(wo), active)[0][0]

    change = rgb.Float(0)
    dr.enable_grad(change)
    value = f(change)
    dr.forward(change)
    slope = (f(1e-3) - f(-1e-3)) / 2e-3  # within one cell of the table
    np.testing.assert_allclose(value.grad.numpy(), slope.numpy(), rtol=0.02)
