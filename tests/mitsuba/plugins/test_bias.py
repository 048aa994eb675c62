"""Samples of materials at the ends of their ranges add up to the albedo."""

import drjit as dr
import numpy as np
import pytest

#: Materials at the ends of the parameters' ranges.
EXTREME = {
    "smooth on smooth": {"alpha": 0.01, "alpha_bottom": 0.01},
    "white and thick": {"alpha": 0.3, "albedo": 1.0, "sigma_t": 8.0},
    "black and thick": {"alpha": 0.01, "albedo": 0.0, "sigma_t": 8.0},
    "rough on smooth": {
        "alpha": 1.0,
        "alpha_bottom": 0.01,
        "g": 0.9,
        "sigma_t": 1.0,
        "albedo": 1.0,
    },
}


def described(alpha_bottom: float = 0.1, **coat) -> dict:
    return {
        "type": "neural_layered",
        "base": {"type": "roughconductor", "distribution": "ggx", "alpha": alpha_bottom},
        **coat,
    }


@pytest.mark.parametrize("name", EXTREME)
@pytest.mark.parametrize("degrees", (0, 60, 85, 89))
def test_extreme_materials_reflect_their_albedo(rgb, name, degrees):
    bsdf, count = rgb.load_dict(described(**EXTREME[name])), 1 << 16
    wi = np.array([[np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))]], np.float32)
    si = dr.zeros(rgb.SurfaceInteraction3f, count)
    si.wi = rgb.Vector3f(*wi[0].tolist())
    dr.make_opaque(si.wi)  # one kernel for all directions
    sampler = rgb.load_dict({"type": "independent"})
    sampler.seed(3, count)
    _, weight = bsdf.sample(rgb.BSDFContext(), si, sampler.next_1d(), sampler.next_2d())
    weight = weight.numpy()[0]
    assert np.isfinite(weight).all()
    assert (weight >= 0).all()
    assert weight.max() < 100  # 67 at 85 degrees, smooth on smooth
    expected = bsdf.latents.material.directional_albedo(wi)[0, 0]
    # the quadrature of the albedo has an error of a few parts in a thousand
    assert weight.mean() == pytest.approx(
        expected, abs=5 * weight.std() / np.sqrt(count) + 5e-3 * expected
    )
