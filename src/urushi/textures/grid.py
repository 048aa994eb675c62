"""The grid of texels of a latent texture: its resolution and its place in uv."""

from typing import NamedTuple

import numpy as np

#: Texture space equal to uv.
IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


class TexelGrid(NamedTuple):
    """Texels over the unit square of texture space."""

    width: int
    height: int
    # The affine map (2, 3) from uv to texture space.
    to_texture: tuple[tuple[float, float, float], tuple[float, float, float]] = IDENTITY
    wrap: str = "repeat"  # beyond the unit square: "repeat", "mirror" or "clamp"
    nearest: bool = False  # whether a look-up returns the nearest texel instead of interpolating

    @property
    def texels(self) -> int:
        """Number of texels."""
        return self.width * self.height

    def uv(self, start: int = 0, stop: int | None = None) -> np.ndarray:
        """The uv (M, 2) of the centres of texels start to stop - 1, in row-major order."""
        index = np.arange(start, self.texels if stop is None else stop)
        x = (index % self.width + 0.5) / self.width
        y = (index // self.width + 0.5) / self.height
        return from_texture(self.to_texture, np.stack([x, y], axis=-1))


#: The grid of what is the same everywhere.
MIDDLE = TexelGrid(1, 1)


def from_texture(to_texture: tuple, points: np.ndarray) -> np.ndarray:
    """The uv (M, 2) of points of texture space (M, 2)."""
    if to_texture == IDENTITY:
        return points
    matrix = np.array(to_texture)
    return np.linalg.solve(matrix[:, :2], (points - matrix[:, 2]).T).T
