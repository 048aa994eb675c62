"""The models of other authors against closed forms, laws of physics, each other and the walk."""

import numpy as np
import pytest
from benchmarks import measures
from research.rivals import belcour, belcour_tables, weidlich, weier

from urushi.core import fresnel
from urushi.core.direction_sets import cosine_pairs
from urushi.walk import coat, conductor, dielectric, diffuse, simulate
from urushi.walk.monte_carlo import backend
from urushi.walk.table import from_stack

BOTTOMS = {
    "schlick": conductor(0.2, r0=0.9),
    "complex": conductor(0.4, eta=0.2, k=3.9),
    "dielectric": dielectric(0.3, 1.7),
    "diffuse": diffuse(0.5),
}


COSINES = np.linspace(0.3, 1, 8)


def lanes(values) -> object:
    return backend().Float(np.float32(values * np.ones(len(COSINES))))


def lobes(stack) -> np.ndarray:
    """Energies and widths of the lobes of Belcour 2018, (2, interfaces, cosines)."""
    row = backend().UInt32(np.zeros(len(COSINES), np.uint32))
    found = belcour.lobes(from_stack(stack), row, lanes(COSINES))
    parts = [
        [lobe.energy.numpy() + 0 * COSINES, lobe.alpha.numpy() + 0 * COSINES] for lobe in found
    ]
    return np.swapaxes(parts, 0, 1)


@pytest.mark.parametrize("etas", [(1.5,), (1.3, 1.4), (1.9, 0.8, 1.2)])
def test_lossless_stacks_reflect_all_light(etas) -> None:
    """Reflections between all layers and total reflection neither lose nor create energy."""
    stack = conductor(0.2, r0=1)
    for alpha, eta in zip((0.3, 0.05, 0.5), etas, strict=False):
        stack = coat(stack, alpha, eta)
    np.testing.assert_allclose(lobes(stack)[0].sum(axis=0), 1, atol=1e-5)


def test_a_clear_coat_over_metal_is_a_geometric_series() -> None:
    """Of reflections at the metal, at the interface from below, and beyond its critical angle."""
    interface, cos = belcour.interface(*map(lanes, (COSINES, 0.05, 1.5, 0)))
    spread = belcour.width(interface.s_t + belcour.variance(lanes(0.25)))
    passed = belcour_tables.transmitted_share(cos, spread, lanes(1 / 1.5)).numpy()
    metal = belcour_tables.mean_over_facets(
        lambda wo, cos_m: fresnel.schlick(cos_m, lanes(0.8)), cos, spread
    ).numpy()
    r = interface.r.numpy()
    back = r + (1 - passed) * (1 - r)
    (first, second), _ = lobes(coat(conductor(0.25, r0=0.8), 0.05, 1.5))
    np.testing.assert_allclose(first, r, rtol=1e-5)
    expected = (1 - r) ** 2 * passed * metal / (1 - back * metal)
    np.testing.assert_allclose(second, expected, rtol=1e-5)


def test_media_without_an_interface_absorb_and_widen_as_the_papers_equations() -> None:
    """Equations 6, 15, 21 and 24: twice through the medium, and nothing comes back."""
    albedo, depth, g = 0.8, 0.7, 0.6
    (_, energy), (_, width) = lobes(coat(conductor(0.3, r0=1), 0.01, 1.0, albedo, depth, g))
    through = (1 + albedo * depth / COSINES) * np.exp(-depth / COSINES)
    np.testing.assert_allclose(energy, through**2, rtol=1e-4)
    variance = 0.3**1.1 / (1 - 0.3**1.1) + 2 * albedo * ((1 - g) / g) ** 0.8 / (1 + g)
    np.testing.assert_allclose(width, (variance / (1 + variance)) ** (1 / 1.1), rtol=1e-4)


@pytest.mark.parametrize("eta", [0.7, 1.3])
@pytest.mark.parametrize("name", BOTTOMS)
def test_equal_widths_are_the_isotropic_model(name: str, eta: float) -> None:
    # The same operations on both axes: only the root of a square rounds otherwise.
    wi, wo = cosine_pairs(np.random.default_rng(0), 500)
    stack = coat(coat(BOTTOMS[name], 0.3, eta, 0.5, 0.4, 0.3), 0.05, 1.5, 0.9, 0.7, 0.8)
    np.testing.assert_allclose(weier.f(stack, wi, wo), belcour.f(stack, wi, wo), rtol=1e-5)


def test_exchanged_widths_are_a_quarter_turn() -> None:
    wi, wo = cosine_pairs(np.random.default_rng(4), 500)
    stack = coat(conductor(alpha_u=0.1, alpha_v=0.4, r0=0.8), alpha_u=0.4, alpha_v=0.05, eta=1.4)
    turned = coat(conductor(alpha_u=0.4, alpha_v=0.1, r0=0.8), alpha_u=0.05, alpha_v=0.4, eta=1.4)
    np.testing.assert_allclose(
        weier.f(turned, wi[:, [1, 0, 2]], wo[:, [1, 0, 2]]), weier.f(stack, wi, wo), rtol=1e-4
    )


def test_lacquered_hairlines_are_near_the_walk() -> None:
    # A smooth, clear coat: E is 22 %, and 16 % for a metal of the width 0.3 alone, which is the
    # isotropic model. The geometric mean of the widths in place of both gives 64 %.
    wi, wo = cosine_pairs(np.random.default_rng(6), 200)
    hairlines = coat(conductor(alpha_u=0.06, alpha_v=0.3, r0=0.9), 0.05, 1.5)
    walked = simulate(hairlines, wi, wo, walks=4096, seed=1)[0][:, 0]

    def error(f) -> float:
        return float(measures.stack_error(f[:, 0], walked, wi[:, 2], wo[:, 2]))

    isotropic = coat(conductor(float(np.sqrt(0.06 * 0.3)), r0=0.9), 0.05, 1.5)
    found = error(weier.f(hairlines, wi, wo))
    assert found < 0.25
    assert error(belcour.f(isotropic, wi, wo)) > 2 * found


def test_absorption_is_beers_law_along_the_refracted_directions() -> None:
    # The quotient of what two coats let through: whatever the interfaces do cancels.
    wi, wo = cosine_pairs(np.random.default_rng(0), 500, lowest_cosine=0.2)
    facet = (wi + wo).astype(float)
    facet /= np.linalg.norm(facet, axis=1, keepdims=True)
    path = 0
    for w in (wi, wo):  # bent towards the facet's normal by Snell's law
        tangent = (w - np.sum(w * facet, axis=1, keepdims=True) * facet) / 1.5
        inside = tangent + np.sqrt(1 - np.sum(tangent**2, axis=1, keepdims=True)) * facet
        path += 1 / inside[:, 2]
    expected = np.exp(-0.8 * path)

    def below(sigma_t: float) -> np.ndarray:
        stacks = (coat(diffuse(r), 0.3, 1.5, 0.0, sigma_t) for r in (1.0, 0.0))
        white, black = (weidlich.f(stack, wi, wo)[:, 0].astype(float) for stack in stacks)
        kept = white > 1.001 * black  # the rest is rounding of a coat's bright lobe
        return np.where(kept, white - black, np.nan)

    found = below(0.8) / below(0.0)
    known = np.isfinite(found)
    assert known.mean() > 0.9
    np.testing.assert_allclose(found[known], expected[known], rtol=2e-3)


def test_the_model_is_reciprocal() -> None:
    wi, wo = cosine_pairs(np.random.default_rng(3), 500, lowest_cosine=0.1)
    stack = coat(coat(conductor(0.2, r0=0.9), 0.3, 1.2, 0.0, 0.4), 0.1, 1.4)
    np.testing.assert_allclose(
        weidlich.f(stack, wi, wo), weidlich.f(stack, wo, wi), rtol=1e-3, atol=1e-6
    )
