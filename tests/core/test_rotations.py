"""Rotations about the normal."""

import numpy as np
import pytest

from urushi.core.directions import rotated

DIRECTIONS = np.random.default_rng(0).normal(size=(50, 3)).astype(np.float32)


def test_quarter_turn_takes_x_to_y() -> None:
    np.testing.assert_allclose(
        rotated(np.eye(3), 0.25), [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-7
    )


@pytest.mark.parametrize("mirrored", [False, True])
def test_lengths_and_heights_are_kept(mirrored: bool) -> None:
    turned = rotated(DIRECTIONS, 0.155, mirrored)
    np.testing.assert_array_equal(turned[:, 2], DIRECTIONS[:, 2])
    np.testing.assert_allclose(
        np.linalg.norm(turned, axis=1), np.linalg.norm(DIRECTIONS, axis=1), rtol=1e-6
    )


def test_mirrored_negates_y_of_the_rotated_directions() -> None:
    np.testing.assert_array_equal(
        rotated(DIRECTIONS, 0.3, True), rotated(DIRECTIONS, 0.3) * np.float32([1, -1, 1])
    )


def test_rotations_add_up() -> None:
    np.testing.assert_allclose(
        rotated(rotated(DIRECTIONS, 0.2), 0.3), rotated(DIRECTIONS, 0.5), atol=1e-6
    )
