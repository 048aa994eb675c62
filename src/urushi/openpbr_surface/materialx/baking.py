"""Parameters that vary over the surface, as textures: an image's own texels, or a grid in uv."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from urushi.errors import FileError
from urushi.openpbr_surface.materialx.evaluation import CORNERS, PROBES, Evaluation, NeedsPosition
from urushi.openpbr_surface.materialx.graph import Graph

#: Bytes that the values of all nodes may take at once.
MEMORY = 1 << 27

#: Largest width and height of a texture that is computed on a grid.
MAX_RESOLUTION = 4096

#: A value of a graph: the evaluation at some points gives (..., channels).
Value = Callable[[Evaluation], np.ndarray]


@dataclass(frozen=True, eq=False)
class Texture:
    """A value on the surface: a number, as one pixel, or an image."""

    # (height, width, channels), the upper row first; linear sRGB; float32, but numbers not.
    pixels: np.ndarray
    # The map (3, 3) from the surface's uv to the texture's, both from the upper left as in Mitsuba.
    to_uv: np.ndarray
    wrap: str = "repeat"  # how it continues outside of [0, 1]: repeat, clamp or mirror
    blend: bool = True  # whether pixels are interpolated

    def map(self, function: Callable[[np.ndarray], np.ndarray]) -> "Texture":
        """The texture whose pixels are `function` of these pixels."""
        return Texture(function(self.pixels), self.to_uv, self.wrap, self.blend)

    @property
    def is_number(self) -> bool:
        """Whether it is no image; an image may have one pixel, too."""
        return self.pixels.dtype != np.float32

    @property
    def constant(self) -> np.ndarray | None:
        """The value (channels,) of all pixels; None if they differ."""
        first = self.pixels[0, 0]
        return first.astype(np.float64) if (self.pixels == first).all() else None


_WRAPS = {"periodic": "repeat", "repeat": "repeat", "clamp": "clamp", "mirror": "mirror"}


@np.errstate(all="ignore")  # what is not finite is refused
def bake(graph: Graph, value: Value, resolution: int, where: str) -> Texture:
    """A graph's value as a texture.

    A value that depends on one image, with an affine map of its coordinates, and on nothing else
    of the position, has that image's texels. All others are computed at the centres of a grid over
    [0, 1]^2, or over the tiles of images, with `resolution` rows and columns for each tile, or as
    many as the largest image has.
    """
    few = _few(graph)
    first = _finite(value(few), where)
    if first.ndim == 1:
        return Texture(first[None, None], np.eye(3))

    def computed(shape: tuple[int, ...], at: Callable[[np.ndarray], Evaluation]) -> np.ndarray:
        """Values (height, width, channels), float32; at: the evaluation at some indices."""
        most = max(64, MEMORY // (32 * max(few.size, 1)))  # points at once
        count, parts = shape[0] * shape[1], []
        for begin in range(0, count, most):
            index = np.arange(begin, min(begin + most, count))
            part = _finite(value(at(index)), where)
            parts.append(np.broadcast_to(part, (len(index), part.shape[-1])).astype(np.float32))
        return np.concatenate(parts).reshape(*shape, -1)

    # One texture with an affine map can replace one image.
    use = few.uses[0] if len(few.uses) == 1 else None
    if use and use.matrix and use.modes[0] == use.modes[1] and use.modes[0] in _WRAPS:
        texels = graph.images.values(use, where)
        flat = texels.reshape(-1, texels.shape[-1])

        def of_texels(k: np.ndarray) -> Evaluation:
            return Evaluation(graph, None, flat[k].astype(np.float64))

        try:
            pixels = computed(texels.shape[:2], of_texels)
            return Texture(pixels, _from_above(use.matrix), _WRAPS[use.modes[0]], use.blend)
        except NeedsPosition:
            pass
    images = [graph.images.read(use.file, where) for use in few.uses]
    tiled = [x for x in images if x.tiles != (1, 1)]
    corner = np.min([x.corner for x in tiled] or [(0, 0)], axis=0)  # the lower left one
    tiles = np.max([np.add(x.corner, x.tiles) for x in tiled] or [(1, 1)], axis=0) - corner
    sizes = [max(x.pixels.shape[:2]) for x in images]
    side = min(max([resolution * tiles.max(), *sizes]), MAX_RESOLUTION)

    def on_grid(k: np.ndarray) -> Evaluation:
        u, v = (k % side + 0.5) / side, 1 - (k // side + 0.5) / side
        return Evaluation(graph, corner + tiles * np.stack([u, v], -1))

    matrix = np.c_[np.diag(1 / tiles), -corner / tiles]
    return Texture(computed((side, side), on_grid), _from_above(matrix))


def _few(graph: Graph) -> Evaluation:
    """An evaluation at three corners and random points."""
    random = np.random.default_rng(0).random((PROBES - len(CORNERS), 2))
    return Evaluation(graph, np.concatenate([CORNERS, random]))


@np.errstate(all="ignore")
def changes(graph: Graph, value: Value) -> bool:
    """Whether a value is not zero everywhere, or cannot be computed."""
    try:
        return bool(value(_few(graph)).any())
    except FileError:
        return True


def _from_above(matrix: Any) -> np.ndarray:
    """The map (3, 3) of Mitsuba's uv for the rows (2, 3) of MaterialX's, whose v runs upwards."""
    flip = np.array([[1, 0, 0], [0, -1, 1], [0, 0, 1.0]])
    return flip @ np.array([*matrix, (0, 0, 1)]) @ flip


def _finite(value: np.ndarray, where: str) -> np.ndarray:
    if not np.isfinite(value).all() or np.abs(value).max(initial=0) > 1e30:
        raise FileError(f"{where} is not finite everywhere; check its nodes for divisions by zero")
    return value
