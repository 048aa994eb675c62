"""Pictures of spheres: furnaces, symmetry, and Mitsuba's renderer as an independent method."""

import numpy as np
import pytest
from benchmarks import sphere
from benchmarks.sphere import AZIMUTHS, ELEVATIONS

WHITE = np.ones((ELEVATIONS, AZIMUTHS, 3))


def test_a_white_sphere_vanishes_in_a_white_furnace():
    white = sphere.transport(lambda wi, wo: np.full((len(wi), 1), 1 / np.pi))
    picture = sphere.picture(white, WHITE)
    inside = sphere.mask()
    np.testing.assert_allclose(picture[inside], 1, atol=1e-3)
    assert (picture[~inside] == 0).all()


@pytest.mark.parametrize("alpha", [0.005, 0.03, 0.1])
def test_narrow_lobes_are_integrated_whole(alpha):
    """Of GGX (Walter et al. 2007) without masking, whose projected area is that of the plane."""

    def f(wi, wo):
        wi, wo = wi.astype(np.float64), wo.astype(np.float64)
        half = (wi + wo) / np.linalg.norm(wi + wo, axis=1, keepdims=True)
        tangent2 = half[:, 0] ** 2 + half[:, 1] ** 2
        d = alpha**2 / (np.pi * (alpha**2 * half[:, 2] ** 2 + tangent2) ** 2)
        return d[:, None] / (4 * (half * wi).sum(1) * wo[:, 2])[:, None]

    # In front, where no normal that matters is cut off, the integral of D(h) h.n is 1, and that of
    # this lobe with it: dh = dwo / 4 (wi.h), and h.n is within 1 % of 1 for these widths.
    middle = sphere.picture(sphere.transport(f), WHITE)[sphere.RINGS, sphere.RINGS]
    np.testing.assert_allclose(middle, 1, atol=0.015)
