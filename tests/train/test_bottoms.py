"""Bare bottoms are a lobe and a rest."""

import numpy as np
import pytest

from urushi.core.probe_pairs import PROBES, probe_pairs
from urushi.nets import lobe
from urushi.train.bottoms import bottom_lobes, bottom_rest
from urushi.train.distribution import BOTTOMS, Extended
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS


@pytest.mark.parametrize("kind", BOTTOMS)
def test_a_bottom_is_its_lobe_and_the_rest(kind):
    """A fitted lobe is above the bottom at some pairs, mostly by little."""
    columns = Extended(1, kind).sample(np.random.default_rng(7), 24).bottom
    bottom = np.stack(list(columns.values()), axis=-1)
    wi, wo = probe_pairs(PROBES)
    own = bottom_lobes(kind, bottom)
    rest = bottom_rest(kind, bottom, own, wi, wo)
    for row in range(len(bottom)):
        f = analytic.rows(kind, columns, np.full(PROBES, row, np.uint32), wi, wo)
        sum_of_both = lobe.f(own[row], wi, wo) + rest[row]
        assert (sum_of_both >= f * (1 - 1e-2) - 1e-5).all()  # rounding of sharp lobes
        assert np.median(sum_of_both / (f + 1e-3)) < 1.05
    if KINDS[kind].family.bare:
        assert not rest.any()
    if kind == "diffuse":
        assert not own[:, 1:4].any()
