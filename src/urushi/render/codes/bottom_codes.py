"""The latent codes of a bottom, the same everywhere or texel by texel: the first stage of baking.

A textured bottom is probed where it is new only: a few probes tell each texel's key, texels of
equal keys have equal codes, and after a change those whose keys are as before keep theirs.
"""

import mitsuba as mi
import numpy as np

from urushi.material import keys, packing
from urushi.material.encode import encode_values, seen_pairs
from urushi.material.energy import limit
from urushi.material.store import Store
from urushi.material.texture import encode_texels, encoded
from urushi.nets.weights import Model
from urushi.render import spectrum
from urushi.render.reading import probing
from urushi.render.reading.grid import Grid, varying_textures

#: Texels that are compared and encoded at once, and that are probed at once: both bound memory.
TEXELS, PROBED = 1 << 18, 1 << 13

#: Of the probe pairs, every so manieth tells a texel's key.
STRIDE = 24

#: Classes of measured BSDFs, Urushi's and Mitsuba's own: their codes are refined, because no
#: training data are quite like them.
MEASURED = ("MeasuredBRDF", "Measured")


class BottomCodes:
    """A bottom's codes; `update` makes them, and makes them anew after a change."""

    def __init__(self, model: Model, bottom: "mi.BSDF", where: str):
        self._model, self._bottom, self._where = model, bottom, where
        self._grid: Grid | None = None
        self._codes: np.ndarray | Store = np.zeros((1, 1, 1), np.float32)
        self._keys = np.zeros((1, 1), np.uint64)

    def update(self, grid: Grid | None) -> None:
        """Encode what is not as it was when this was last called, with the same grid.

        Raises:
            ParameterError: the bottom gives what no BRDF gives.
        """
        nested = nested_latents(self._bottom, self._model)
        if nested is not None and nested.resolution is None:
            self._keep_same(nested.at(np.full((1, 2), 0.5)))
        elif grid is not None and (nested is not None or varying_textures(self._bottom)):
            self._update_texels(grid, nested)
        else:
            self._keep_same(self._encoded()[None])

    def read(self, start: int, stop: int) -> tuple[np.ndarray, np.ndarray]:
        """Keys (n or 1, C) and codes (n or 1, C, size) of a range of texels."""
        if isinstance(self._codes, np.ndarray):
            return self._keys, self._codes
        return self._keys[start:stop], self._codes.read(slice(start, stop))

    def _encoded(self) -> np.ndarray:
        """Codes (C, size) of a bottom that is the same everywhere."""
        model = self._model
        if self._bottom.class_name() in MEASURED:
            pairs = seen_pairs(self._bottom, model)
            f = probing.read(self._bottom, *pairs, self._where)
            return encode_values(f, model, refine=True).anchors
        f = probing.read(self._bottom, *model.networks.pairs(), self._where)
        return encode_texels(model, f.T)

    def _probed(self, grid: Grid) -> "_Probed":
        return _Probed(self._model, self._bottom, self._where, grid)

    def _keep_same(self, codes: np.ndarray) -> None:
        """One code a channel, (1, C, size)."""
        self._codes, self._grid = codes, None
        self._keys = keys.of(list(np.moveaxis(codes, -1, 0)))

    def _update_texels(self, grid: Grid, nested) -> None:
        channels = spectrum.channel_count()
        if self._grid != grid:
            self._grid = grid
            layout = packing.layout(self._model, channels)
            self._codes = Store(self._model, layout, grid.width, grid.height)
            self._keys = np.zeros((grid.texels, channels), np.uint64)
        assert isinstance(self._codes, Store)
        if self._codes.empty:
            self._keys[:] = 0  # an error ended the last attempt
        source = _Nested(nested) if nested else self._probed(grid)
        with self._codes.writing() as write:
            for start in range(0, grid.texels, TEXELS):
                stop = min(start + TEXELS, grid.texels)
                uv = grid.uv(start, stop)
                present = source.keys(uv)
                rows = np.flatnonzero((present != self._keys[start:stop]).any(axis=1))
                if len(rows):
                    write(start + rows, source.codes(uv[rows], present[rows]))
                self._keys[start:stop] = present


def nested_latents(bottom: "mi.BSDF", model: Model):
    """The codes below a coat of a bottom that has codes of the same networks, or None."""
    nested = getattr(bottom, "latents", None)
    if nested is None or bottom.model.fingerprint != model.fingerprint:
        return None
    if nested.channels != spectrum.channel_count():
        return None
    return getattr(nested, "anchors", nested)


class _Nested:
    """Codes that the bottom has already."""

    def __init__(self, latents):
        self._latents = latents

    def keys(self, uv: np.ndarray) -> np.ndarray:
        """Keys (M, C) at points uv (M, 2)."""
        return keys.of(list(np.moveaxis(self._latents.at(uv), -1, 0)))

    def codes(self, uv: np.ndarray, present: np.ndarray) -> np.ndarray:
        """Codes (M, C, size) at points uv (M, 2)."""
        return self._latents.at(uv)


class _Probed:
    """Codes from evaluating the bottom."""

    def __init__(self, model: Model, bottom: "mi.BSDF", where: str, grid: Grid):
        self._model, self._bottom, self._where = model, bottom, where
        self._pairs = model.networks.pairs()
        self._average = probing.needed_average(bottom, *self._pairs, grid, where)

    def keys(self, uv: np.ndarray) -> np.ndarray:
        """Keys (M, C) at points uv (M, 2): equal where the bottom is."""
        wi, wo = self._pairs
        if self._average.repeats > 1:  # it draws random numbers: what it gives tells nothing
            shape = len(uv), spectrum.channel_count()
            return np.random.default_rng().integers(1 << 63, size=shape).astype(np.uint64)
        f = probing.over_points(self._bottom, wi[::STRIDE], wo[::STRIDE], uv, probing.Average())
        return keys.of(list(np.moveaxis(f, -1, 0)))

    def codes(self, uv: np.ndarray, present: np.ndarray) -> np.ndarray:
        """Codes (M, C, size) at points uv (M, 2) with keys (M, C)."""
        channels = present.shape[1]
        texel, texel_of = keys.distinct(keys.of(list(present.T)))
        row, row_of = keys.distinct(present[texel].ravel())
        parts = []
        for start in range(0, len(texel), PROBED):
            points = uv[texel[start : start + PROBED]]
            f = probing.over_points(self._bottom, *self._pairs, points, self._average)
            f = probing.checked(f, self._where).reshape(len(points) * channels, -1)
            first = start * channels
            own = row[slice(*np.searchsorted(row, [first, first + len(f)]))]
            parts.append(encoded(self._model, f[own - first]))
        codes = limit(self._model, np.concatenate(parts))
        return codes[row_of].reshape(len(texel), channels, -1)[texel_of]
