"""The violin's shape and woods, and the solids that it is made of."""

import numpy as np
import pytest
from gallery import solids, violin, violin_neck, violin_shape, violin_wood
from gallery import violin_fittings as fittings
from gallery.grids import grid
from gallery.mesh import Mesh
from gallery.violin_shape import LENGTH, Arching


@pytest.fixture(scope="module")
def belly():
    return Arching(violin.BELLY)


def signed_volume(of: Mesh) -> float:
    """Volume enclosed (divergence theorem); negative where triangles face inwards."""
    a, b, c = (of.positions[of.faces[:, k]].astype(float) for k in range(3))
    return float((np.cross(a, b) * c).sum() / 6)


def wrong_area(of: Mesh) -> float:
    """Share of the area whose triangles face away from their vertices' normals."""
    a, b, c = (of.positions[of.faces[:, k]].astype(float) for k in range(3))
    area = np.cross(b - a, c - a)
    size = np.linalg.norm(area, axis=1)
    wrong = (area * of.normals[of.faces].sum(axis=1)).sum(axis=1) < 0
    return float(size[wrong].sum() / size.sum())


def test_a_tube_and_its_mirror_image_enclose_their_volume():
    """A straight tube of 48 sides: the prism's volume, in single precision."""
    pipe = solids.tube([(0, 0, 0), (1, 0, 0), (3, 0, 0)], 0.5, sides=48)
    prism = 3 * 48 / 2 * np.sin(2 * np.pi / 48) * 0.5**2
    for shape in (pipe, solids.moved(pipe, np.diag([-1, 1, 1]), (1, 2, 3))):
        assert signed_volume(shape) == pytest.approx(prism, rel=1e-5)
        assert wrong_area(shape) == 0
        np.testing.assert_allclose(np.linalg.norm(shape.normals, axis=1), 1, atol=1e-5)


@pytest.mark.parametrize("inside", [True, False])
def test_a_disc_cut_from_a_square_has_its_area(inside):
    """To 0.1 %: the cut is a polygon with corners on the grid's lines, 0.02 apart."""
    x, y = np.meshgrid(np.linspace(-1, 1, 101), np.linspace(-1, 1, 101))
    square = grid(np.stack([x, y, 0 * x], axis=-1))
    radius = np.hypot(*square.positions[:, :2].T)
    face, line = solids.cut(square, 0.7 - radius if inside else radius - 0.7)
    a, b, c = (face.positions[face.faces[:, k]].astype(float) for k in range(3))
    area = np.cross(b - a, c - a)[:, 2] / 2
    assert area.min() > -1e-9
    disc = np.pi * 0.49
    assert area.sum() == pytest.approx(disc if inside else 4 - disc, rel=1e-3)
    # With its wall and a copy below, the disc is a closed cylinder.
    wall = solids.wall(face, line, (0, 0, -2.0))
    assert wrong_area(wall) == 0
    if inside:
        below = solids.moved(face, np.diag([1, 1, -1]), (0, 0, -2.0))
        closed = solids.merged([face, wall, below])
        assert signed_volume(closed) == pytest.approx(2 * disc, rel=1e-3)


def test_distances_from_a_square():
    """Inside and outside, beside a side and beside a corner, and mirrored."""
    square = np.array([(0, 0), (2, 0), (2, 2), (0, 2)], float)
    points = np.array([(1, 0.5), (1, 1), (3, 1), (3, 3), (-1, 0), (1, -2)], float)
    expected = [-0.5, -1, 1, np.sqrt(2), 1, 2]
    np.testing.assert_allclose(solids.signed_distance(points, square), expected, atol=1e-12)
    np.testing.assert_allclose(solids.signed_distance(points, square[::-1]), expected, atol=1e-12)


def test_the_outline_has_the_measures_of_its_model():
    """Widths of the bouts of the "Messiah" of 1716 to the millimetre."""
    half, middle = violin_shape.outline()
    x, y = half.T
    assert (x[0], y[0], x[-1], y[-1]) == pytest.approx((0, 0, 0, LENGTH))
    widths = 2 * x[y < 125].max(), 2 * x[(y > 150) & (y < 210)].min(), 2 * x[y > 240].max()
    np.testing.assert_allclose(widths, (208, 108.5, 167.5), atol=1)
    assert (np.diff(middle[:, 1]) > 0).all()


def test_the_arch_is_symmetrical_and_highest_in_the_middle(belly):
    x, y = np.meshgrid(np.linspace(-50, 50, 21), np.linspace(30, LENGTH - 30, 31))
    heights = belly(np.stack([x, y], axis=-1))
    np.testing.assert_allclose(heights, heights[:, ::-1], atol=1e-9)
    assert heights.max() == pytest.approx(violin.BELLY, abs=0.05)
    assert (heights.max(axis=1) - heights[:, 10] < 1e-6).all()


def test_parts_face_outwards(belly):
    """Lofts and turned parts are closed; of all, few slivers are shaded against their side."""
    closed = [*violin_neck.maple_parts(), *fittings.ebony_parts()]
    closed += [*fittings.metal_parts(belly), fittings.bridge(belly)]
    assert min(map(signed_volume, closed)) > 0
    plate = violin_shape.plate(belly, holes=True)
    for shape in (*closed, plate, violin_wood.maple_parts(belly)):
        assert wrong_area(shape) < 0.01
        assert shape.uv.min() >= 0 and shape.uv.max() <= 1


def test_strings_touch_nothing_between_nut_and_bridge(belly):
    """They run at least 1 mm above the fingerboard, and over the belly."""
    for number in range(4):
        x, y, z = fittings.string(number, belly).positions.T
        over = (y > 216) & (y < violin_neck.NUT - 40)
        board = violin_neck.board_height(y) - violin_neck.drop(np.clip(x, -21, 21))
        assert (z - board)[over].min() > 1
        open_ = (y > 115) & (y < fittings.BRIDGE)
        assert (z[open_] - belly(np.stack([x, y], axis=-1))[open_]).min() > 10


def test_textures_of_the_woods(belly):
    """Colours are reflectances, depths positive; the purfling is the darkest of the belly."""
    color, depth = violin_wood.spruce(belly, 128)
    assert color.shape == (*depth.shape, 3) and len(color) == 128
    whole, thick = violin_wood.flamed_maple(belly, 128)
    assert whole.shape == (*thick.shape, 3) and len(whole) == 128
    for values in (color, whole):
        assert values.min() > 0 and values.max() < 1
    for values in (depth, thick):
        assert values.min() > 0.2 and values.max() <= 2
    row, column = np.unravel_index(color.sum(axis=-1).argmin(), depth.shape)
    x = ((column + 0.5) / depth.shape[1] - 0.5) * violin_shape.WIDTH
    y = (row + 0.5) / 128 * LENGTH
    away = belly.distance(np.array([[x, y]]))[0]
    assert abs(away - violin_wood.PURFLING) < violin_wood.LIGHT / 2 + violin_wood.DARK + 1.4
