"""The hemisphere rule against integrals in closed form."""

import numpy as np
import pytest

from urushi.core.quadrature import half_vector_rule


def _incident(cos_i, azimuth=0.4):
    sin_i = np.sqrt(1 - cos_i**2)
    return np.array([[sin_i * np.cos(azimuth), sin_i * np.sin(azimuth), cos_i]])


@pytest.mark.parametrize("cos_i", [1.0, 0.999, 0.5, 0.1, 0.01, 0.001])
def test_moments_of_the_cosine(cos_i):
    # The integral of cos^n over the hemisphere is 2 pi / (n + 1): as albedos (f = cos^(n-1) / pi)
    # within the 0.001 that the rule promises.
    wo, weights = half_vector_rule(_incident(cos_i))
    np.testing.assert_allclose(np.linalg.norm(wo, axis=-1), 1, atol=1e-12)
    assert (wo[..., 2] > 0).all() and (weights > 0).all()
    for power in (1, 2, 5):
        total = np.sum(weights * wo[..., 2] ** power) / np.pi
        assert total == pytest.approx(2 / (power + 1), abs=1e-3)


@pytest.mark.parametrize("alpha", [0.01, 0.1, 0.4])
@pytest.mark.parametrize("cos_i", [1.0, 0.7, 0.1])
def test_lobes_of_any_width(alpha, cos_i):
    # f cos_o = D(h) / 4, a GGX lobe without Fresnel and shadowing. Since d(wo) = 4 (wi.h) d(h),
    # its integral is that of D(h) (wi.h) over the half vectors that reflect wi upwards, here by a
    # plain midpoint rule in theta_h and phi_h.
    wi = _incident(cos_i, azimuth=0.0)

    def ggx(h_z):
        return alpha**2 / (np.pi * ((alpha**2 - 1) * h_z**2 + 1) ** 2)

    wo, weights = half_vector_rule(wi)
    h = wi[:, None] + wo
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    total = np.sum(weights * ggx(h[..., 2]) / 4)

    theta = 0.5 * np.pi * ((np.arange(4000) + 0.5) / 4000)[:, None] ** 2
    step = np.pi / 4000 * np.sqrt(theta / (0.5 * np.pi))
    phi = np.pi * (np.arange(256) + 0.5)[None] / 256
    dot = wi[0, 0] * np.sin(theta) * np.cos(phi) + wi[0, 2] * np.cos(theta)
    up = (dot > 0) & (2 * dot * np.cos(theta) > wi[0, 2])
    expected = np.sum(np.where(up, ggx(np.cos(theta)) * dot * np.sin(theta) * step, 0))
    expected *= 2 * np.pi / 256
    assert total == pytest.approx(expected, rel=1e-3)
