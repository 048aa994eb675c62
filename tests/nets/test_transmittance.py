"""The transmittance of the topmost interface, which gives the rest of f its edges."""

import numpy as np
import pytest
from tests.directions import at_cosines

from urushi.checks import Widths
from urushi.core import albedos, fresnel
from urushi.core.direction_sets import cosine_pairs
from urushi.core.namespace import NUMPY
from urushi.nets import lobe as lobes
from urushi.nets import transmittance
from urushi.nets.weights import anisotropic_model, default_model

#: Cosines of directions.
COSINES = np.linspace(0.01, 1, 200)


def directions(azimuth=0.3):
    sine = np.sqrt(1 - COSINES**2)
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), COSINES], axis=-1)


def of_coat(alpha, eta):
    return lobes.of_coat(np.asarray(alpha, np.float64), np.asarray(eta, np.float64))


@pytest.mark.parametrize(
    "lobe",
    [
        (0.1, 0, 0, 1, 1.5, 0),
        (0.1, 0, 0, 1, 1.0, 0),
        (0.2, 0, 0, 1, 0.2, 3.5),  # a conductor
        (0.2, 0.9, 1, 0, 0.6, 0),  # Schlick's term
    ],
)
def test_other_lobes_have_none(lobe):
    assert not transmittance.has_edges(np.array(lobe))
    assert (transmittance.of_lobe(np.array(lobe, float), directions()) == 1).all()


@pytest.mark.parametrize("eta", [0.5, 0.67, 0.9])
def test_a_smooth_interface_has_that_of_fresnel(eta):
    """Within the reach of facets of width .01, except beside the critical angle."""
    found = transmittance.of_lobe(of_coat(0.01, eta), directions())
    expected = 1 - fresnel.dielectric(COSINES, eta, NUMPY)[0]
    beyond = COSINES - np.sqrt(1 - eta * eta)
    np.testing.assert_allclose(found[beyond > 0.05], expected[beyond > 0.05], rtol=0.02)
    assert found[beyond < -0.05].max() < 0.02


@pytest.mark.parametrize("alpha", [0.01, 0.1, 0.3])
def test_it_follows_the_light_that_facets_transmit(alpha):
    """An independent quadrature over visible facets; a smooth factor is left to codes."""
    tables, roughness = albedos.tables(), albedos.nodes()[0]
    row = np.abs(roughness - alpha).argmin()
    for eta, passed in zip(albedos.indexnodes(), tables.passed[:, row], strict=True):
        if not 0.5 < eta < 0.99:
            continue
        w = at_cosines(albedos.nodes(float(eta))[1]).astype(float)
        found = transmittance.of_lobe(of_coat(roughness[row], eta), w)
        assert np.abs(found - passed).max() < 0.25
        assert np.abs(found - passed).mean() < 0.12


def test_single_precision_keeps_its_digits():
    alpha, eta = (x.ravel()[:, None] for x in np.meshgrid([0.01, 0.1, 0.5, 1], [0.5, 0.8, 0.999]))
    exact = transmittance.of_lobe(of_coat(alpha, eta), directions())
    lobe = of_coat(alpha, eta).astype(np.float32)
    found = transmittance.of_lobe(lobe, directions().astype(np.float32))
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, exact, rtol=2e-3)


@pytest.mark.parametrize(
    ("alpha", "azimuth", "same"),
    [(Widths(0.2, 0.2), 0.3, 0.2), (Widths(0.02, 0.2), 0, 0.02), (Widths(0.2, 0.02), 0, 0.2)],
)
def test_the_width_along_the_direction_counts(alpha, azimuth, same):
    w = transmittance.components(directions(azimuth))
    one, two = (transmittance.transmittance(x, (None, 0.7, None), w, NUMPY) for x in (same, alpha))
    np.testing.assert_allclose(two, one, rtol=1e-9)


@pytest.mark.parametrize(
    ("model", "alpha"),
    [(default_model, np.float64(0.1)), (anisotropic_model, Widths(*np.array([0.1, 0.2])))],
)
def test_a_lambertian_below_such_an_interface_is_exact(model, alpha):
    """g is constant, as the first function of the basis is."""
    model, g, lobe = model(), 0.2, lobes.of_coat(alpha, np.float64(0.7))

    def f(wi, wo):
        return lobes.f(lobe, wi, wo) + g * transmittance.both_ways(lobe, wi, wo)

    code = model.networks.encode(f(*model.networks.pairs()), lobe)
    wi, wo = cosine_pairs(np.random.default_rng(0), 500)
    found = model.networks.f(code, wi, wo)
    np.testing.assert_allclose(found, f(wi, wo), rtol=5e-3)
    assert np.array_equal(found, model.networks.f(code, wo, wi))
