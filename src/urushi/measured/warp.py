"""Bilinear grids on the unit square, one per elevation and azimuth of wi, and their warps.

A warp makes the density of a grid uniform.

As in Mitsuba's Marginal2D (continuous) and the reference code of Dupuy and Jakob, "An adaptive
parameterization for efficient material acquisition and rendering", 2018.
"""

import numpy as np


def slices_at(
    nodes: tuple[np.ndarray, np.ndarray], theta: np.ndarray, phi: np.ndarray
) -> list[tuple[np.ndarray, np.ndarray]]:
    """The slices around each pair of angles (N,), each with its weight; clamped at the ends.

    nodes: elevations (T,), T >= 2, and azimuths (P,), strictly increasing. Slice p T + t belongs to
        azimuth p and elevation t.
    """
    columns = _between(nodes[0], theta)
    if len(nodes[1]) == 1:
        return columns
    return [
        (row * len(nodes[0]) + column, weight * share)
        for row, weight in _between(nodes[1], phi)
        for column, share in columns
    ]


def _between(nodes: np.ndarray, x: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """The two nodes around each x (N,), each with its weight."""
    lower = np.clip(np.searchsorted(nodes, x) - 1, 0, len(nodes) - 2)
    weight = np.clip((x - nodes[lower]) / (nodes[lower + 1] - nodes[lower]), 0, 1)
    return [(lower, 1 - weight), (lower + 1, weight)]


def bilinear(
    values: np.ndarray, u: np.ndarray, slices: list[tuple[np.ndarray, np.ndarray]]
) -> np.ndarray:
    """Values (N, channels) at u (N, 2) in [0, 1], between the given slices.

    values: (T, rows, columns, channels); u = (x along columns, y along rows).
    """
    (column, row), (x, y) = _cell(u, *values.shape[1:3])
    result = np.zeros((len(u), values.shape[3]))
    for s, weight in slices:
        for j, weight_j in ((row, 1 - y), (row + 1, y)):
            for i, weight_i in ((column, 1 - x), (column + 1, x)):
                result += (weight * weight_j * weight_i)[:, None] * values[s, j, i]
    return result


class Warp:
    """The warp of the uniform density on the unit square to a density that is bilinear on a grid.

    It acts along x given y (the conditional), then along y (the marginal). Between slices the
    densities and their integrals are interpolated, not the warps.
    """

    def __init__(self, density: np.ndarray) -> None:
        """density: (T, rows, columns), not negative, each slice with a positive integral."""
        density = density.astype(np.float64)
        along_x = _integrate(density)  # (T, rows, columns)
        along_y = _integrate(along_x[..., -1])  # (T, rows)
        total = along_y[:, -1]
        self._density = density / total[:, None, None]
        self._conditional = along_x / total[:, None, None]
        self._marginal = along_y / total[:, None]

    def invert(self, u: np.ndarray, slices: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
        """Return the points (N, 2) in [0, 1] that the warp maps to u (N, 2)."""
        rows, columns = self._density.shape[1:]
        (column, row), (x, y) = _cell(u, rows, columns)

        def at(table: np.ndarray, *index: np.ndarray) -> np.ndarray:
            return sum(weight * table[(s, *index)] for s, weight in slices)

        def between_rows(table: np.ndarray, i: np.ndarray) -> np.ndarray:
            return (1 - y) * at(table, row, i) + y * at(table, row + 1, i)

        # Integrals of the density: along the row up to u's x, along the whole row, and over all
        # rows below u's y.
        left, right = (between_rows(self._density, i) for i in (column, column + 1))
        part = between_rows(self._conditional, column) + x * (left + 0.5 * x * (right - left))
        last = np.full_like(column, columns - 1)
        whole = between_rows(self._conditional, last)
        lower, upper = (at(self._conditional, j, last) for j in (row, row + 1))
        below = at(self._marginal, row) + y * (lower + 0.5 * y * (upper - lower))

        empty = whole <= 0  # no density in this row: every x is mapped to the same point
        sample = np.stack([part / np.where(empty, 1.0, whole), below], 1)
        return np.clip(sample, 0, 1)


def _integrate(values: np.ndarray) -> np.ndarray:
    """Integrals from the first node to each node along the last axis, of linear pieces."""
    result = np.zeros_like(values)
    np.cumsum(0.5 * (values[..., 1:] + values[..., :-1]), axis=-1, out=result[..., 1:])
    return result


def _cell(u: np.ndarray, rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower (column, row) of the cell around each u, and the position in the cell."""
    last = np.array([columns - 1, rows - 1])
    position = np.clip(u, 0, 1) * last
    cell = np.minimum(position.astype(np.intp), last - 1)
    return cell.T, (position - cell).T
