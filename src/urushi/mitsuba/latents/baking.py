"""Latent codes of a coat over a Mitsuba BSDF, constant or a texture.

`Baker.update` is the whole journey: choose the grid of texels, read the bottom (`bottoms`), read
the coat's parameters at every texel, and layer (`textures.bake`). Each stage remembers its inputs
and repeats only the work for inputs that have changed.
"""

from collections.abc import Iterator
from functools import partial

import mitsuba as mi
import numpy as np
from tqdm import tqdm

from urushi import checks
from urushi.checks import CoatParameters
from urushi.material.layer import layer_material
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.bottoms import BottomCodes, nested_latents
from urushi.mitsuba.latents.holders import ConstantLatents, TexturedLatents
from urushi.mitsuba.reading import grid as grids
from urushi.mitsuba.reading.offers import tabulated
from urushi.mitsuba.reading.parameters import CoatTextures
from urushi.nets.weights import Model
from urushi.textures.bake import TEXEL_BLOCK, BakedTexture, coat_source
from urushi.textures.layering import layer_rows
from urushi.textures.store import MIDDLE, TexelGrid

#: Seconds of baking before progress is shown, and between two reports.
PROGRESS_DELAY = 3.0


class Baker:
    """The codes of a coat over a bottom; `update` computes them, and again after a change."""

    def __init__(self, model: Model, coat: CoatTextures, bottom: "mi.BSDF", resolution: int):
        """Prepare a coat; nothing is evaluated before `update`.

        resolution: texels per side of a latent texture, 0 to choose.
        """
        self.model, self._coat, self._bottom = model, coat, bottom
        self._resolution = resolution
        self.bottom = BottomCodes(model, bottom, coat.where)
        self._grid: TexelGrid | None = None
        self._texture: BakedTexture | None = None
        self.absorbs = False  # whether the coat has no interface and does not scatter, anywhere

    def update(self, bottom_changed: bool = True) -> ConstantLatents | TexturedLatents:
        """The codes for the current parameters; in a texture, only changed rows are layered.

        bottom_changed: whether the bottom may have changed since the last call.

        Warns:
            UrushiWarning: codes of a coat outside the network's training data are rendered.
        """
        grid = choose_grid(self._coat, self._bottom, self.model, self._resolution)
        with spectrum.bands_of(grid):
            if grid != self._grid:
                self._texture = None
            if bottom_changed or grid != self._grid or (grid and not self._texture):
                self.bottom.open(grid)
            self._grid = grid
            left, self.absorbs = self._survey(grid or MIDDLE)
            latents = self._constant() if grid is None else self._textured(grid)
        if tabulated(latents) is None:
            checks.warn_of_training(left, f"{self._coat.where}:")
        return latents

    def _constant(self) -> ConstantLatents:
        """The codes of a coat and a bottom without textures."""
        coat = self._coat.layering(np.full((1, 2), 0.5))
        bottom = self.bottom.material
        assert bottom is not None  # for the type checker
        columns = [column[0] for column in coat.columns()]
        return ConstantLatents(layer_material(CoatParameters.of_columns(columns), bottom))

    def _textured(self, grid: TexelGrid) -> TexturedLatents:
        """The codes of all texels."""
        channels = spectrum.channel_count()
        texture = self._texture or BakedTexture(self.model, grid, channels)
        with self._progress(grid) as bar:
            self.bottom.bake(bar.update)
            source = coat_source(partial(self._parameters, grid), self.bottom.source)
            texture.update(source, bar.update, partial(layer_rows, self.model))
        self._texture = texture
        return TexturedLatents(self.model, texture.store, grid)

    def _parameters(self, grid: TexelGrid, start: int, stop: int) -> CoatParameters:
        """The coats at a range of texels, or at one if they do not vary."""
        varies = any(map(grids.varying_textures, self._coat.textures.values()))
        return self._coat.layering(grid.uv(start, stop if varies else start + 1))

    def _survey(self, grid: TexelGrid) -> tuple[set[str], bool]:
        """The trained ranges that the coat leaves, and whether it absorbs alone, at all texels."""
        left, absorbs = set(), True
        for start, stop in _blocks(grid):
            coat = self._parameters(grid, start, stop)
            left |= checks.outside_training(coat)
            absorbs &= bool(((coat.eta == 1) & (coat.albedo == 0)).all())
        return left, absorbs

    def _progress(self, grid: TexelGrid) -> tqdm:
        """A progress bar on stderr, in files too, of a baking that takes longer than a moment."""
        return tqdm(
            total=grid.texels * (1 + self.bottom.stored),
            desc=f"{self._coat.where}: {grid.width} x {grid.height} texels are baked (a lower "
            "'resolution' is faster)",
            unit=" texels",
            unit_scale=True,
            delay=PROGRESS_DELAY,
            mininterval=PROGRESS_DELAY,
        )


def choose_grid(
    coat: CoatTextures, bottom: "mi.BSDF", model: Model, resolution: int
) -> TexelGrid | None:
    """The grid of a coat's codes over a bottom; None: they are the same everywhere."""
    grids.check_normals(bottom, coat.where)
    nested = nested_latents(bottom, model)
    below = {} if nested is not None else {"the nested BSDF": bottom}
    inner = nested.grid if nested is not None else None
    return grids.choose({**coat.textures, **below}, inner, resolution, coat.where)


def check(coat: CoatTextures) -> None:
    """Check the coat's parameters over uv; the walk clips the others at each point."""
    over_uv = {
        name: texture for name, texture in coat.textures.items() if not grids.not_over_uv(texture)
    }
    elsewhere = coat.textures.keys() - over_uv.keys()
    grid = grids.choose(over_uv, None, 0, coat.where)
    if grid is None:
        coat.table(np.full((1, 2), 0.5), elsewhere)
        return
    for start, stop in _blocks(grid):
        coat.table(grid.uv(start, stop), elsewhere)


def _blocks(grid: TexelGrid) -> Iterator[tuple[int, int]]:
    """Ranges of texels that are read at once."""
    for start in range(0, grid.texels, TEXEL_BLOCK):
        yield start, min(start + TEXEL_BLOCK, grid.texels)
