"""Rotations of directions about the normal, which is z."""

import numpy as np


def rotated(w: np.ndarray, turn: float, mirrored: bool = False) -> np.ndarray:
    """Rotate directions about the normal, and mirror them in the xz plane if `mirrored`.

    Args:
        w: (N, 3) directions.
        turn: the angle as a fraction of a full turn, counter-clockwise.
        mirrored: whether to negate y after the rotation.

    Returns:
        float32 (N, 3).
    """
    cos, sin = np.cos(2 * np.pi * turn), np.sin(2 * np.pi * turn)
    sign = -1.0 if mirrored else 1.0
    rotation = np.array([[cos, sign * sin, 0], [-sin, sign * cos, 0], [0, 0, 1]])
    return (w @ rotation).astype(np.float32)
