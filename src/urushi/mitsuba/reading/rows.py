"""What lies below a coat at rows of values of its parameters that vary.

Rows are evaluated by one BSDF whose parameters are textures of the values along u.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from itertools import product
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core.table import SHAPE
from urushi.material.material import Material
from urushi.material.reflector import Reflector
from urushi.material.substrate import Substrate, of_material
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.over_axes import AxisLatents, without_faint
from urushi.mitsuba.reading import bottoms, probing
from urushi.mitsuba.reading.bottoms import Layer
from urushi.mitsuba.reading.changed import derived, relative_to, replaced
from urushi.mitsuba.reading.grid import not_over_uv
from urushi.mitsuba.reading.parameters import Medium
from urushi.mitsuba.reading.probing import known_surface
from urushi.mitsuba.reading.varying import BOTTOM, INSIDE, TINT
from urushi.mitsuba.reading.wavelengths import NANOMETRES, WAVELENGTH, along_u, wavelengths_of
from urushi.nets.weights import Model
from urushi.textures.axes import Varying
from urushi.textures.layering import different
from urushi.textures.point_codes import FAINT

#: Bottoms whose tables are computed at once: bounds memory.
BLOCK = 48

#: Points of uv at which a bottom of values is compared, and its greatest relative error there.
COMPARED, TOLERANCE = 256, 2e-3

#: Relative change of f with the wavelength up to which a bottom is grey.
GREY = 1e-4

#: [1/sr] Least g of a nested coat, see `nets.transmittance`.
BLACK = 1e-8

#: Least values of colours and of tints: black has no tint.
LEAST_COLOR, LEAST_TINT = 1e-4, 1e-3

#: Index of a coat to which the numbers of a bottom's parameters are relative.
INDEX = "eta"


class NestedRows:
    """A nested coat whose codes vary along axes, at rows of values."""

    def __init__(self, latents: AxisLatents):
        self._latents = latents

    def is_grey(self) -> bool:
        """Whether rows of values reflect alike in all channels, or at all wavelengths."""
        return self._latents.baked.channels == 1

    def spectral_changes(self, count: int, values: Mapping[str, np.ndarray]) -> np.ndarray:
        """See `BottomRows`."""
        return np.zeros(count)

    def substrate(
        self, values: Mapping[str, np.ndarray], channels: int
    ) -> tuple[Substrate, np.ndarray]:
        """See `BottomRows`."""
        own = {
            name.removeprefix(BOTTOM): x[None]
            for name, x in values.items()
            if name.startswith(BOTTOM) or name == WAVELENGTH
        }
        codes, baked = self._latents.codes(own), self._latents.baked
        model = baked.extended
        if model.widths == 2:
            return different(model, without_faint(baked.model, model, codes))
        flat, shape = codes.reshape(-1, codes.shape[-1]), codes.shape[:2]
        logs = model.networks.table(flat)
        assert logs is not None  # g is at least `FAINT`
        logs = np.log(np.maximum(np.exp(logs) - FAINT, BLACK))
        found = Substrate.of(Reflector.of_logs(logs, flat[:, : model.arch.lobe]))
        return found, np.arange(len(flat)).reshape(shape)


class BottomRows:
    """A bottom at rows of values of its varying parameters."""

    def __init__(self, model: Model, layer: Layer, varying: Sequence[Varying]):
        """varying: the bottom's own parameters."""
        self._model, self._layer, self._varying = model, layer, varying
        self._where = layer.coat.where
        self._names = [x.axis.name for x in varying]

    @classmethod
    def of(cls, model: Model, layer: Layer, varying: Sequence[Varying]) -> "BottomRows | None":
        """The rows, if they reflect as the bottom does where it has their values."""
        plain = cls(model, layer, varying)
        if not varying:
            return plain
        if not_over_uv(*(x.texture for x in varying if x.texture)):
            some = {x.axis.name: np.array([x.axis.least]) for x in varying}
            return None if plain._at(some) is None else plain
        uv = np.random.default_rng(0).random((COMPARED, 2))
        wi, wo = (x[::8] for x in model.networks.pairs())
        rows = {
            x.axis.name: np.zeros((1, COMPARED)) if x.changes else spectrum.channels_at(uv, x.read)
            for x in varying
        }
        f = probing.texel_values(layer.below, wi, wo, uv)
        for channel in range(f.shape[1]):
            at = plain._at({n: x[min(channel, len(x) - 1)] for n, x in rows.items()}, channel)
            if at is None:
                return None
            own = probing.texel_values(at, wi, wo, along_u(COMPARED))
            error = np.abs(own[:, channel] - f[:, channel]).sum()
            if error > TOLERANCE * max(f[:, channel].sum(), 1e-9):
                return None
        return plain

    def is_grey(self) -> bool:
        """Whether rows of values reflect alike in all channels, or at all wavelengths."""
        sides = [(0.0, 0.0) if x.changes else (x.axis.least, x.axis.most) for x in self._varying]
        ends = list(product(*sides))[:16]
        columns = dict(zip(self._names, np.array(ends).T, strict=True)) if self._names else {}
        pairs, uv = self._model.networks.pairs(), along_u(len(ends))

        def read(bsdf: Any, kept: slice) -> Sequence[np.ndarray]:
            # Its table may have colours that codes leave out.
            bsdf = known_surface(bsdf).table_source() or bsdf
            return [np.moveaxis(probing.texel_values(bsdf, *pairs, uv, kept=kept), 1, 0)]

        (f,) = self._channels(columns, read, spectrum.channel_count())
        return bool(np.allclose(f, f[:1], rtol=GREY, atol=1e-9))

    def spectral_changes(self, count: int, values: Mapping[str, np.ndarray]) -> np.ndarray:
        """Amounts (count,) by which ln f changes between the wavelengths.

        values: (count + 1,) of the parameters by name, all the same, and the wavelengths.
        """
        with wavelengths_of(values, count + 1):
            pairs, uv = self._model.networks.pairs(), along_u(count + 1)
            f = probing.texel_values(self._at(values), *pairs, uv)[:, 0]
        logs = np.log(np.maximum(f, 1e-6))
        return np.abs(np.diff(logs, axis=0)).mean(axis=1)

    @cached_property
    def _material(self) -> Material | None:
        """The material of a bottom that is the same everywhere and at all wavelengths."""
        if self._varying or mi.is_spectral:
            return None
        return bottoms.bottom_material(self._model, self._layer.below, self._where)

    def _channels(
        self,
        rows: Mapping[str, np.ndarray],
        read: Callable[[Any, slice], Sequence[np.ndarray]],
        channels: int,
    ) -> list[np.ndarray]:
        """The arrays (C, ...) that `read` gives of some channels of BSDFs, for all channels."""
        if mi.is_spectral or not any(name.endswith(TINT) for name in self._names):
            return [*read(self._at(rows), slice(channels))]
        each = (read(self._at(rows, c), slice(c, c + 1)) for c in range(channels))
        return [np.concatenate(parts) for parts in zip(*each, strict=True)]

    def _at(self, rows: Mapping[str, np.ndarray], channel: int = 0) -> Any:
        """The BSDF whose varying parameters have rows (k,) of values along u, by their names.

        None if the bottom is of an unknown kind, which `of` finds.

        channel: that has the values of colours beside which there are tints; in spectral variants
            it is the wavelength that is read.
        """
        coat, nested = self._layer.coat, self._layer.nested
        textures, numbers = dict[int, Any](), {}
        medium: Medium = coat
        for x in self._varying:
            name, row = x.axis.name, rows[x.axis.name]
            if name.endswith(TINT):
                continue
            if x.texture:
                own = texels(row)
                if name + TINT in rows:
                    parts = {"value": own, "tint": texels(rows[name + TINT])}
                    own = derived(partial(_tinted, 0 if mi.is_spectral else channel), parts)
                if x.changes:
                    parts = {"value": x.texture, "change": own}
                    own = derived(lambda si, active, a, b: a + b, parts)
                textures[id(x.texture)] = own
            elif name in (INDEX, INSIDE):
                index = texels(row + (x.axis.least if x.changes else 0.0))
                medium = Medium(coat.index_above if name == INDEX else 1.0, index)
            else:  # a number: it changes in all rows alike
                numbers[name.removeprefix(BOTTOM)] = x.axis.least + row[0]
        if not (textures or numbers):
            return self._layer.below if medium is coat else relative_to(nested, medium)
        found = replaced(nested, lambda x: textures.get(id(x), x), numbers)
        return None if found is None else relative_to(found, medium)

    def substrate(
        self, values: Mapping[str, np.ndarray], channels: int
    ) -> tuple[Substrate, np.ndarray]:
        """The bottoms of rows (k,) of values, and the place of each among them.

        The places are (channels, k), or (1, k) if all channels have the same.
        """
        if self._material is not None:
            whole = of_material(self._material)
            places = np.repeat(np.arange(channels)[:, None], _count(values), axis=1)
            return whole, places % whole.channels
        rows, which = self._distinct(values)
        count, model, parts = _count(rows), self._model, list[list[np.ndarray]]()
        for start in range(0, count, BLOCK):
            some = {name: x[start : start + BLOCK] for name, x in rows.items()}
            uv = along_u(_count(some))

            def read(bsdf: Any, kept: slice, uv: np.ndarray = uv) -> Sequence[np.ndarray]:
                if model.widths == 2 or known_surface(bsdf).lobe_only:
                    codes = bottoms.probed_codes(model, bsdf, uv, self._where, kept, bounded=True)
                    return [np.moveaxis(codes, 1, 0)]
                return bottoms.probed_tables(model, bsdf, uv, self._where, kept)

            with wavelengths_of(some, len(uv)):
                parts.append(self._channels(some, read, channels))
        found, *lobes = (np.concatenate(x, axis=1) for x in zip(*parts, strict=True))
        if found.ndim == 3:  # codes
            return different(model, found[:, which])
        table = found.reshape(channels * count, *SHAPE)
        top = lobes[0].reshape(channels * count, -1) if lobes else None
        below = Substrate.of(Reflector.of_logs(np.moveaxis(table, 0, -1), top))
        return below, np.arange(channels)[:, None] * count + which

    def _distinct(
        self, values: Mapping[str, np.ndarray]
    ) -> tuple[dict[str, np.ndarray], np.ndarray]:
        """Different rows, and the place (k,) of each row among them."""
        names, default = [*self._names, NANOMETRES], np.full(_count(values), spectrum.RGB[1])
        own = np.stack([values.get(name, default) for name in names])
        found, which = np.unique(own, axis=1, return_inverse=True)
        return dict(zip(names, found, strict=True)), which.ravel()


def rows_of(
    model: Model, layer: Layer, varying: Sequence[Varying]
) -> BottomRows | NestedRows | None:
    """The bottom of a layer at rows of values; None: its parameters are not known.

    varying: parameters of the layer.
    """
    nested = bottoms.nested_latents(layer.below, model)
    if isinstance(nested, AxisLatents):
        return NestedRows(nested)
    # A conductor depends on the index inside the coat. That index follows from `eta`, unless the
    # index above the coat changes too: then it is a parameter of its own.
    relative = nested is None and layer.relative
    index = INDEX if relative and layer.coat.changing_indices == (True, False) else INSIDE
    own = [x for x in varying if x.axis.name.startswith(BOTTOM) or x.axis.name == index]
    return BottomRows.of(model, layer, own)


def _tinted(channel: int, si, active, value, tint) -> "mi.Spectrum":
    """A colour of which one channel has a value, and a tint: the value over the luminance.

    The other channels are equal, and negative where no colour has the tint.
    """
    only = mi.Spectrum(*(float(c == channel) for c in range(dr.size_v(mi.Spectrum))))
    share, whole = (spectrum.luminance(x, si.wavelengths) for x in (only, mi.Spectrum(1)))
    own = dr.maximum(value[channel], LEAST_COLOR)
    light = own / dr.maximum(tint[channel], LEAST_TINT)
    return dr.select(only > 0, own, (light - share * own) / (whole - share))


def _count(rows: Mapping[str, np.ndarray]) -> int:
    """Number of rows."""
    return len(next(iter(rows.values())))


def texels(values: np.ndarray) -> "mi.Texture":
    """A texture of values along u."""
    data = mi.Bitmap(np.array(values, np.float32).reshape(1, -1, 1))
    options = {"raw": True, "filter_type": "nearest", "wrap_mode": "clamp"}
    return mi.load_dict({"type": "bitmap", "bitmap": data, **options})
