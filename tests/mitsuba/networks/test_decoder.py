"""The networks in Dr.Jit agree with those in NumPy, and f is reciprocal in both."""

import drjit as dr
import numpy as np
import pytest

from urushi.material import Material
from urushi.nets import features as numpy_features
from urushi.nets import proposal as numpy_lobes


def hemisphere(count: int, seed: int) -> np.ndarray:
    """Unit vectors (count, 3) above the horizon, a third of them grazing."""
    rng = np.random.default_rng(seed)
    w = rng.normal(size=(count, 3))
    w[::3, 2] *= 1e-2
    w[:, 2] = np.abs(w[:, 2])
    return (w / np.linalg.norm(w, axis=1, keepdims=True)).astype(np.float32)


def pairs(count: int = 4096) -> tuple[np.ndarray, np.ndarray]:
    """Pairs, half of them close to mirror directions."""
    wi, wo = hemisphere(count, 1), hemisphere(count, 2)
    noise = np.random.default_rng(3).normal(size=(count, 3)) * 0.01
    mirrored = wi * [-1, -1, 1] + noise
    mirrored[:, 2] = np.abs(mirrored[:, 2])
    wo[::2] = (mirrored / np.linalg.norm(mirrored, axis=1, keepdims=True))[::2]
    return wi, wo


def latents(count: int, seed: int = 0) -> np.ndarray:
    codes = np.random.default_rng(seed).normal(size=(count, 32))
    codes[:, :6] = [0.2, 0, 0, 1, 1.5, 0]
    return codes.astype(np.float32)


@pytest.fixture
def parts(rgb, model):
    """Constant latents in Dr.Jit and the same material in NumPy."""
    from urushi.mitsuba.latents.holders import ConstantLatents

    z = latents(3)
    return ConstantLatents(Material(z, model)), Material(z, model)


def vector(mi, w):
    return mi.Vector3f(np.ascontiguousarray(w.T))


def interaction(mi, wi):
    si = dr.zeros(mi.SurfaceInteraction3f, len(wi))
    si.wi = vector(mi, wi)
    return si


def evaluated(latents, si, wo) -> list:
    """f of every channel."""
    active = dr.full(dr.mask_t(si.t), True, dr.width(wo))
    return latents.f(latents.vertex(si, active), si, wo, active)


def test_features_agree_with_numpy(rgb):
    from urushi.core.namespace import DRJIT

    wi, wo = pairs()
    columns = numpy_features.direction_columns(vector(rgb, wi), vector(rgb, wo), 1, DRJIT)
    ours = np.stack([x.numpy() for x in numpy_features.DIRECTIONS[1].each(columns)], -1)
    # rounding of logarithms of small half angles, in units of their spread
    np.testing.assert_allclose(ours, numpy_features.direction_features(wi, wo), atol=2e-5)


def test_density_and_samples_of_a_mixture_agree_with_numpy(rgb):
    from urushi.core.mixture import Mixture

    wi, wo = pairs()
    rng = np.random.default_rng(7)
    alphas = np.exp(rng.uniform(np.log(0.01), 0, (len(wi), 2))).astype(np.float32)
    weights = rng.dirichlet([1, 1, 1], len(wi)).astype(np.float32)
    u = rng.random((len(wi), 3), np.float32)
    mixture = Mixture([rgb.Float(x) for x in weights.T], [rgb.Float(x) for x in alphas.T])
    density = mixture.pdf(vector(rgb, wi), vector(rgb, wo)).numpy()
    # |h_xy|^2 of a lobe of width 0.01 loses digits where the directions are nearly opposite
    np.testing.assert_allclose(density, numpy_lobes.mixture_pdf(weights, alphas, wi, wo), rtol=1e-3)
    drawn = mixture.sample(
        vector(rgb, wi), rgb.Float(u[:, 0]), rgb.Point2f(*map(rgb.Float, u[:, 1:].T))
    )
    # reflecting about a normal that is nearly perpendicular to wi loses three of seven digits
    np.testing.assert_allclose(
        drawn.numpy().T, numpy_lobes.sample_mixture(weights, alphas, wi, u), atol=3e-4
    )


@pytest.mark.parametrize("count", [1, 2, 3, 12])
def test_layers_of_several_inputs_agree_with_numpy(rgb, count):
    from urushi.mitsuba.networks import mlp

    rng = np.random.default_rng(count)
    x = rng.normal(size=(count, 5, 7)).astype(np.float32)  # lists, inputs, points
    weight, bias = rng.normal(size=(5, 25)), rng.normal(size=25)
    lists = [[rgb.Float(values) for values in one] for one in x]
    found = mlp.dense_each(lists, weight, bias.tolist())
    expected = np.einsum("lip,io->lop", x, weight) + bias[:, None]
    np.testing.assert_allclose([[y.numpy() for y in one] for one in found], expected, atol=1e-5)
