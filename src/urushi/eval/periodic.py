"""Looking up pictures whose columns close into a circle: environments, and spheres by azimuth."""

import numpy as np


def bilinear(image: np.ndarray, row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Values (..., C) between the pixels of image (H, W, C).

    row (...): in [0, H - 1], the first row's pixels at 0; column (...): any, of period W, the first
    column's pixels at 0.
    """
    rows, columns = image.shape[:2]
    above, left = np.floor(row).astype(np.intp), np.floor(column).astype(np.intp)
    down, right = (row - above)[..., None], (column - left)[..., None]
    below = np.minimum(above + 1, rows - 1)
    left, beside = left % columns, (left + 1) % columns
    upper = image[above, left] * (1 - right) + image[above, beside] * right
    lower = image[below, left] * (1 - right) + image[below, beside] * right
    return upper * (1 - down) + lower * down
