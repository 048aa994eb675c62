"""Some of many rows, of which all others are sums."""

import numpy as np


def spanning(rows: np.ndarray, enough: float, most: int) -> tuple[list[int], np.ndarray]:
    """Rows whose sums are all rows, up to a norm of `enough`, and at most so many.

    The next row is always the farthest from sums of the chosen ones.

    Args:
        rows: (M, P).

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
