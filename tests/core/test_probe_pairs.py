"""Probe pairs: fixed, above the horizon, from the sharpest lobes' scale to grazing."""

import numpy as np
import pytest

from urushi.core.probe_pairs import probe_pairs


@pytest.mark.parametrize("n", [1, 64, 192, 500])
def test_probes_are_unit_vectors_above_the_horizon(n):
    for side in probe_pairs(n):
        assert side.shape == (n, 3) and side.dtype == np.float32
        np.testing.assert_allclose(np.linalg.norm(side, axis=1), 1, atol=1e-6)
        assert (side[:, 2] >= 0.0199).all() and not side.flags.writeable


def test_probes_span_half_angles_and_difference_angles():
    wi, wo = (side.astype(np.float64) for side in probe_pairs(192))
    half = wi + wo
    tangent = np.hypot(half[:, 0], half[:, 1]) / half[:, 2]
    # A lobe of alpha = 0.01 is 0.01 wide in the tangent; several probes must fall in each decade.
    for low in (1e-3, 1e-2, 1e-1):
        assert ((tangent >= low) & (tangent < 10 * low)).sum() >= 20
    difference = np.degrees(np.arccos(np.clip(np.linalg.norm(half, axis=1) / 2, 0, 1)))
    assert difference.min() < 5 and difference.max() > 80
    assert np.minimum(wi[:, 2], wo[:, 2]).min() < 0.06
