"""Coats of one width or two over brushed metals and others, against the walk and closed forms."""

import numpy as np
import pytest

import urushi
from urushi.checks import CoatParameters, Widths
from urushi.core import direction_sets
from urushi.core.error_metrics import stack_error
from urushi.core.quadrature import half_vector_rule
from urushi.material import adding, adding_quadrant
from urushi.material.coated_anisotropic import HalfVectors, coated_f
from urushi.nets import lobe as lobes
from urushi.walk import conductor, diffuse

BRUSHED = np.float32([0.1, 0.9, 1.0, 0.0, 1.5, 0.0, 0.4])  # of the widths 0.1 and 0.4


def metal(wi, wo):
    return lobes.f(BRUSHED, wi, wo)[:, None]


def lambertian(wi, wo):
    return np.full((len(wi), 1), 0.7 / np.pi, np.float32)


def parameters(alpha, eta, albedo=0.0, sigma_t=0.0, g=0.0) -> CoatParameters:
    return CoatParameters(alpha, *(np.float64(x) for x in (eta, albedo, sigma_t, g)))


@pytest.mark.parametrize(
    ("bottom", "coat"),
    [
        ("brushed", (0.05, 1.5)),
        ("brushed", (Widths(0.3, 0.1), 1.5)),
        ("brushed", (0.2, 1.0, 0.9, 1.0, 0.3)),
        ("brushed", (0.2, 0.7)),
        ("lambertian", (Widths(0.1, 0.4), 1.5, 0.9, 1.0)),
        pytest.param("brushed", (0.05, 1.2), marks=pytest.mark.slow),
        pytest.param("brushed", (0.5, 2.0, 0.0, 0.5), marks=pytest.mark.slow),
        pytest.param("brushed", (0.2, 1.5, 0.9, 0.5), marks=pytest.mark.slow),
    ],
)
def test_as_the_walk(bottom, coat):
    """E of 0.3 to 1.5 %; the walk's own noise is 1 % over metals."""
    values = parameters(*coat)
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(0), 300, lowest_cosine=0.02)
    below = {"brushed": metal, "lambertian": lambertian}[bottom]
    f = coated_f(below, values, wi, wo)[:, 0]
    lobe = lobes.of_coat(
        Widths(*map(np.float64, (values.alpha.u, values.alpha.v)))
        if isinstance(values.alpha, Widths)
        else np.float64(values.alpha),
        values.eta,
    )
    width = (
        {"alpha_u": values.alpha.u, "alpha_v": values.alpha.v}
        if isinstance(values.alpha, Widths)
        else {"alpha": values.alpha}
    )
    stack = urushi.coat(
        conductor(alpha_u=0.1, alpha_v=0.4, r0=0.9) if bottom == "brushed" else diffuse(0.7),
        **width,
        **{name: float(x) for name, x in values._asdict().items() if name != "alpha"},
    )
    walk, _ = urushi.simulate(stack, wi, wo, walks=1 << 14, progress=False)
    top = lobes.f(lobe, wi, wo)
    assert stack_error(f + top, walk[:, 0], wi[:, 2], wo[:, 2]) < 0.03


def test_reciprocal_and_symmetric_about_both_planes():
    """Up to the error of the sums: the points of wi are not those of wo."""
    coat = parameters(Widths(0.1, 0.3), 1.5, 0.5, 0.5)
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(1), 200, lowest_cosine=0.1)
    f = coated_f(metal, coat, wi, wo)
    others = [(wo, wi)] + [(wi * sign, wo * sign) for sign in np.float32([[1, -1, 1], [-1, 1, 1]])]
    for pair in others:
        assert stack_error(coated_f(metal, coat, *pair)[:, 0], f[:, 0], wi[:, 2], wo[:, 2]) < 0.02


def test_smooth_coats_over_white_lose_no_light():
    """All light that enters leaves again; facets of 0.05 lose little."""
    coat, wi = parameters(Widths(0.02, 0.05), 1.5), np.array([[0, 0, 1.0], [0.6, 0, 0.8]])
    wo, weight = half_vector_rule(wi, anisotropic=True, azimuths=4)
    pairs = np.repeat(wi, weight.shape[1], axis=0).astype(np.float32), wo.reshape(-1, 3)
    pairs = pairs[0], pairs[1].astype(np.float32)
    f = coated_f(lambda wi, wo: lambertian(wi, wo) / 0.7, coat, *pairs)[:, 0]
    f = f + lobes.f(lobes.of_coat(Widths(np.float64(0.02), np.float64(0.05)), coat.eta), *pairs)
    albedo = (f.reshape(weight.shape) * weight * wo[..., 2]).sum(axis=1)
    np.testing.assert_allclose(albedo, 1, atol=0.015)


def test_colours_are_those_of_grey_coats():
    coat = CoatParameters(
        *np.array([[0.2, 0.2, 0.3], [1.5] * 3, [0, 0.5, 0], [0, 1, 0.5], [0] * 3])
    )
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(2), 50, lowest_cosine=0.1)
    together = coated_f(metal, coat, wi, wo)
    for channel in range(3):
        alone = coated_f(metal, CoatParameters(*(p[channel] for p in coat)), wi, wo)
        np.testing.assert_allclose(together[:, channel], alone[:, 0], rtol=1e-5)


def test_the_quadrant_agrees_with_the_modes_of_an_isotropic_bottom():
    """Light that is turned back below a coat, on two grids by two methods."""
    lobe = np.float32([0.3, 0.9, 1.0, 0.0, 1.5, 0.0])
    medium = 0.9, 1.0, 0.3

    def bottom(wi, wo):
        return lobes.f(lobe, wi, wo)[:, None]

    modes = adding.seen_inside(
        adding.bottom_modes(bottom)[0], adding.interface_modes(0.2, 1.5), [medium]
    )[0]
    values = adding_quadrant.seen_inside(
        adding_quadrant.bottom_parts(bottom)[0], adding_quadrant.interface_parts(0.2, 1.5), medium
    )
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(3), 500, lowest_cosine=0.1)
    expected = adding.grid().interpolated(modes[..., None], wi, wo)[:, 0]
    found = adding_quadrant.Table(values[..., None]).at(wi, wo)[:, 0]
    assert stack_error(found, expected, wi[:, 2], wo[:, 2]) < 0.01


def test_cells_are_where_their_directions_are():
    w = adding_quadrant.directions()
    side = (np.arange(adding_quadrant.CELLS) + 0.5) / adding_quadrant.CELLS
    expected = np.meshgrid(side, side, indexing="ij")
    for place, coordinate in zip(adding_quadrant.places(w), expected, strict=True):
        np.testing.assert_allclose(place, coordinate.ravel(), atol=1e-5)
    assert 4 * adding_quadrant.weights().sum() == pytest.approx(np.pi, rel=2e-3)  # midpoints


def test_half_vectors_are_drawn_by_their_density():
    """The mean of 1 / density over half vectors of a region is its solid angle."""
    peak = HalfVectors.of(metal)
    u = np.random.default_rng(4).random((1 << 16, 2))
    x, y, z = peak.draw(u)
    inside = (np.abs(x / z) < 0.2) & (np.abs(y / z) < 0.5)
    found = (inside / peak.density_at(x, y, z)).mean()
    grid = (np.arange(400) + 0.5) / 400
    a, b = np.meshgrid(0.4 * grid - 0.2, grid - 0.5)
    expected = 0.4 * (1 / (1 + a * a + b * b) ** 1.5).mean()
    assert found == pytest.approx(expected, rel=0.03)
