"""Normal maps of height fields."""

import numpy as np
import numpy.typing as npt


def normal_map(
    height: np.ndarray, length_u: npt.ArrayLike, length_v: npt.ArrayLike, *, closed: bool = False
) -> np.ndarray:
    """Normal map of a height field for Mitsuba's `normalmap`.

    Args:
        height: (H, W) heights above the surface, in its units; row 0 is at v = 0.
        length_u, length_v: lengths of the surface from u = 0 to 1 and from v = 0 to 1; numbers or
            arrays that broadcast to (H, W).
        closed: whether the texture repeats in u, as around a turned shape.

    Returns:
        (H, W, 3) float32 in [0, 1]: 0.5 + 0.5 n for normals n.
    """
    rows, columns = height.shape
    wide = np.pad(height, ((0, 0), (1, 1)), mode="wrap" if closed else "edge")
    tall = np.pad(height, ((1, 1), (0, 0)), mode="edge")
    slope_u = (wide[:, 2:] - wide[:, :-2]) * (columns / 2) / length_u
    slope_v = (tall[2:] - tall[:-2]) * (rows / 2) / length_v
    normal = np.stack([-slope_u, -slope_v, np.ones_like(height)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return (0.5 + 0.5 * normal).astype(np.float32)
