"""The mapping functions against closed forms, quadratures and the walk."""

import numpy as np
import pytest

import urushi
from urushi.core import albedos, fresnel
from urushi.core.namespace import NUMPY
from urushi.openpbr_surface import formulas
from urushi.walk.simulate import albedo

COSINES, WEIGHTS = np.polynomial.legendre.leggauss(48)
COSINES, WEIGHTS = 0.5 * (COSINES + 1), 0.5 * WEIGHTS
NORMAL = np.array([[0.0, 0.0, 1.0]])


def mean(values):
    """2 times the integral of values at `COSINES` times the cosine."""
    return (2 * WEIGHTS * COSINES * values).sum(axis=-1)


def test_the_base_has_the_ratio_of_the_indices():
    assert formulas.base_index(1.5, 1.6, 0.0, 1.0) == pytest.approx(1.5)
    assert formulas.base_index(1.5, 1.6, 1.0, 1.0) == pytest.approx(1.5 / 1.6)
    assert formulas.base_index(1.5, 1.6, 0.5, 1.0) == pytest.approx(0.5 * (1.5 + 1.5 / 1.6))
    assert formulas.base_index(1.5, 1.6, 0.3, 0.0) == 1
    # The specification allows indices down to zero: the base has a finite index below any coat.
    for coat in (0.0, 0.5, 1.0):
        assert formulas.relative_index(0.0, 0.0, coat) > 0
        assert formulas.base_index(1.5, 0.0, coat, 1.0) > 1.49


def test_interface_indices_are_in_their_range():
    assert formulas.interface_index([1.0, 0.9999, 1.001, 1.5, 9, 0.1]).tolist() == pytest.approx(
        [1, 1, 1.001, 1.5, 3, 0.5]
    )


@pytest.mark.parametrize("sigma", [0.0, 0.3, 1.0])
def test_eon_albedos_are_its_integrals(sigma):
    azimuth = (np.arange(256) + 0.5) / 256 * 2 * np.pi
    for color in (1.0, 0.4):
        for cosine in (0.2, 0.7, 1.0):
            sine = (1 - cosine**2) ** 0.5 * np.sqrt(1 - COSINES**2)
            between = cosine * COSINES[:, None] + sine[:, None] * np.cos(azimuth)
            f = formulas.eon(cosine, COSINES[:, None], between, color, sigma).mean(axis=1)
            # The BRDF has kinks, which the quadrature resolves to a few parts in ten thousand.
            assert np.pi * mean(f) == pytest.approx(
                formulas.eon_albedo(cosine, color, sigma), rel=1e-3
            )
        assert mean(formulas.eon_albedo(COSINES, color, sigma)) == pytest.approx(
            formulas.eon_mean_albedo(color, sigma), rel=1e-4
        )
    assert formulas.eon_albedo(0.3, 1.0, sigma) == pytest.approx(1)
    assert formulas.eon(0.5, 0.5, 0.1, 0.4, 0.0) == pytest.approx(0.4 / np.pi)


@pytest.mark.parametrize("eta", [1.3, 1.5, 0.9375])
def test_a_smooth_glossy_base_keeps_its_colour_in_the_walk(eta):
    """The specification's constraint: E_diffuse = (1 - E_spec) C at normal incidence.

    A width of 0.02 loses nothing that matters, so that the walk conserves energy.
    """
    color = np.array([0.2, 0.5, 0.9])
    # The mean of a curve with a kink, where total reflection begins: a fine quadrature.
    fine = (np.arange(20000) + 0.5) / 20000
    passed = 2 * (fine * (1 - fresnel.dielectric(fine, eta, NUMPY)[0])).mean()
    rho = formulas.slab_albedo(color, formulas.internal_reflectance(passed, eta))
    stack = urushi.coat(urushi.diffuse(rho), alpha=0.02, eta=eta)
    found, error = albedo(stack, NORMAL, walks=1 << 18)
    spec = ((eta - 1) / (eta + 1)) ** 2
    assert np.all(np.abs(found - (spec + (1 - spec) * color)) < 4 * error + 2e-3)


@pytest.mark.parametrize("eta", [1.001, 1.1, 1.5, 3.0, 10.0, 100.0])
def test_the_mean_fresnel_term_is_the_integral_of_fresnels_equations(eta):
    """Within the fit's 0.04 % of one up to an index of 3, 0.5 % above."""
    cosine = np.sqrt((np.arange(100_000) + 0.5) / 100_000)  # of cosine density
    inside = np.sqrt(1 - (1 - cosine**2) / eta**2)
    s = (cosine - eta * inside) / (cosine + eta * inside)
    p = (eta * cosine - inside) / (eta * cosine + inside)
    integral = np.mean((s * s + p * p) / 2)
    assert abs(formulas.mean_fresnel(eta) - integral) < (4e-4 if eta <= 3 else 5e-3)


@pytest.mark.parametrize(
    ("color", "coat"), [(0.2, 1.0), (0.6, 1.0), (0.95, 1.0), (0.5, 0.8), (0.3, 0.5)]
)
def test_without_darkening_a_smooth_coat_keeps_the_base_albedo(color, coat):
    """B0 over a Lambertian base, whose roughness estimate is one. The paths of light through the
    medium of a coloured coat are estimates, with an error of up to 1 %."""
    eta = 1.6
    internal = formulas.internal(eta, 1.0, 0.0, 0.0)
    boosted = color * formulas.boost(0.0, internal, color, coat)
    assert boosted <= 1
    stack = urushi.coat(urushi.diffuse(boosted), alpha=0.02, eta=eta, color=coat)
    found, error = albedo(stack, NORMAL, walks=1 << 18)
    f0 = ((eta - 1) / (eta + 1)) ** 2
    expected = f0 + (1 - f0) * coat * color
    assert abs(found[0, 0] - expected) < 4 * error[0, 0] + 2e-3 + 0.01 * expected * (coat < 1)
    assert formulas.boost(1.0, internal, color, coat) == 1
    assert formulas.boost(0.0, internal, 0.1, 0.01) > formulas.boost(0.0, internal, 0.1)
    assert formulas.boost(0.5, internal, color, coat) == pytest.approx(0.5 * (1 + boosted / color))


@pytest.mark.parametrize("eta", [0.5, 0.7, 0.95])
def test_total_reflection_of_a_smooth_interface_has_its_edge(eta):
    """Facets of the narrowest width spread the edge over a few hundredths of the cosine."""
    table, edge = albedos.tables(eta).reflected[0, 0], (1 - eta * eta) ** 0.5
    cosine = np.array([edge - 0.03, edge + 0.03])
    at = albedos.cosine_coordinate(cosine, eta)
    found = np.interp(at, np.linspace(0, 1, len(table)), table)
    expected = fresnel.dielectric(cosine, eta, NUMPY)[0]
    assert np.allclose(found, expected, atol=0.03)
