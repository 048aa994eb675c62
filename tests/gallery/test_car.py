"""The parts of the scene "car"."""

import numpy as np
import pytest
from gallery import car, car_fittings, car_shape
from gallery.mesh import Mesh


@pytest.fixture(scope="module")
def parts() -> dict[str, Mesh]:
    return car.meshes()


def test_the_car_stands_on_its_tyres_and_is_symmetric(parts):
    lowest = {name: float(part.positions[:, 2].min()) for name, part in parts.items()}
    assert min(lowest, key=lowest.get) == "tyres"
    assert lowest["tyres"] == pytest.approx(0, abs=0.005)
    for name, part in parts.items():
        low, high = part.positions[:, 1].min(), part.positions[:, 1].max()
        assert low == pytest.approx(-high, abs=1e-3), name


def test_parts_face_outwards(parts):
    """Where cells are too coarse for a fold or an edge, a few slivers may not."""
    for name, part in parts.items():
        a, b, c = (part.positions[part.faces[:, k]].astype(float) for k in range(3))
        area = np.cross(b - a, c - a)
        size = np.linalg.norm(area, axis=1)
        wrong = (area * part.normals[part.faces].mean(axis=1)).sum(axis=1) < 0
        assert size[wrong].sum() < 0.01 * size.sum(), name
        assert (np.cross(a, b) * c).sum() > 0, name


def test_bumpers_lie_in_front_of_and_behind_all_else(parts):
    for end in (1, -1):
        bar = car_fittings.bumper(end)
        a, b, c = (bar.positions[bar.faces[:, k]].astype(float) for k in range(3))
        assert (np.cross(a, b) * c).sum() > 0
        assert (end * bar.positions[:, 0]).max() > (
            end * parts["body"].positions[:, 0]
        ).max() + 0.05


def test_no_part_is_cut_off_by_its_box(parts):
    """The half boxes end at the mirror, and nowhere else at a part."""
    low, high = np.array(car.BODY, float)
    for name in ("body", "panes", "boards"):
        points = parts[name].positions
        assert (points.min(axis=0)[[0, 2]] > low[[0, 2]] + car.FINE).all(), name
        assert (points.max(axis=0) < high - car.FINE).all(), name


def test_panes_lie_in_the_body(parts):
    depth = car_shape.skin(parts["panes"].positions)
    assert depth.max() < -0.01


def test_flakes_repeat_without_a_seam():
    """Texels of both sides of an edge have the flakes that a shifted tile has in its middle."""
    rng = np.random.default_rng(3)
    number = car.flakes(120, 15, rng)
    assert number.min() >= 0 and number.max() < 15**2
    assert len(np.unique(number)) > 0.95 * 15**2
    inside = (number[1:] == number[:-1]).mean()
    across = (number[0] == number[-1]).mean()
    assert across == pytest.approx(inside, abs=0.1)
