"""Bare bottoms are a lobe and a rest."""

import numpy as np
import pytest

from urushi.core.probe_pairs import probe_pairs
from urushi.nets import lobe
from urushi.train.bottoms import bottom_lobes
from urushi.train.distribution import BOTTOMS, Extended
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS


@pytest.mark.parametrize("kind", BOTTOMS)
def test_a_bottom_is_its_lobe_and_the_rest(kind):
    """A fitted lobe is above the bottom at some pairs, mostly by little."""
    columns, pairs = Extended(1, kind).sample(np.random.default_rng(7), 24).bottom, probe_pairs()
    own, f = bottom_lobes(kind, columns), analytic.at_all(kind, columns, *pairs)
    top = lobe.f(own[:, None], *pairs)
    assert (np.median(np.maximum(top, f) / (f + 1e-3), axis=1) < 1.05).all()
    if KINDS[kind].family.bare:
        np.testing.assert_allclose(top, f, rtol=1e-2, atol=1e-5)  # rounding of sharp lobes
    if kind == "diffuse":
        assert not own[:, 1:4].any()
