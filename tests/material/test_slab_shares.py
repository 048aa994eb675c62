"""Shares of the light of slabs by adding, against closed forms and the analog walk."""

import numpy as np
import pytest
from tests.oracles.analog import analog_albedo

import urushi
from urushi.core import fresnel
from urushi.core.namespace import NUMPY
from urushi.material.crossing import in_plane, inner_albedo
from urushi.material.slab_shares import Layers, shares

COSINES = np.array([0.98, 0.8, 0.6, 0.4, 0.25, 0.12])
WI = np.stack([np.sqrt(1 - COSINES**2), 0 * COSINES, COSINES], axis=1).astype(np.float32)
CLEAR, MEDIUM, HALF = (0.0, 0.0, 0.0), (0.9, 1.0, 0.3), (0.9, 0.5, 0.3)


def found(interfaces: list[tuple], media: list[tuple]) -> tuple[np.ndarray, np.ndarray]:
    """Shares at `COSINES` that are reflected, without the first interface's, and transmitted."""
    layers = Layers.of(np.array(interfaces, float), np.array(media, float)[..., None])
    reflected, passed = shares(layers, 1)[0].at(np.arccos(COSINES))
    return reflected[:, 0], passed[:, 0]


@pytest.mark.parametrize("index", [1.3, 1.5])
def test_a_clear_coat_of_a_panes_own_index_changes_nothing(index):
    """Of a smooth pane, 2 R / (1 + R) of the light is reflected (Stokes 1862).

    Facets of a width of 0.001 and linear interpolation change 0.002 near the horizon.
    """
    once, _ = fresnel.dielectric(COSINES, index, NUMPY)
    reflected, passed = found([(1e-3, index), (0.3, 1.0), (1e-3, 1 / index)], [CLEAR, CLEAR])
    np.testing.assert_allclose(once + reflected, 2 * once / (1 + once), atol=3e-3)
    np.testing.assert_allclose(passed, (1 - once) / (1 + once), atol=3e-3)


@pytest.mark.parametrize(
    "whole, cut",
    [
        (([(0.1, 1.5), (0.2, 0.8)], [MEDIUM]), [(0.1, 1.5), (0.3, 1.0), (0.2, 0.8)]),
        (([(0.1, 1.0), (0.2, 1.5)], [MEDIUM]), [(0.3, 1.0), (0.1, 1.0), (0.2, 1.5)]),
        (([(0.2, 1.5), (0.3, 1.0)], [MEDIUM]), [(0.2, 1.5), (0.1, 1.0), (0.3, 1.0)]),
    ],
)
def test_an_interface_of_index_one_is_none(whole, cut):
    """Inside, above and below a slab. Media are doubled from other depths: within 1e-4."""
    np.testing.assert_allclose(found(*whole), found(cut, [HALF, HALF]), atol=1e-4)


@pytest.mark.parametrize(
    "interfaces",
    [
        [(0.01, 1.6), (0.01, 1.5 / 1.6)],
        [(0.283, 1.59), (0.047, 1.0757)],
        pytest.param(
            [(0.025, 1.18), (0.023, 1.66), (0.023, 0.687), (0.044, 0.743)], marks=pytest.mark.slow
        ),
    ],
)
def test_clear_slabs_have_the_shares_of_the_analog_walk(interfaces):
    """Within four standard errors of the walks, which are 0.004 at most, and 0.003 of the grid."""
    for own in (interfaces, [(alpha, 1 / eta) for alpha, eta in interfaces[::-1]]):
        slab = urushi.dielectric(*own[-1])
        for interface in own[-2::-1]:
            slab = urushi.coat(slab, *interface, *CLEAR)
        reflected, passed = found(own, [CLEAR] * (len(own) - 1))
        reflected = reflected + inner_albedo(in_plane(COSINES[:, None]), own[0][0], 1 / own[0][1])
        for share, transmitted in ((reflected, False), (passed, True)):
            truth, se = analog_albedo(slab, WI, walks=1 << 14, transmitted=transmitted)
            assert np.all(np.abs(share - truth[:, 0]) < 0.003 + 4 * se[:, 0])
