"""Adding in a quadrant: light between two surfaces, as by Fourier modes, and its coordinates."""

import numpy as np
import pytest

from urushi.core import direction_sets
from urushi.core.error_metrics import stack_error
from urushi.core.namespace import NUMPY, Components
from urushi.core.table import linear_at
from urushi.material import adding, adding_quadrant
from urushi.nets import lobe as lobes


def test_the_quadrant_agrees_with_the_modes_of_an_isotropic_bottom():
    """Light that is turned back below a coat, on two grids by two methods."""
    lobe = np.float32([0.3, 0.9, 1.0, 0.0, 1.5, 0.0])
    medium = 0.9, 1.0, 0.3

    def bottom(wi, wo):
        return lobes.f(lobe, wi, wo)[:, None]

    modes = adding.seen_inside(
        adding.bottom_modes(bottom)[0], adding.interface_modes(0.2, 1.5), [medium]
    )[0]
    values = adding_quadrant.seen_inside(
        adding_quadrant.bottom_parts(bottom)[0], adding_quadrant.interface_parts(0.2, 1.5), medium
    )
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(3), 500, lowest_cosine=0.1)
    expected = adding.grid().interpolated(modes[..., None], wi, wo)[:, 0]
    places = adding_quadrant.coordinates(Components(*wi.T), Components(*wo.T), NUMPY)
    found = linear_at(adding_quadrant.table(values)[..., None], *places)[:, 0]
    assert stack_error(found, expected, wi[:, 2], wo[:, 2]) < 0.01


def test_cells_are_where_their_directions_are():
    """Mirrored directions of both sides of a pair are in the same cells."""
    w, n = adding_quadrant.directions(), adding_quadrant.CELLS
    expected = np.meshgrid(*2 * [(np.arange(n) + 1) / n], indexing="ij")
    for sign in adding_quadrant.SIGNS:
        own = Components(*(w * np.append(sign, 1)).T)
        *near, a, b = adding_quadrant.coordinates(own, own, NUMPY)
        for place, coordinate in zip(near, expected, strict=True):
            np.testing.assert_allclose(place, coordinate.ravel(), atol=1e-5)
        for place, coordinate in zip((a, b), expected, strict=True):
            cells = (2 * n - 1) * place  # of both signs
            np.testing.assert_allclose(cells, n + n * coordinate.ravel() - 1, atol=1e-3)
    assert 4 * adding_quadrant.weights().sum() == pytest.approx(np.pi, rel=2e-3)  # midpoints
