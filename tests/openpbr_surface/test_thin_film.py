"""The reflectance under a thin film, against the transfer matrices of electromagnetic waves."""

import numpy as np
import pytest

from urushi.core import fresnel
from urushi.openpbr_surface import thin_film
from urushi.openpbr_surface.thin_film import Below, Film

COSINES = (1.0, 0.7, 0.2)


def transfer_matrix(wavelength, cosine, film, index):
    """Reflectance of a film over a complex relative index, wavelength and thickness in um.

    Source: Born and Wolf 1999, Principles of optics, section 1.6.
    """
    sine = np.sqrt(1 - cosine**2)
    inside = np.sqrt(1 - (sine / film.eta) ** 2 + 0j)
    below = np.sqrt(1 - (sine / index) ** 2 + 0j)
    phase = 2 * np.pi * film.index * film.thickness * inside / wavelength
    total = 0.0
    for above, middle, last in (
        (cosine, film.eta * inside, index * below),
        (1 / cosine, film.eta / inside, index / below),
    ):
        matrix = [
            [np.cos(phase), -1j * np.sin(phase) / middle],
            [-1j * middle * np.sin(phase), np.cos(phase)],
        ]
        b, c = np.array(matrix) @ np.array([1, last])
        total += 0.5 * abs((above * b - c) / (above * b + c)) ** 2
    return total


@pytest.mark.parametrize(("above", "film"), [(1.0, 1.33), (1.0, 1.4), (1.6, 1.8)])
@pytest.mark.parametrize("index", [1.5, 2 + 3j, 0.2 + 3.4j])
def test_a_wavelength_is_reflected_as_by_transfer_matrices(above, film, index):
    layer, relative = Film(film / above, film, 0.37), complex(index) / above
    below = Below(relative.real, relative.imag)
    for cosine in COSINES:
        for wavelength in (0.45, 0.6):
            found = thin_film.reflectance(
                np.float64(cosine), layer, below, thin_film.wavelength_response(1e3 * wavelength)
            )
            expected = transfer_matrix(wavelength, cosine, layer, relative)
            assert found == pytest.approx(expected, abs=0.005)  # the series ends at `ORDERS`


def test_a_colour_is_the_mean_of_wavelengths_by_the_matching_functions():
    """Y by the fit of Wyman, Sloan and Shirley 2013 to the colour matching function."""
    wavelength = np.linspace(0.38, 0.78, 801)

    def gauss(x, mean, low, high):
        return np.exp(-0.5 * ((x - mean) / np.where(x < mean, low, high)) ** 2)

    y = 0.821 * gauss(wavelength * 1e3, 568.8, 46.9, 40.5)
    y += 0.286 * gauss(wavelength * 1e3, 530.9, 16.3, 31.1)
    layer = Film(1.4, 1.4, 0.3)
    for cosine in COSINES:
        values = [transfer_matrix(x, cosine, layer, 2 + 3j) for x in wavelength]
        found = thin_film.reflectance(
            np.float64(cosine), layer, Below(2.0, 3.0), thin_film.LUMINANCE
        )
        assert found == pytest.approx((values * y).sum() / y.sum(), abs=0.02)  # one Gaussian


def test_a_white_metal_under_a_film_reflects_all_light():
    white = thin_film.metal_index(np.float64(1), np.float64(1))
    for response in thin_film.RGB:
        for cosine in COSINES:
            found = thin_film.reflectance(np.float64(cosine), Film(1.4, 1.4, 0.5), white, response)
            assert found == pytest.approx(1, abs=1e-3)


def test_a_film_of_no_thickness_is_not_seen():
    """Its reflectance is that of what is below, of which the film's index is no part."""
    below = Below(np.float64(1.5))
    bare = thin_film.reflectance(
        0.6, Film(1.0, 1.0, 0.5), below, thin_film.wavelength_response(550.0)
    )
    found = thin_film.reflectance(0.6, Film(1.4, 1.4, 0.0), below, thin_film.LUMINANCE)
    assert found == pytest.approx(bare, abs=1e-5)


@pytest.mark.parametrize(("f0", "tint"), [(0.9, 0.95), (0.5, 0.7), (0.98, 1.0), (0.3, 0.9)])
def test_a_metals_index_has_its_reflectance_at_both_ends(f0, tint):
    below = thin_film.metal_index(np.float64(f0), np.float64(tint))
    for cosine, tolerance in ((1.0, 1e-6), (fresnel.EDGE_COSINE, 0.02)):
        found = thin_film.reflectance(cosine, Film(1.0, 1.0, 0.0), below, thin_film.LUMINANCE)
        assert found == pytest.approx(fresnel.f82(cosine, f0, tint), abs=tolerance)
