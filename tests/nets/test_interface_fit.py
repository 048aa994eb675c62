"""Bare interfaces are recognised by their values, and nothing else is taken for one."""

import numpy as np
import pytest

from urushi.core.probe_pairs import probe_pairs
from urushi.nets import lobe as lobes
from urushi.nets.interface_fit import TOLERANCE, find_lobes
from urushi.nets.lobe_fit import DARK, fit_lobes
from urushi.train.distribution import Extended
from urushi.walk import analytic

STACKS = 96


def values(kind: str) -> np.ndarray:
    """Values (`STACKS`, P) of bottoms at the probe pairs."""
    wi, wo = probe_pairs()
    columns = Extended(0, kind).sample(np.random.default_rng(1), STACKS).bottom
    row = np.repeat(np.arange(STACKS, dtype=np.uint32), len(wi))
    directions = (np.tile(w, (STACKS, 1)) for w in (wi, wo))
    return analytic.rows(kind, columns, row, *directions).reshape(STACKS, -1)


@pytest.mark.parametrize("kind", ["conductor_complex", "dielectric"])
def test_bare_interfaces_are_found(kind):
    """Not those of the faintest reflection, which are darker than errors count."""
    f = values(kind)
    found = lobes.f(find_lobes(f)[:, None], *probe_pairs())
    error = (np.abs(found - f) / (f + DARK)).max(axis=-1)
    assert (error < TOLERANCE).mean() > 0.85


@pytest.mark.parametrize("kind", ["conductor", "diffuse", "mixture", "measured_like"])
def test_other_surfaces_keep_schlick_s_term(kind):
    f = values(kind)
    np.testing.assert_array_equal(find_lobes(f), fit_lobes(f))


def test_leading_axes():
    f = values("dielectric")[:6]
    assert find_lobes(f.reshape(2, 3, -1)).shape == (2, 3, 6)
    assert find_lobes(f[0]).shape == (6,)


def test_no_brdfs_have_no_lobes():
    f = np.zeros((0, 3, len(probe_pairs()[0])))
    assert find_lobes(f).shape == fit_lobes(f).shape == (0, 3, 6)
