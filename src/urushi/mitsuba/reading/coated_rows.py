"""A coat over a bottom at rows of values of the parameters that vary: light transport there."""

from collections.abc import Mapping, Sequence

import mitsuba as mi
import numpy as np

from urushi import checks
from urushi.checks import MIN_ALPHA, MIN_INDEX_STEP, CoatParameters
from urushi.core.microfacet import of_widths
from urushi.core.table import node_pairs
from urushi.material.coated_table import rest_at_nodes
from urushi.material.coated_values import passed_twice
from urushi.material.layer import check_ratios
from urushi.material.substrate import Substrate
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading.bottoms import Layer
from urushi.mitsuba.reading.parameters import TWO_WIDTHS
from urushi.mitsuba.reading.rows import BottomRows, NestedRows
from urushi.mitsuba.reading.wavelengths import (
    NANOMETRES,
    WAVELENGTH,
    WAVELENGTHS,
    along_u,
    wavelength_ends,
    wavelengths_of,
    wavelengths_varying,
)
from urushi.nets.weights import Model
from urushi.textures.axes import Varying
from urushi.textures.layering import transported_rests


class CoatedRows:
    """A coat over a bottom at rows of values, of `varying` and then of constants."""

    def __init__(
        self,
        model: Model,
        layer: Layer,
        bottoms: BottomRows | NestedRows,
        varying: Sequence[Varying],
        led: Sequence[Varying],
        constants: Sequence[Varying],
    ):
        """led: those that follow others. constants: those that change."""
        self._model, self._layer, self._bottoms = model, layer, bottoms
        self.varying = list(varying)  # and the wavelength, where the material changes with it
        self._led = {x.axis.name: x.leader for x in led if x.leader is not None}
        self._changing = [x.axis.name for x in constants]
        self._known = {x.axis.name for x in (*varying, *led)}
        same = all((x == x[:1]).all() for n, x in layer.numbers.items() if n not in self._known)
        grey = same and bottoms.is_grey()
        self._channels = 1 if grey or mi.is_spectral else spectrum.channel_count()
        if mi.is_spectral and not grey and WAVELENGTH not in self._known:
            nm = np.linspace(
                *wavelength_ends([layer.nested, *layer.coat.textures.values()]), WAVELENGTHS + 1
            )
            self.varying.append(wavelengths_varying(nm, self._spectral_changes(nm)))

    def _spectral_changes(self, wavelengths: np.ndarray) -> np.ndarray:
        """Amounts (N,) by which the material changes between wavelengths (N + 1,)."""
        count = len(wavelengths) - 1
        middle = [x.axis.values(np.array(0.5)) for x in self.varying]
        named = self._named(np.tile([*middle, *[0.0] * len(self._changing)], (count + 1, 1)))
        named[NANOMETRES] = wavelengths
        changes = self._bottoms.spectral_changes(count, named)
        for column in self._columns(named, count + 1):
            changes = changes + np.abs(np.diff(column[0]))
        return changes

    def _named(self, values: np.ndarray) -> dict[str, np.ndarray]:
        names = [*(x.axis.name for x in self.varying), *self._changing]
        named = dict(zip(names, values.T, strict=True))
        named |= {name: leader.at(named[leader.name]) for name, leader in self._led.items()}
        for x in self.varying:
            if x.places is not None:
                named[NANOMETRES] = np.interp(named[WAVELENGTH], *x.places)
        return named

    def coats(self, values: np.ndarray) -> CoatParameters:
        """The coats, arrays (C, k), see `textures.point_codes.Rows`."""
        alpha, *others = self._columns(self._named(values), len(values))
        if self._layer.coat.is_anisotropic:
            return CoatParameters(checks.Widths(alpha, others[0]), *others[1:])
        wide = checks.Widths(alpha, alpha) if self._model.widths == 2 else alpha
        return CoatParameters(wide, *others)

    def _columns(self, named: Mapping[str, np.ndarray], count: int) -> list[np.ndarray]:
        """The coats' parameters (C, count)."""
        found = self._layer.numbers
        if mi.is_spectral:
            with wavelengths_of(named, count):
                found = self._layer.coat.numbers(along_u(count))
        columns = []
        for name, own in found.items():
            column = named[name][None] if name in self._known else own[: self._channels]
            column = column.astype(np.float64)
            if name in self._changing:
                column = column + named[name]
            if name in ("alpha", *TWO_WIDTHS):  # a black map of one value, or one that follows
                column = np.maximum(column, np.float32(MIN_ALPHA))
            if name == "eta":
                column = np.where(np.abs(column - 1) < MIN_INDEX_STEP, 1, column)
            columns.append(np.broadcast_to(column, (self._channels, count)))
        return columns

    def transported(self, values: np.ndarray) -> tuple[np.ndarray, float]:
        """f (C, k, P) [1/sr] without the lobe of the coat, see `textures.point_codes.Rows`."""
        below, places, coat = self._coated(values)
        flat = CoatParameters(of_widths(np.ravel, coat.alpha), *map(np.ravel, coat[1:]))
        rests = transported_rests(self._model, below, places.ravel(), flat)
        return rests.reshape(*places.shape, -1), float(below.ceiling.max())

    def tables(self, values: np.ndarray, channels: np.ndarray) -> np.ndarray:
        """g (k, N) [1/sr] of channels (k,) at the nodes, see `textures.point_codes.Rows`."""
        below, places, coat = self._coated(values)
        at = channels, np.arange(len(channels))
        own = CoatParameters(*(x[at] for x in coat))
        factor = passed_twice(own, *node_pairs())
        return rest_at_nodes(below, places[at], np.stack(own[:2]), np.stack(own[2:]), factor).T

    def _coated(self, values: np.ndarray) -> tuple[Substrate, np.ndarray, CoatParameters]:
        """The bottoms, the place of each (C, k), and its coat, arrays (C, k)."""
        coat = self.coats(values)
        below, places = self._bottoms.substrate(self._named(values), self._channels)
        check_ratios(self._model, below.reflector.lobe, coat)
        return below, np.broadcast_to(places, (self._channels, len(values))), coat
