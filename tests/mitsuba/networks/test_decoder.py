"""Mixtures in Dr.Jit agree with NumPy; pairs for other tests."""

import numpy as np
from tests import mixtures
from tests.mitsuba.probes import vector


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


def test_density_and_samples_of_a_mixture_agree_with_numpy(rgb):
    from urushi.core.mixture import Mixture

    wi, wo = pairs()
    rng = np.random.default_rng(7)
    alphas = np.exp(rng.uniform(np.log(0.01), 0, (len(wi), 2))).astype(np.float32)
    weights = rng.dirichlet([1, 1, 1], len(wi)).astype(np.float32)
    u = rng.random((len(wi), 3), np.float32)
    own = mixtures.of_arrays(weights, alphas)
    mixture = Mixture([rgb.Float(x) for x in weights.T], [rgb.Float(x) for x in alphas.T])
    density = mixture.pdf(vector(wi), vector(wo)).numpy()
    # |h_xy|^2 of a lobe of width 0.01 loses digits where the directions are nearly opposite
    np.testing.assert_allclose(density, mixtures.pdf(own, wi, wo), rtol=1e-3)
    drawn = mixture.sample(vector(wi), rgb.Float(u[:, 0]), rgb.Point2f(*map(rgb.Float, u[:, 1:].T)))
    # reflecting about a normal that is nearly perpendicular to wi loses three of seven digits
    np.testing.assert_allclose(drawn.numpy().T, mixtures.sample(own, wi, u), atol=3e-4)
