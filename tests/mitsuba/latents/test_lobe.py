"""The analytic lobe in Dr.Jit agrees with NumPy, alone and in the f and the proposals of codes."""

import drjit as dr
import numpy as np
import pytest
from tests.mitsuba.probes import vector
from tests.untrained import untrained

from urushi.core.table import interpolated
from urushi.material.material import Material
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
    "schlick": [(0.3, 0.9, 1, 0, 1.5, 0), (0.2, 0.7, 1, 0, 1.5, 0), (0.1, 0.3, 1, 0, 1.5, 0)],
    "blend": [(0.3, 0.5, 0.4, 0.2, 1.5, 0), (0.2, 0.1, 0.1, 1, 1.5, 1), (0.1, 0, 0, 1, 1.2, 0)],
    "none": [numpy_lobe.NO_LOBE] * 3,
}


@pytest.fixture(scope="module")
def model() -> Model:
    """A small basis of smooth random functions."""
    return untrained(3)


def codes(name: str) -> np.ndarray:
    """Codes (3, 14) of these lobes and a random rest."""
    rest = np.random.default_rng(1).normal(size=(3, 8))
    return np.concatenate([LOBES[name], rest], axis=1).astype(np.float32)


def directions(count: int = 2048) -> tuple[np.ndarray, np.ndarray]:
    """Pairs: at random, grazing, about mirror directions, and exactly mirrored or opposite."""
    rng = np.random.default_rng(2)
    w = rng.normal(size=(2, count, 3))
    w[:, ::3, 2] *= 1e-3
    w[1, ::2] = w[0, ::2] * [-1, -1, 1] + 0.01 * rng.normal(size=(count // 2, 3))
    w[1, ::8] = w[0, ::8] * [-1, -1, 1]
    w[1, 1::8] = w[0, 1::8]
    w[..., 2] = np.abs(w[..., 2])
    w /= np.linalg.norm(w, axis=-1, keepdims=True)
    return tuple(w.astype(np.float32))


def interaction(mi, wi):
    si = dr.zeros(mi.SurfaceInteraction3f, len(wi))
    si.wi = vector(wi)
    return si


def constant(model, z):
    from urushi.mitsuba.latents.codes import ConstantLatents

    return ConstantLatents(Material(z, model))


def textured(model, z):
    """A texture of 4 x 2 equal texels."""
    from urushi.mitsuba.latents.over_axes import AxisLatents
    from urushi.mitsuba.latents.texels import texel_axes

    grid = TexelGrid(4, 2)
    baked = Baked.of_texels(model, np.broadcast_to(z, (8, *z.shape)), grid)
    return AxisLatents(baked, texel_axes(grid))


def evaluated(mi, latents, wi, wo) -> np.ndarray:
    """f (N, 3)."""
    si, active = interaction(mi, wi), mi.Bool(np.ones(len(wi), bool))
    f, _ = latents.f_and_pdf(latents.vertex(si, active), si, vector(wo), active)
    return np.stack([x.numpy() for x in f], axis=-1)


@pytest.mark.parametrize("name", LOBES)
@pytest.mark.parametrize("codes_of", [constant, textured])
def test_f_agrees_with_numpy(rgb, model, name, codes_of):
    z = codes(name)
    wi, wo = directions()
    exact = z.astype(np.float64), *(w[:, None].astype(np.float64) for w in (wi, wo))
    table = model.networks.table(z)
    assert table is not None
    passed = transmittance.both_ways(exact[0][:, :6], *exact[1:])
    expected = model.networks.top(*exact) + passed * interpolated(table, wi, wo)
    f = evaluated(rgb, codes_of(model, z), wi, wo)
    assert np.isfinite(f).all()
    # Half vectors of float32 directions lose digits: |h_xy|^2 of a lobe of width 0.01 by 1e-3.
    # Coordinates of tables lose digits at grazing angles.
    np.testing.assert_allclose(f, expected, rtol=5e-3)


@pytest.mark.parametrize("name", LOBES)
def test_the_transmittance_is_computed_where_it_is_not_one(rgb, name):
    from urushi.mitsuba.latents.lobe import kind_of

    z = np.float32(LOBES[name])
    passed = transmittance.both_ways(z, *(w[:, None] for w in directions()))
    assert kind_of(z).edged == (passed != 1).any()


@pytest.mark.parametrize("name", LOBES)
@pytest.mark.parametrize("codes_of", [constant, textured])
def test_f_is_reciprocal_to_the_last_bit(rgb, model, name, codes_of):
    wi, wo = directions()
    latents = codes_of(model, codes(name))
    np.testing.assert_array_equal(evaluated(rgb, latents, wi, wo), evaluated(rgb, latents, wo, wi))


@pytest.mark.parametrize(
    "kind",
    [
        {},
        {"schlick": False},
        {"schlick": False, "plain": True, "absorbing": False},
        {"schlick": False, "plain": True, "absorbing": False, "same_alpha": True}
        | {"same_reflectance": True},
    ],
)
def test_what_is_known_of_lobes_does_not_change_them(rgb, kind):
    from urushi.mitsuba.latents import lobe

    z = np.float32(LOBES["dielectric"])
    wi, wo = (vector(w) for w in directions())
    numbers = [[rgb.Float(float(x)) for x in channel] for channel in z]
    expected = lobe.f(numbers, wi, wo, lobe.ANY_LOBE)
    values = lobe.f(numbers, wi, wo, lobe.LobeKind(**kind))
    for a, b in zip(values, expected, strict=True):
        np.testing.assert_allclose(a.numpy(), b.numpy(), rtol=1e-4)
