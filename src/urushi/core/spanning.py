"""The choice of a few rows, from which all others can be composed."""

import numpy as np


def spanning(rows: np.ndarray, enough: float, most: int) -> tuple[list[int], np.ndarray]:
    """Choose rows until every row is nearly a linear combination of the chosen ones.

    The next row is the one that is farthest from all linear combinations of those before.

    Args:
        rows: (M, P).
        enough: distance from which on a row is near enough.
        most: largest number of chosen rows.

    Returns:
        Indices (n,) of the chosen rows, and the coordinates float64 (n, M) of all rows along n
        orthonormal axes of the chosen ones.
    """
    left, chosen, along = rows.copy(), list[int](), list[np.ndarray]()
    while len(chosen) < most:
        away = np.linalg.norm(left, axis=1)
        farthest = int(np.argmax(away))
        if away[farthest] < enough:
            break
        chosen.append(farthest)
        axis = left[farthest] / away[farthest]
        along.append(left @ axis)
        left -= along[-1][:, None] * axis
    return chosen, np.array(along, np.float64).reshape(len(chosen), len(rows))
