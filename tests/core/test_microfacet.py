"""GGX and Smith: normalisations, the weak white furnace, sampling, reciprocity."""

from types import ModuleType

import numpy as np
import pytest

from urushi.core import microfacet
from urushi.core.directions import reflect

ALPHAS = [0.01, 0.1, 0.5, 1.0]


def direction(theta: float, phi: float = 0.4) -> np.ndarray:
    """A unit vector (3, 1)."""
    sin = np.sin(theta)
    return np.array([[sin * np.cos(phi)], [sin * np.sin(phi)], [np.cos(theta)]], np.float32)


def normals(alpha: float, count: int = 1024) -> tuple[np.ndarray, np.ndarray]:
    """Facet normals (3, n) and solid angles (n,), fine where GGX of that width is."""
    # D cos falls as the inverse square of 1 + tan^2 / alpha^2: u is its cumulative distribution.
    # Squaring v removes the root with which visible facets approach the horizon.
    v = 1 - (np.arange(count) + 0.5) / count
    u, du = 1 - v**2, 2 * v / count
    tan2 = alpha**2 * u / v**2
    cos = 1 / np.sqrt(1 + tan2)
    solid = 0.5 * cos**3 * alpha**2 / v**4 * du  # cos = (1 + tan2)^-1/2, differentiated by u
    phi = 2 * np.pi * (np.arange(256) + 0.5) / 256
    sin = np.sqrt(tan2) * cos
    m = np.stack(
        [np.outer(sin, np.cos(phi)), np.outer(sin, np.sin(phi)), np.outer(cos, np.ones_like(phi))]
    )
    area = np.outer(solid, np.full_like(phi, 2 * np.pi / len(phi)))
    return m.reshape(3, -1).astype(np.float32), area.ravel()


@pytest.mark.parametrize("alpha", ALPHAS)
def test_projected_facets_cover_the_surface_once(jit: ModuleType, alpha: float) -> None:
    m, area = normals(alpha)
    d = microfacet.ggx_d(jit.Array3f(m), jit.Float(alpha)).numpy()
    assert np.sum(d * m[2] * area) == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("theta", [0.0, 0.7, 1.3, 1.55])
@pytest.mark.parametrize("alpha", ALPHAS)
def test_visible_facets_cover_the_view_once(jit: ModuleType, alpha: float, theta: float) -> None:
    # Smith's condition: the integral of G1(w) max(w.m, 0) D(m) is w.z, the weak white furnace.
    m, area = normals(alpha)
    w = jit.Array3f(np.broadcast_to(direction(theta), m.shape).copy())
    density = microfacet.visible_normal_pdf(w, jit.Array3f(m), jit.Float(alpha)).numpy()
    assert np.sum(density * area) == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("theta", [0.0, 0.8, 1.5])
@pytest.mark.parametrize("alpha", [0.25, 0.5, 1.0])
def test_normals_are_sampled_as_visible(
    jit: ModuleType, sphere_test, alpha: float, theta: float
) -> None:
    u1, u2 = np.random.default_rng(1).random((2, 200_000), dtype=np.float32)
    w = jit.Array3f(direction(theta))
    m = microfacet.sample_visible_normal(w, jit.Float(alpha), jit.Float(u1), jit.Float(u2))

    def pdf(v: np.ndarray) -> np.ndarray:
        points = jit.Array3f(np.ascontiguousarray(v.T))
        return microfacet.visible_normal_pdf(w, points, jit.Float(alpha)).numpy()

    # A true density fails for one seed in a hundred thousand; the smallest of 9 values is tested.
    assert sphere_test(m.numpy().T, pdf) > 1e-4


@pytest.mark.parametrize("alpha", [0.01, 0.03])
def test_slopes_of_narrow_lobes_follow_their_distribution(jit: ModuleType, alpha: float) -> None:
    # From straight above visible normals have the density D cos, whose cumulative distribution in
    # tan^2 / alpha^2 = t is t / (1 + t): Kolmogorov's test, where cells would be too coarse.
    stats = pytest.importorskip("scipy.stats")
    u1, u2 = np.random.default_rng(2).random((2, 100_000), dtype=np.float32)
    w = jit.Array3f(direction(0.0))
    m = microfacet.sample_visible_normal(w, jit.Float(alpha), jit.Float(u1), jit.Float(u2)).numpy()
    t = (m[0] ** 2 + m[1] ** 2) / m[2] ** 2 / alpha**2
    assert stats.kstest(t, lambda x: x / (1 + x)).pvalue > 1e-3


def test_sampled_normals_face_the_view(jit: ModuleType) -> None:
    u1, u2 = np.random.default_rng(3).random((2, 100_000), dtype=np.float32)
    for theta in (0.0, 1.0, 1.57):
        for alpha in ALPHAS:
            w = jit.Array3f(direction(theta))
            m = microfacet.sample_visible_normal(w, jit.Float(alpha), jit.Float(u1), jit.Float(u2))
            m = m.numpy()
            assert np.all(m[2] >= 0)
            assert np.sum(m * direction(theta), axis=0).min() > -1e-6
            np.testing.assert_allclose(np.linalg.norm(m, axis=0), 1, atol=1e-6)


def test_smith_masking_is_the_same_on_both_sides_and_falls_towards_grazing(jit: ModuleType) -> None:
    theta = np.linspace(0, 1.57, 200)
    w = np.stack([np.sin(theta), 0 * theta, np.cos(theta)]).astype(np.float32)
    for alpha in ALPHAS:
        above = microfacet.smith_g1(jit.Array3f(w), jit.Float(alpha)).numpy()
        below = microfacet.smith_g1(jit.Array3f(-w), jit.Float(alpha)).numpy()
        assert np.array_equal(above, below)
        assert above[0] == 1
        assert np.all((above >= 0) & (above <= 1))
        assert np.all(np.diff(above) <= 1e-6)


def test_reflection_lobe_is_reciprocal_and_dark_below_the_horizon(jit: ModuleType) -> None:
    rng = np.random.default_rng(4)
    a, b = rng.normal(size=(2, 3, 1000)).astype(np.float32)
    a, b = a / np.linalg.norm(a, axis=0), b / np.linalg.norm(b, axis=0)
    for alpha in ALPHAS:
        there = microfacet.reflection_lobe(jit.Array3f(a), jit.Array3f(b), jit.Float(alpha))[0]
        back = microfacet.reflection_lobe(jit.Array3f(b), jit.Array3f(a), jit.Float(alpha))[0]
        np.testing.assert_allclose(there.numpy(), back.numpy(), rtol=1e-6)
        dark = (a[2] <= 0) | (b[2] <= 0)
        assert np.array_equal(there.numpy() == 0, dark)


@pytest.mark.parametrize("alpha", [0.1, 0.5, 1.0])
def test_reflected_energy_is_the_masking_of_what_is_sampled(jit: ModuleType, alpha: float) -> None:
    # f cos / pdf of a reflected visible normal is G1(wo): both ways to the albedo must agree.
    u1, u2 = np.random.default_rng(5).random((2, 400_000), dtype=np.float32)
    wi, a = jit.Array3f(direction(0.9)), jit.Float(alpha)
    wo = reflect(wi, microfacet.sample_visible_normal(wi, a, jit.Float(u1), jit.Float(u2)))
    g1 = microfacet.smith_g1(wo, a).numpy() * (wo.z.numpy() > 0)
    grid = (np.arange(512) + 0.5) / 512
    z, phi = (x.ravel() for x in np.meshgrid(grid, 2 * np.pi * grid))
    r = np.sqrt(1 - z * z)
    points = np.stack([r * np.cos(phi), r * np.sin(phi), z]).astype(np.float32)
    lobe = microfacet.reflection_lobe(wi, jit.Array3f(points), a)[0].numpy()
    albedo = 2 * np.pi * np.mean(lobe * z)
    assert albedo <= 1
    # standard error of the mean over samples, and the grid's own error
    assert g1.mean() == pytest.approx(albedo, abs=5 * float(g1.std()) / len(u1) ** 0.5 + 1e-3)
