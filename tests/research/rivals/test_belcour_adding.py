"""The adding of statistical operators against a second, direct form of its recursion.

The second form, in NumPy, follows public ports of the code of Belcour 2018 step by step: energies
e, variances s and scales j of what reflects (r) and passes (t), from above and from below. Both
forms read the same tables, so that they differ by rounding alone.
"""

import numpy as np
import pytest
from research.rivals import belcour, belcour_tables

from urushi.core import fresnel
from urushi.walk import coat, conductor
from urushi.walk.monte_carlo import backend
from urushi.walk.table import from_stack

COSINES = np.linspace(0.3, 1, 8)
#: (alpha, eta, albedo, sigma_t, g) of coats, top to bottom.
STACKS = {
    "scattering": [(0.3, 1.7, 0.9, 0.8, 0.6)],
    "three": [(0.05, 1.3, 0.5, 0.4, 0.3), (0.4, 1.2, 0.9, 0.7, 0.8)],
}
BOTTOM = 0.25, 0.8  # alpha, r0


def _lanes(values) -> object:
    return backend().Float(np.float32(values * np.ones(len(COSINES))))


def _variance(alpha):
    return alpha**1.1 / (1 - alpha**1.1)


def _width(variance):
    return np.clip((variance / (1 + variance)) ** (1 / 1.1), 0.01, 1)


def _adding(coats) -> tuple[np.ndarray, np.ndarray]:
    """Energies and widths of the lobes, (interfaces, cosines) each."""
    cos = COSINES
    e_t, e_t_back, e_r_back = 1.0, 1.0, 0.0
    s_t, s_t_back, s_r_back = 0.0, 0.0, 0.0
    j, j_back, index_above = 1.0, 1.0, 1.0
    energies, widths = [], []
    layers = [part for c in coats for part in (("surface", *c[:2]), ("medium", *c[2:]))]
    for kind, *values in [*layers, ("metal", *BOTTOM)]:
        cos_below, stretch, s_r, s_down, s_up = cos, 1.0, 0.0, 0.0, 0.0
        if kind == "medium":
            albedo, sigma_t, g = values
            r = r_back = 0.0
            t = (1 + albedo * sigma_t / cos) * np.exp(-sigma_t / cos)
            g = max(g, 1e-4)
            s_down = s_up = albedo * ((1 - g) / g) ** 0.8 / (1 + g) * (sigma_t > 0)
        else:
            alpha, value = values
            s_r = _variance(alpha)
            lanes = _lanes(cos), _lanes(_width(s_t + s_r))
            if kind == "surface":
                r = r_back = belcour_tables.mean_dielectric(*lanes, _lanes(value)).numpy()
                t = 1 - r
                cos_below = np.sqrt(1 - (1 - cos**2) / value**2)
                stretch = value * cos_below / cos
                s_down = _variance(alpha * 0.5 * abs(value - 1) / value)
                s_up = _variance(alpha * 0.5 * abs(1 / value - 1) * value)
            else:
                r0 = _lanes(value)
                r = belcour_tables.mean_over_facets(
                    lambda wo, cos_m, r0=r0: fresnel.schlick(cos_m, r0), *lanes
                ).numpy()
                t = r_back = 0.0
            passes = belcour_tables.transmitted_share(*lanes, _lanes(1 / index_above)).numpy()
            e_r_back = np.minimum(e_r_back + (1 - passes) * e_t_back, 1)
            e_t_back = e_t_back * passes
            if kind == "surface":
                index_above = value
        rounds = e_r_back * r / (1 - e_r_back * r)
        if kind != "medium":
            energies.append(e_t * r * e_t_back * (1 + rounds))
            s = s_t_back + j * (s_t + s_r + rounds * (s_r + s_r_back))
            widths.append(_width(s))
        below = t * e_r_back * t * (1 + rounds)
        s_below = s_down + stretch * (s_up + s_r_back + rounds * (s_r + s_r_back))
        e_sum = np.maximum(r_back + below, 1e-12)
        s_t, s_t_back, s_r_back = (
            stretch * (s_t + rounds * (s_r + s_r_back)) + s_down,
            j_back * (s_up + rounds * (s_r + s_r_back)) + s_t_back,
            (r_back * s_r + below * s_below) / e_sum,
        )
        e_t, e_t_back, e_r_back = e_t * t * (1 + rounds), t * e_t_back * (1 + rounds), e_sum
        j, j_back, cos = j * stretch, j_back / stretch, cos_below
    return np.stack(energies), np.stack(widths)


@pytest.mark.parametrize("name", STACKS)
def test_lobes_are_those_of_the_direct_recursion(name: str) -> None:
    stack = conductor(BOTTOM[0], r0=BOTTOM[1])
    for coat_ in reversed(STACKS[name]):
        stack = coat(stack, *coat_)
    rows = backend().UInt32(np.zeros(len(COSINES), np.uint32))
    lobes = belcour.lobes(from_stack(stack), rows, _lanes(COSINES))
    energies, widths = _adding(STACKS[name])
    # Single precision through some twenty operations, with differences of like numbers.
    for lobe, energy, width in zip(lobes, energies, widths, strict=True):
        np.testing.assert_allclose(lobe.energy.numpy() + np.zeros(8), energy, atol=1e-5, rtol=1e-3)
        np.testing.assert_allclose(lobe.alpha.numpy() + np.zeros(8), width, atol=1e-5, rtol=1e-3)
