"""The statistical operators of Belcour 2018 against closed forms and laws of physics."""

import numpy as np
import pytest
from research.rivals import belcour, belcour_tables
from tests.oracles import slab

from urushi.core import fresnel
from urushi.errors import ParameterError
from urushi.walk import analytic, coat, conductor, dielectric, diffuse
from urushi.walk.monte_carlo import backend
from urushi.walk.table import from_stack

COSINES = np.float32([0.2, 0.5, 0.8, 1.0])


def lanes(values) -> object:
    return backend().Float(np.float32(values))


def energies(stack, cosines=COSINES) -> np.ndarray:
    """Energies of the lobes of a grey stack, (lobes, cosines)."""
    row = backend().UInt32(np.zeros(len(cosines), np.uint32))
    found = belcour.lobes(from_stack(stack), row, lanes(cosines))
    return np.stack([lobe.energy.numpy() + np.zeros(len(cosines)) for lobe in found])


@pytest.mark.parametrize("eta", [0.8, 1.1, 1.5, 2.5])
def test_smooth_mean_is_fresnels_reflectance(eta: float) -> None:
    # 5 %: the table is linear between nodes, and Fresnel's formula is steep at a critical angle.
    mean = belcour_tables.mean_dielectric(lanes([0.7, 0.9, 1.0]), lanes(0.0), lanes(eta)).numpy()
    expected = slab.interface_reflectance(np.array([0.7, 0.9, 1.0]), eta)
    np.testing.assert_allclose(mean, expected, rtol=0.05, atol=2e-4)


def test_smooth_lobes_pass_within_the_critical_angle_only() -> None:
    # The critical cosine of the index 1.5 is 0.745; interpolation blurs the edge by a node.
    share = belcour_tables.transmitted_share(lanes([0.5, 0.95]), lanes(0.0), lanes(1 / 1.5))
    np.testing.assert_allclose(share.numpy(), [0, 1], atol=1e-5)


@pytest.mark.parametrize("eta, k", [(0.2, 3.9), (1.0, 6.4), (3.1, 3.3)])
def test_the_tabulated_mean_of_metals_is_that_over_facets(eta: float, k: float) -> None:
    # The bound that `layered_belcour` states; the exact mean has the same 144 facets.
    places = np.random.default_rng(0).uniform([[0.05], [0.01]], 1, (2, 4000))
    cos, alpha = (lanes(x) for x in places)

    def metal(cosine) -> object:
        return fresnel.exact(cosine, lanes(eta), lanes(k))

    exact = belcour_tables.mean_over_facets(lambda wo, cosine: metal(cosine), cos, alpha)
    values = [metal(lanes(x)) for x in belcour_tables.FACET_COSINES]
    found = belcour_tables.mean_of_values(values, cos, alpha)
    np.testing.assert_allclose(found.numpy(), exact.numpy(), atol=0.01)


def test_width_inverts_variance() -> None:
    alphas = np.float32([0.02, 0.1, 0.5, 0.9])
    np.testing.assert_allclose(
        belcour.width(belcour.variance(lanes(alphas))).numpy(), alphas, rtol=1e-4
    )


@pytest.mark.parametrize("sigma_t", [0.0, 0.7])
def test_smooth_stack_has_the_energy_of_adding_plane_parallel_layers(sigma_t: float) -> None:
    # R + T^2 a r / (1 - R a r), with Beer's law a for the way down and up: a mirror r under glass.
    stack = coat(conductor(0.01, r0=1.0), 0.01, 1.5, 0.0, sigma_t)
    expected = slab.mirror_albedo(COSINES.astype(float), 1.5, sigma_t, 1.0)
    # At grazing angles the refracted light is so near the critical angle that the table of total
    # reflection returns some of it; 0.005 is the interpolation's error elsewhere.
    grazing = COSINES < 0.5
    np.testing.assert_allclose(energies(stack).sum(0)[~grazing], expected[~grazing], atol=0.005)
    np.testing.assert_allclose(energies(stack).sum(0)[grazing], expected[grazing], atol=0.03)


@pytest.mark.parametrize("alpha", [0.02, 0.3, 1.0])
def test_white_furnace(alpha: float) -> None:
    # Nothing absorbs: the energies of all lobes are one where no light scatters in a medium.
    for bottom in (conductor(alpha, r0=1.0), diffuse(1.0)):
        total = energies(coat(coat(bottom, alpha, 1.3), alpha, 1.5)).sum(0)
        np.testing.assert_allclose(total, 1, atol=1e-4)
        # Scattering sends light out of the forward direction: some is lost, none is gained.
        scattering = coat(bottom, alpha, 1.5, albedo=1.0, sigma_t=1.0, g=0.5)
        assert np.all(energies(scattering).sum(0) <= 1 + 1e-5)


def hemisphere() -> tuple[np.ndarray, np.ndarray]:
    """Nodes of a midpoint rule over (cosine, azimuth), (N, 3), and their weights with cosine."""
    n = 128
    cos, phi = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(2 * n) + 0.5) * np.pi / n)
    cos, phi = cos.ravel(), phi.ravel()
    sin = np.sqrt(1 - cos * cos)
    return np.stack([sin * np.cos(phi), sin * np.sin(phi), cos], 1), 2 * np.pi * cos / len(cos)


def incident(cos: float, count: int) -> np.ndarray:
    return np.tile([np.sqrt(1 - cos * cos), 0, cos], (count, 1))


@pytest.mark.parametrize("cos", [0.3, 0.9])
def test_one_interface_reflects_as_much_as_ggx(cos: float) -> None:
    # Under a thick black medium the coat's reflection is all. The lobe has the mean of Fresnel's
    # term in place of the term itself. 2 %: the table's interpolation and the midpoint rule.
    wo, weights = hemisphere()
    wi = incident(cos, len(wo))
    lobe = belcour.f(coat(diffuse(0.0), 0.3, 1.5, 0.0, 40.0), wi, wo)[:, 0]
    exact = analytic.f(dielectric(0.3, 1.5), wi, wo)[:, 0]
    assert lobe @ weights == pytest.approx(exact @ weights, rel=0.02)


@pytest.mark.parametrize("cos", [0.3, 0.9])
def test_a_white_stack_reflects_no_more_than_it_receives(cos: float) -> None:
    # 1 %: the midpoint rule over lobes of a width of 0.3 or more.
    wo, weights = hemisphere()
    stack = coat(conductor(0.3, r0=1.0), 0.3, 1.5)
    assert belcour.f(stack, incident(cos, len(wo)), wo)[:, 0] @ weights <= 1.01


def test_f_is_zero_below_the_horizon() -> None:
    up, down = [[0.0, 0.0, 1.0]], [[0.0, 0.6, -0.8]]
    stack = coat(diffuse(0.5))
    assert not belcour.f(stack, up, down).any()
    assert not belcour.f(stack, down, up).any()


def test_anisotropic_stacks_are_refused() -> None:
    stack = coat(conductor(alpha_u=0.1, alpha_v=0.3, r0=1.0))
    with pytest.raises(ParameterError, match="supports isotropic lobes only"):
        belcour.f(stack, [[0.0, 0.0, 1.0]], [[0.0, 0.0, 1.0]])
