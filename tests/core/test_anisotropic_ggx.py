"""Anisotropic GGX: its definition, the white furnace, sampling, symmetries, and equal widths."""

from types import ModuleType

import numpy as np
import pytest

from urushi.checks import Widths
from urushi.core import microfacet, mixture

#: Widths along x and y: both orders, ratios up to 8, and narrow ones.
WIDTHS = [(0.5, 0.1), (0.1, 0.8), (1.0, 0.7), (0.02, 0.01)]


def directions(count: int, seed: int) -> np.ndarray:
    """Unit vectors (3, count) above the horizon, uniform."""
    z, turn = np.random.default_rng(seed).uniform(0.02, 1, (2, count))
    r, phi = np.sqrt(1 - z * z), 2 * np.pi * turn
    return np.stack([r * np.cos(phi), r * np.sin(phi), z]).astype(np.float32)


def direction(theta: float, phi: float) -> np.ndarray:
    """A unit vector (3, 1)."""
    sin = np.sin(theta)
    return np.array([[sin * np.cos(phi)], [sin * np.sin(phi)], [np.cos(theta)]], np.float32)


def widths(jit: ModuleType, pair: tuple[float, float]) -> Widths:
    return Widths(*pair).map(jit.Float)


def normals(pair: tuple[float, float], count: int = 1024) -> tuple[np.ndarray, np.ndarray]:
    """Facet normals (3, n) and solid angles (n,), fine where GGX of these widths is."""
    # Slopes are those of the width 1, stretched by the widths. For the width 1, the cumulative
    # distribution of D cos is u = tan^2 / (1 + tan^2). Squaring v = sqrt(1 - u) removes the root
    # with which visible facets approach the horizon.
    v = 1 - (np.arange(count) + 0.5) / count
    tan = np.sqrt(1 - v**2) / v
    area = v**-3 / count  # tan d(tan), as d(tan^2) / 2 with tan^2 = v^-2 - 1
    phi = 2 * np.pi * (np.arange(512) + 0.5) / 512
    x = np.outer(tan, pair[0] * np.cos(phi)).ravel()
    y = np.outer(tan, pair[1] * np.sin(phi)).ravel()
    slopes = np.repeat(area * pair[0] * pair[1] * 2 * np.pi / 512, 512)
    cos = 1 / np.sqrt(1 + x * x + y * y)
    # The solid angle of an area of slopes is its area times cos^3.
    return np.stack([x * cos, y * cos, cos]).astype(np.float32), slopes * cos**3


@pytest.mark.parametrize("pair", WIDTHS)
def test_distribution_and_masking_are_those_of_the_definition(jit: ModuleType, pair) -> None:
    """Heitz 2014, eqs. 43, 72, 80 and 85, in angles and double precision."""
    w = directions(2000, 1)
    x, y, z = w.astype(np.float64)
    cos2_phi, sin2_phi = (c * c / (x * x + y * y) for c in (x, y))
    tan2 = (x * x + y * y) / z**2
    slope = tan2 * (cos2_phi / pair[0] ** 2 + sin2_phi / pair[1] ** 2)
    d = 1 / (np.pi * pair[0] * pair[1] * z**4 * (1 + slope) ** 2)
    towards = np.sqrt(cos2_phi * pair[0] ** 2 + sin2_phi * pair[1] ** 2)
    masking = 1 / (1 + (np.sqrt(1 + towards**2 * tan2) - 1) / 2)
    alpha = widths(jit, pair)
    found = microfacet.ggx_d(jit.Array3f(w), alpha).numpy()
    np.testing.assert_allclose(found, d, rtol=1e-5)
    np.testing.assert_allclose(microfacet.smith_g1(jit.Array3f(w), alpha).numpy(), masking, 1e-5)


@pytest.mark.parametrize("pair", WIDTHS)
def test_projected_facets_cover_the_surface_once(jit: ModuleType, pair) -> None:
    m, area = normals(pair)
    d = microfacet.ggx_d(jit.Array3f(m), widths(jit, pair)).numpy()
    assert np.sum(d * m[2] * area) == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("phi", [0.0, 0.5, np.pi / 2])
@pytest.mark.parametrize("theta", [0.0, 0.7, 1.3, 1.55])
@pytest.mark.parametrize("pair", WIDTHS)
def test_visible_facets_cover_the_view_once(jit: ModuleType, pair, theta, phi) -> None:
    # Smith's condition: the integral of G1(w) max(w.m, 0) D(m) is w.z, the weak white furnace.
    m, area = normals(pair)
    w = jit.Array3f(np.broadcast_to(direction(theta, phi), m.shape).copy())
    density = microfacet.visible_normal_pdf(w, jit.Array3f(m), widths(jit, pair)).numpy()
    assert np.sum(density * area) == pytest.approx(1, abs=2e-3)


@pytest.mark.parametrize("phi", [0.0, 0.5, np.pi / 2])
@pytest.mark.parametrize("theta", [0.0, 0.8, 1.5])
@pytest.mark.parametrize("pair", [(0.6, 0.2), (0.25, 1.0)])
def test_normals_are_sampled_as_visible(jit: ModuleType, sphere_test, pair, theta, phi) -> None:
    u1, u2 = np.random.default_rng(1).random((2, 200_000), dtype=np.float32)
    w, alpha = jit.Array3f(direction(theta, phi)), widths(jit, pair)
    m = microfacet.sample_visible_normal(w, alpha, jit.Float(u1), jit.Float(u2))

    def pdf(v: np.ndarray) -> np.ndarray:
        points = jit.Array3f(np.ascontiguousarray(v.T))
        return microfacet.visible_normal_pdf(w, points, alpha).numpy()

    assert sphere_test(m.numpy().T, pdf) > 1e-4  # the smallest of 18


@pytest.mark.parametrize("phi", [0.0, 0.5, np.pi / 2])
@pytest.mark.parametrize("theta", [0.1, 0.8, 1.5])
def test_proposals_sample_their_density(jit: ModuleType, sphere_test, theta, phi) -> None:
    u = np.random.default_rng(2).random((3, 200_000), dtype=np.float32)
    alphas = [widths(jit, pair) for pair in ((0.5, 0.15), (0.3, 0.9))]
    proposal = mixture.Mixture([jit.Float(share) for share in (0.5, 0.3, 0.2)], alphas)
    wi = jit.Array3f(direction(theta, phi))
    wo = proposal.sample(wi, jit.Float(u[0]), [jit.Float(x) for x in u[1:]])

    def pdf(v: np.ndarray) -> np.ndarray:
        return proposal.pdf(wi, jit.Array3f(np.ascontiguousarray(v.T))).numpy()

    assert sphere_test(wo.numpy().T, pdf) > 1e-4


@pytest.mark.parametrize("pair", WIDTHS)
def test_the_lobe_is_reciprocal_and_has_the_symmetries_of_its_tangent(jit, pair) -> None:
    """Half a turn and mirroring in the tangent or across it: the same bits, as only squares enter.

    A quarter turn exchanges the widths; it reorders a sum of two numbers, which is exact.
    """
    wi, wo = directions(1000, 3), directions(1000, 4)
    alpha = widths(jit, pair)

    def lobe(a: np.ndarray, b: np.ndarray, alpha: Widths = alpha) -> np.ndarray:
        return microfacet.reflection_lobe(jit.Array3f(a), jit.Array3f(b), alpha)[0].numpy()

    f = lobe(wi, wo)
    np.testing.assert_allclose(lobe(wo, wi), f, rtol=1e-6)
    for signs in ([-1, -1, 1], [1, -1, 1], [-1, 1, 1]):
        sign = np.array(signs, np.float32)[:, None]
        np.testing.assert_array_equal(lobe(sign * wi, sign * wo), f)

    def quarter_turn(w: np.ndarray) -> np.ndarray:
        return np.stack([-w[1], w[0], w[2]])

    turned = lobe(quarter_turn(wi), quarter_turn(wo), widths(jit, pair[::-1]))
    np.testing.assert_allclose(turned, f, rtol=1e-5)
    # A turn by any other angle shows the anisotropy.
    assert np.mean(np.abs(lobe(quarter_turn(wi), quarter_turn(wo)) / f - 1) > 0.1) > 0.3


@pytest.mark.parametrize("alpha", [0.01, 0.1, 0.37, 1.0])
def test_equal_widths_are_one_width(jit: ModuleType, alpha: float) -> None:
    w, m = jit.Array3f(directions(1000, 5)), jit.Array3f(directions(1000, 6))
    u1, u2 = (jit.Float(x) for x in np.random.default_rng(7).random((2, 1000), dtype=np.float32))
    functions = [
        lambda alpha: microfacet.ggx_d(m, alpha),
        lambda alpha: microfacet.smith_g1(w, alpha),
        lambda alpha: microfacet.visible_normal_pdf(w, m, alpha),
        lambda alpha: microfacet.sample_visible_normal(w, alpha, u1, u2),
        lambda alpha: microfacet.reflection_lobe(w, m, alpha)[0],
        lambda alpha: mixture.reflection_pdf(alpha, w, m),
        lambda alpha: mixture.sample_reflection(alpha, w, u1, u2),
    ]
    for function in functions:
        one, two = (function(a).numpy() for a in (jit.Float(alpha), widths(jit, (alpha, alpha))))
        # Sums are in another order, and CUDA's u / u may differ from 1 by a rounding.
        np.testing.assert_allclose(one, two, rtol=2e-5, atol=1e-6)
