"""Gradients through the analytic lobe in Dr.Jit, against complex steps and differences in NumPy."""

import drjit as dr
import numpy as np
import pytest
from tests.untrained import untrained

from urushi.material.material import Material
from urushi.nets import lobe, transmittance
from urushi.nets.basis import decode
from urushi.nets.weights import Model

#: alpha, normal, grazing, exact, eta, k of three channels.
LOBES = {
    "same dielectric": [(0.1, 0, 0, 1, 1.5, 0)] * 3,
    "dielectrics": [(0.1, 0, 0, 1, 1.5, 0), (0.2, 0, 0, 1, 1.2, 0), (0.5, 0, 0, 1, 2.5, 0)],
    "total reflection": [(0.2, 0, 0, 1, 0.625, 0)] * 3,
    "metal": [(0.1, 0, 0, 1, 0.2, 3.9), (0.1, 0, 0, 1, 0.4, 2.4), (0.1, 0, 0, 1, 1.4, 1.6)],
    "schlick": [(0.3, 0.9, 1, 0, 1.5, 0), (0.2, 0.7, 1, 0, 1.5, 0), (0.1, 0.3, 1, 0, 1.5, 0)],
    "none": [lobe.NO_LOBE] * 3,
}


@pytest.fixture(scope="module")
def model() -> Model:
    return untrained(3)


def directions(count: int = 400) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(2)
    w = rng.normal(size=(2, count, 3))
    w[1, ::2] = w[0, ::2] * [-1, -1, 1] + 0.1 * rng.normal(size=(count // 2, 3))
    w[..., 2] = np.abs(w[..., 2]) + 0.05
    return tuple(w / np.linalg.norm(w, axis=-1, keepdims=True))


def slopes(model, codes, wi, wo):
    """Derivatives (C, N, size) of f by the codes (C, size), in double precision."""
    own = codes[:, None, :6]
    top = [lobe.f(own + 1e-20j * step, wi, wo).imag / 1e-20 for step in np.eye(6)]
    functions = model.networks.basis.at(wi, wo)
    rest = decode(codes[:, None, model.arch.lobe :], functions)
    for place in (0, 3, 4):  # the width, the factor and the index
        low, high = (own + sign * 1e-6 * np.eye(6)[place] for sign in (-1, 1))
        change = transmittance.both_ways(high, wi, wo) - transmittance.both_ways(low, wi, wo)
        top[place] = top[place] + rest * change / 2e-6
    of_rest = (transmittance.both_ways(own, wi, wo) * rest)[..., None] * functions[:, 1:]
    return np.concatenate([np.stack(top, axis=-1), of_rest], axis=-1)


@pytest.mark.parametrize("name", LOBES)
def test_f_has_the_gradients_of_all_numbers(rgb, model, name):
    """Single precision of lobes of width 0.1, summed over 400 pairs: 1e-3."""
    from urushi.mitsuba.latents.codes import ConstantLatents

    rest = np.random.default_rng(1).normal(size=(3, model.arch.latent - 6))
    codes = np.concatenate([LOBES[name], rest], axis=1)
    wi, wo = directions()
    # At the critical angle the slope is infinite.
    critical = np.abs(1 - lobe.cosine_to_facet(wi, wo) ** 2 - codes[0, 4] ** 2) < 0.02
    wi, wo = wi[~critical], wo[~critical]
    tensor = rgb.TensorXf(codes.astype(np.float32))
    dr.enable_grad(tensor)
    held = ConstantLatents(Material(codes.astype(np.float32), model), tensor)
    si = dr.zeros(rgb.SurfaceInteraction3f, len(wi))
    si.wi = rgb.Vector3f(wi.T.astype(np.float32))
    si.uv = rgb.Point2f(0.3, 0.6)
    out = rgb.Vector3f(wo.T.astype(np.float32))
    vertex = held.vertex(si, rgb.Bool(True))
    channels, _ = held.f_and_pdf(vertex, si, out, rgb.Bool(True))
    weights = np.random.default_rng(3).uniform(0.5, 1.5, (3, len(wi)))
    total = sum(
        dr.sum(f * rgb.Float(w.astype(np.float32))) for f, w in zip(channels, weights, strict=True)
    )
    dr.backward(total)
    found = dr.grad(tensor).numpy()
    parts = weights[..., None] * slopes(model, codes, wi, wo)
    error = np.abs(found - parts.sum(axis=1)) / (np.abs(parts).sum(axis=1) + 1e-6)
    assert np.isfinite(found).all()
    assert error.max() < 1e-3
