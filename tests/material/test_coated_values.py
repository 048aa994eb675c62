"""f of coats of one GGX width and two at pairs: many coats at once, and a closed form."""

import numpy as np
import pytest
from tests.directions import in_plane

from urushi.checks import CoatParameters, Widths
from urushi.core.direction_sets import cosine_pairs
from urushi.core.microfacet import of_widths
from urushi.core.quadrature import directional_albedos
from urushi.core.table import MIN_LOG, SHAPE
from urushi.material.coated_values import coated_f
from urushi.material.reflector import Reflector
from urushi.material.substrate import Substrate
from urushi.nets import lobe as lobes


def one(alpha, *others) -> CoatParameters:
    return CoatParameters(of_widths(np.float64, alpha), *map(np.float64, others))


def lambertian(albedo=0.5, *stretch2) -> Substrate:
    logs = np.full((*SHAPE, 1), np.log(albedo / np.pi))
    return Substrate.of(Reflector.of_logs(logs, None, *stretch2))


def brushed() -> Substrate:
    """A metal of the widths 0.1 and 0.4."""
    lobe = np.float32([[0.1, 0.9, 1.0, 0.0, 1.5, 0.0, 0.4]])
    return Substrate.of(Reflector.of_logs(np.full((*SHAPE, 1), MIN_LOG), lobe, np.ones(1)))


@pytest.mark.parametrize(
    ("bottom", "alpha", "albedo", "sigma_t", "rtol"),
    [
        (brushed, [0.2, 0.2, 0.3], [0.0, 0.5, 0.0], [0.0, 1.0, 0.5], 1e-5),
        (lambertian, [0.1] * 5, [0.8] * 5, np.linspace(0, 2, 5), 0.01),
        (lambertian, [0.1] * 4, [0.02, 0.0, 0.0, 0.0], [0.18, 0.23, 0.18, 0.13], 0.01),
        # the first is black
        (lambertian, [0.1] * 4, [0.0, 0.0, 0.6, 0.6], [80.0, 1.0, 1.0, 80.0], 0.01),
        (lambertian, [0.1] * 4, [0.0] * 4, [80.0, 90.0, 100.0, 110.0], 0.01),
    ],
)
def test_many_coats_over_one_bottom(bottom, alpha, albedo, sigma_t, rtol):
    """Coats of any shape; more than three media below one interface are sums of a few."""
    (wi, wo), below = cosine_pairs(np.random.default_rng(0), 50, lowest_cosine=0.1), bottom()
    coats = [np.reshape(x, (-1, 1)) for x in (alpha, albedo, sigma_t)]
    f = coated_f(below, CoatParameters(coats[0], 1.5, *coats[1:], 0.0), wi, wo)
    assert f.shape == (50, len(alpha), 1)
    for row, (width, *medium) in enumerate(zip(alpha, albedo, sigma_t, strict=True)):
        alone = coated_f(below, one(width, 1.5, *medium, 0.0), wi, wo)
        np.testing.assert_allclose(f[:, row], alone, rtol=rtol, atol=1e-25)  # black


@pytest.mark.parametrize(
    ("alpha", "least", "most"),
    [(0.02, 0.995, 1.003), (0.3, 0, 1.003), (Widths(0.02, 0.05), 0.985, 1.015)],
)
def test_white_below_a_clear_coat_reflects_what_enters(alpha, least, most):
    """With the interface's reflection, all light that falls on a smooth clear coat.

    Rough interfaces lose what their facets reflect or transmit more than once.
    """
    two = isinstance(alpha, Widths)
    clear, white = one(alpha, 1.5, 0.0, 0.0, 0.0), lambertian(1.0, *[np.ones(1)] * two)
    lobe = lobes.of_coat(clear.alpha, clear.eta)

    def f(wi, wo):
        return coated_f(white, clear, wi, wo) + lobes.f(lobe, wi, wo)[:, None]

    azimuths = 4 if two else 16
    wi = in_plane([0, 37, 53]).astype(float)
    albedo = directional_albedos(f, wi, anisotropic=two, azimuths=azimuths)
    assert least < albedo.min() and albedo.max() < most
