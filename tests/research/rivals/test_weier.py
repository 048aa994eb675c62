"""The operators of Weier and Belcour 2020 against the isotropic ones, closed forms and the walk."""

import drjit as dr
import numpy as np
import pytest
from research.rivals import belcour, belcour_tables, weier
from research.rivals.belcour_bottoms import Bottom

from urushi.checks import CoatParameters, Widths
from urushi.core import error_metrics, fresnel, microfacet
from urushi.core.direction_sets import cosine_pairs
from urushi.core.directions import reflect
from urushi.errors import ParameterError
from urushi.walk import analytic, coat, conductor, dielectric, diffuse, simulate
from urushi.walk.bottoms import KINDS
from urushi.walk.monte_carlo import backend
from urushi.walk.table import StackTable, from_stack

#: A stack of three interfaces of two widths, with media.
METAL = conductor(alpha_u=0.1, alpha_v=0.4, r0=0.8)
LOWER = coat(METAL, alpha_u=0.5, alpha_v=0.2, eta=1.3, albedo=0.5, sigma_t=0.4, g=0.3)
BRUSHED = coat(LOWER, alpha_u=0.05, alpha_v=0.3, eta=1.5, albedo=0.9, sigma_t=0.3, g=0.8)


def lanes(values) -> object:
    return backend().Float(np.float32(values))


def vectors(w) -> object:
    return backend().Array3f(np.ascontiguousarray(np.float32(w).T))


def bare(kind: str, **bottom: float) -> StackTable:
    """A table of one surface without coats."""
    empty = np.zeros((1, 0))
    columns = {name: np.float32([value]) for name, value in bottom.items()}
    return StackTable(empty, empty, empty, empty, empty, kind, columns)


BOTTOMS = {
    "schlick": conductor(0.2, r0=0.9),
    "complex": conductor(0.4, eta=0.2, k=3.9),
    "dielectric": dielectric(0.3, 1.7),
    "diffuse": diffuse(0.5),
}


@pytest.mark.parametrize("eta", [0.7, 1.3])
@pytest.mark.parametrize("name", BOTTOMS)
def test_equal_widths_are_the_isotropic_model(name: str, eta: float) -> None:
    # The same operations on both axes: only the root of a square rounds otherwise.
    wi, wo = cosine_pairs(np.random.default_rng(0), 500)
    stack = coat(coat(BOTTOMS[name], 0.3, eta, 0.5, 0.4, 0.3), 0.05, 1.5, 0.9, 0.7, 0.8)
    np.testing.assert_allclose(weier.f(stack, wi, wo), belcour.f(stack, wi, wo), rtol=1e-5)


def test_a_bare_mirror_is_its_lobe() -> None:
    wi, wo = cosine_pairs(np.random.default_rng(2), 500)
    table = bare("conductor_anisotropic", alpha_u=0.1, alpha_v=0.4, r0=1.0)
    exact = analytic.f(conductor(alpha_u=0.1, alpha_v=0.4, r0=1.0), wi, wo)[:, 0]
    found = weier.rows(table, np.zeros(len(wi), np.uint32), wi, wo)
    # Widths go through their variance and back, in single precision.
    np.testing.assert_allclose(found, exact, rtol=1e-4)


@pytest.mark.parametrize("azimuth", [0.0, 0.6, np.pi / 2])
def test_a_bare_metal_has_its_lobe_and_its_albedo(azimuth: float) -> None:
    # Schlick's term varies over the lobe; the model has its mean. 2 %: the width of `seen_width`.
    wo, weights = hemisphere()
    wi = incident(0.4, azimuth, len(wo))
    values = {"alpha_u": 0.2, "alpha_v": 0.5}
    table = bare("conductor_anisotropic", **values, r0=0.5)
    found = weier.rows(table, np.zeros(len(wi), np.uint32), wi, wo)
    lobe = analytic.f(conductor(**values, r0=1.0), wi, wo)[:, 0]
    seen = lobe > 1e-3
    assert np.ptp(found[seen] / lobe[seen]) < 1e-3
    exact = analytic.f(conductor(**values, r0=0.5), wi, wo)[:, 0]
    assert found @ weights == pytest.approx(exact @ weights, rel=0.02)


def test_mirror_images_at_the_tangent_have_equal_values() -> None:
    wi, wo = cosine_pairs(np.random.default_rng(3), 500)
    value = weier.f(BRUSHED, wi, wo)
    for image in ([-1, 1, 1], [1, -1, 1], [-1, -1, 1]):
        image = np.float32(image)
        np.testing.assert_allclose(weier.f(BRUSHED, wi * image, wo * image), value, rtol=1e-5)
    # One direction alone is another pair.
    assert np.max(np.abs(weier.f(BRUSHED, wi * np.float32([-1, 1, 1]), wo) / value - 1)) > 0.1


def test_exchanged_widths_are_a_quarter_turn() -> None:
    wi, wo = cosine_pairs(np.random.default_rng(4), 500)
    stack = coat(METAL, alpha_u=0.4, alpha_v=0.05, eta=1.4)
    turned = coat(conductor(alpha_u=0.4, alpha_v=0.1, r0=0.8), alpha_u=0.05, alpha_v=0.4, eta=1.4)
    np.testing.assert_allclose(
        weier.f(turned, wi[:, [1, 0, 2]], wo[:, [1, 0, 2]]), weier.f(stack, wi, wo), rtol=1e-4
    )


def test_each_axis_is_an_isotropic_model() -> None:
    # With the energies of the width along one axis, that axis is the isotropic model of this width.
    device, cos = backend(), lanes(np.linspace(0.3, 1, 8))
    media = [(lanes(a), lanes(s), lanes(g)) for a, s, g in [(0.9, 0.3, 0.8), (0.5, 0.4, 0.3)]]
    pairs, etas = [(0.05, 0.3), (0.5, 0.2)], (1.5, 1.3)

    def added(widths, alpha, seen):
        coats = [
            CoatParameters(width, lanes(eta), *medium)
            for width, eta, medium in zip(widths, etas, media, strict=True)
        ]
        bottom = Bottom(alpha, lambda cos_i, alpha: 0.5 + 0.3 * alpha)
        return belcour.added_lobes(coats, bottom, cos, seen=seen)

    for axis in range(2):
        both = added(
            [device.Array2f(lanes(u), lanes(v)) for u, v in pairs],
            device.Array2f(lanes(0.1), lanes(0.4)),
            lambda covariance, cos_i, axis=axis: belcour.width(covariance[axis]),
        )
        one = added([lanes(pair[axis]) for pair in pairs], lanes((0.1, 0.4)[axis]), None)
        for lobe, expected in zip(both, one, strict=True):
            np.testing.assert_allclose(lobe.energy.numpy(), expected.energy.numpy(), rtol=1e-5)
            np.testing.assert_allclose(lobe.alpha[axis].numpy(), expected.alpha.numpy(), rtol=1e-5)


@pytest.mark.parametrize("azimuth", [0.0, 0.6, np.pi / 2])
def test_white_furnace(azimuth: float) -> None:
    # Nothing absorbs or scatters: the energies of all lobes are one.
    wi = vectors(np.concatenate([incident(cos, azimuth, 1) for cos in (0.2, 0.5, 0.8, 1.0)]))
    row = backend().UInt32(np.zeros(4, np.uint32))
    for bottom in (conductor(alpha_u=0.1, alpha_v=0.6, r0=1.0), diffuse(1.0)):
        stack = coat(coat(bottom, 0.2, 1.3), alpha_u=0.5, alpha_v=0.1, eta=1.5)
        total = sum(lobe.energy for lobe in weier.lobes(from_stack(stack), row, wi))
        np.testing.assert_allclose(total.numpy(), 1, atol=1e-4)


def hemisphere() -> tuple[np.ndarray, np.ndarray]:
    """Nodes of a midpoint rule over (cosine, azimuth), (N, 3), and their weights with cosine."""
    n = 128
    cos, phi = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(2 * n) + 0.5) * np.pi / n)
    cos, phi = cos.ravel(), phi.ravel()
    sin = np.sqrt(1 - cos * cos)
    return np.stack([sin * np.cos(phi), sin * np.sin(phi), cos], 1), 2 * np.pi * cos / len(cos)


def incident(cos: float, azimuth: float, count: int) -> np.ndarray:
    sin = np.sqrt(1 - cos * cos)
    return np.tile([sin * np.cos(azimuth), sin * np.sin(azimuth), cos], (count, 1))


@pytest.mark.parametrize("azimuth", [0.0, 0.6, np.pi / 2])
@pytest.mark.parametrize("cos", [0.3, 0.9])
def test_a_white_stack_reflects_no_more_than_it_receives(cos: float, azimuth: float) -> None:
    # 1 %: the midpoint rule over lobes of widths of 0.2 or more. Wide lobes lose much by masking.
    wo, weights = hemisphere()
    stack = coat(conductor(alpha_u=0.2, alpha_v=0.6, r0=1.0), alpha_u=0.5, alpha_v=0.2, eta=1.5)
    albedo = weier.f(stack, incident(cos, azimuth, len(wo)), wo)[:, 0] @ weights
    assert 0.4 < albedo <= 1.01


def test_the_seen_width_has_the_mean_reflectance_of_both() -> None:
    # The exact mean over the visible normals of the anisotropic surface, 400 of them.
    places = np.random.default_rng(5).uniform(
        [0.1, 0, -3, -2.1], [1, np.pi / 2, -0.5, 2.1], (500, 4)
    )
    cos, azimuth, u, quotient = places.T
    u, v = np.exp(u), np.clip(np.exp(u + quotient), 0.01, 1)
    sin = np.sqrt(1 - cos * cos)
    wi = vectors(np.stack([sin * np.cos(azimuth), sin * np.sin(azimuth), cos], 1))
    alpha, total, norm = Widths(lanes(u), lanes(v)), lanes(0.0), lanes(1e-12)
    for k in range(400):
        m = microfacet.sample_visible_normal(wi, alpha, (k // 20 + 0.5) / 20, (k % 20 + 0.5) / 20)
        wo = reflect(wi, m)
        weight = dr.select(wo.z > 0, microfacet.smith_g1(wo, alpha), 0)
        total += weight * fresnel.dielectric(dr.clip(dr.dot(wi, m), 0, 1), 1.5)[0]
        norm += weight
    exact = (total / norm).numpy()

    def error(width) -> float:
        """Mean difference of the tabulated mean at a width, relative to the mean reflectance."""
        found = belcour_tables.mean_dielectric(wi.z, width, lanes(1.5)).numpy()
        return np.abs(found - exact).mean() / exact.mean()

    seen = weier.seen_width(backend().Array2f(alpha.u, alpha.v), wi, wi.z)
    assert error(seen) < 0.04
    assert error(dr.sqrt(alpha.u * alpha.v)) > 2 * error(seen)


def test_lacquered_hairlines_are_near_the_walk() -> None:
    # A smooth, clear coat: E is 22 %, and 16 % for a metal of the width 0.3 alone, which is the
    # isotropic model. The geometric mean of the widths in place of both gives 64 %.
    wi, wo = cosine_pairs(np.random.default_rng(6), 200)

    def lacquered(metal):
        return coat(metal, 0.05, 1.5)

    hairlines = lacquered(conductor(alpha_u=0.06, alpha_v=0.3, r0=0.9))
    walked = simulate(hairlines, wi, wo, walks=4096, seed=1)[0][:, 0]

    def error(f) -> float:
        return float(error_metrics.stack_error(f[:, 0], walked, wi[:, 2], wo[:, 2]))

    isotropic = lacquered(conductor(float(np.sqrt(0.06 * 0.3)), r0=0.9))
    found = error(weier.f(hairlines, wi, wo))
    assert found < 0.25
    assert error(belcour.f(isotropic, wi, wo)) > 2 * found


def test_values_below_the_horizon_are_zero_and_others_finite() -> None:
    wi, wo = cosine_pairs(np.random.default_rng(7), 500)
    stack = coat(diffuse(0.5), alpha_u=0.2, alpha_v=0.5, eta=0.6)  # total reflection from above
    assert np.isfinite(weier.f(stack, wi, wo)).all()
    assert not weier.f(stack, wi, wo * np.float32([1, 1, -1])).any()


def test_what_the_model_does_not_describe_is_refused() -> None:
    with pytest.raises(ParameterError, match="needs a Stack"):
        weier.f(diffuse(0.5), [[0.0, 0.0, 1.0]], [[0.0, 0.0, 1.0]])
    names = KINDS["mixture"].parameters
    table = bare("mixture", **dict.fromkeys(names, 0.5))
    with pytest.raises(ParameterError, match="do not support a 'mixture' bottom"):
        weier.rows(table, np.zeros(1, np.uint32), np.float32([[0, 0, 1]]), np.float32([[0, 0, 1]]))
