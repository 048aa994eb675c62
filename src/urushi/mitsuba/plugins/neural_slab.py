"""The plugin `neural_layered` over what transmits light: a slab by tables, without noise."""

import itertools
import math
from functools import partial
from typing import Any, ClassVar, NoReturn

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.core.mixture import Mixture
from urushi.core.namespace import DRJIT
from urushi.core.table import MIN_COSINE, SHAPE, coordinates
from urushi.errors import ParameterError
from urushi.material.slab_coordinates import (
    PASSED_SHAPE,
    grazing_factor,
    mirrored_inside,
    passed_coordinates,
)
from urushi.material.slab_table import AROUND, SlabTables
from urushi.mitsuba import spectrum
from urushi.mitsuba.frames import SlabMixture, above_surface, raised
from urushi.mitsuba.plugins.coated import CoatedSurface
from urushi.mitsuba.plugins.stack import CoatStack, quantiles
from urushi.mitsuba.reading.slab_layers import SlabLayers
from urushi.mitsuba.recording import only_where
from urushi.mitsuba.snapshot import is_attached, writable
from urushi.mitsuba.tables import Interpolated, Numbers, interpolated, stored
from urushi.textures.axes import DARK, Axis, simplex
from urushi.textures.slabs import AXES, bake
from urushi.walk import interface

#: Quantiles of the half angles at which lobes are sampled, and the weights of these lobes and of a
#: cosine lobe. The first is for a narrow lobe that has a small part of the light.
QUANTILES, WEIGHTS = (0.03, 0.25, 0.5, 0.8), (0.12, 0.3, 0.28, 0.2, 0.1)

#: By which a quantile of the tangents of a GGX lobe is its width.
OF_QUANTILES = (1 / np.array(QUANTILES) - 1) ** 0.5

#: Cosines for which proposals are computed, and the least and largest share of reflected samples.
ELEVATIONS, SHARES = 33, (0.03, 0.97)


def _lobes(tables: SlabTables) -> np.ndarray:
    """Proposals (2, `ELEVATIONS`, 9), of each side and the root of the cosine of wi.

    The share that is reflected, within `SHARES`; and widths at `QUANTILES` of the half angles, of
    reflected light and of transmitted light, as `stack.BottomLobes`.
    """
    cosine = np.maximum(np.linspace(0, 1, ELEVATIONS) ** 2, MIN_COSINE)
    found = []
    for side in [1, -1][: 1 if tables.reflected[0] is tables.reflected[1] else 2]:
        wi = np.stack([(1 - cosine**2) ** 0.5, 0 * cosine, side * cosine], axis=-1)
        both = [(tangents, power.mean(axis=-1)) for tangents, power in tables.powers(wi, AROUND)]
        reflected, passed = (power.sum(axis=1) for _, power in both)
        shares = (reflected / (reflected + passed)).clip(*SHARES)
        widths = np.concatenate([quantiles(*x, QUANTILES) * OF_QUANTILES for x in both], axis=1)
        found.append(np.column_stack([shares, widths.clip(MIN_ALPHA / 4, 1)]))
    return np.stack([found[0], found[-1]]).astype(np.float32)


class NeuralSlab(CoatedSurface):
    """A slab by tables, along the axes of what varies; see ``layered``."""

    UNRECORDED: ClassVar = ("_layers", "_baked")
    _baked: SlabLayers | None = None  # the layers of which there are tables

    def _prepare(self):
        """Compute the tables."""
        super()._prepare()
        layers: list[Any] = [*self.coats] if self.lowest is None else [*self.coats, self.lowest]
        if any(x.is_anisotropic for x in layers) or any(x.coloured for x in self.coats):
            self._refuse("a slab has a table for one width of each interface")
        attached = (key for key, value in writable(self) if is_attached(value))
        changing = [x for coat in self.coats for x in coat.changing_indices]
        if any(changing) or any(key.endswith("eta") for key in attached):
            self._refuse("an index of refraction varies, but tables of a slab are of constant ones")
        si = dr.zeros(mi.SurfaceInteraction3f)
        beyond = self._lowest_at(CoatStack(self.coats, si, True), si, True)
        lowest = None if self.lowest is None else self.lowest.textures
        with dr.suspend_grad():
            alpha, eta = float(beyond.alpha[0]), float(beyond.eta[0])
            now = SlabLayers(self.coats, lowest, (alpha, eta))
            if self._baked is None or not now.lie_within(self._baked):
                self._bake(now)
                self._baked = now
        self._layers = now
        self._sloped = [x for x in (*now.axes, *now.constants) if x.differentiable]

    def _refuse(self, reason: str) -> NoReturn:
        raise ParameterError(
            f"{self._where}: {reason}; use the plugin 'layered', which walks through any"
        )

    def _bake(self, layers: SlabLayers) -> None:
        """Compute the tables, and store them in Dr.Jit's memory."""
        axes = [x.axis for x in layers.axes]
        if len(axes) > AXES:
            self._refuse(f"{len(axes)} parameters vary, but a slab has tables along {AXES}")
        sloped = [k for k, x in enumerate(layers.axes) if x.differentiable]
        slabs = bake(axes, sloped, layers.changes, layers.at, _lobes, layers.apart)
        first, self._faint = slabs.first, slabs.faint
        self._etas, self._indices = [eta for _, eta in first.faces], first.indices
        self._within = [[(index, eta) for index, _, eta in side] for side in first.inner]
        self._knots = [side.knots for side in first.reflected]
        self._tables = [stored(x.table, True) for x in slabs.functions]
        last = slabs.numbers.shape[-1]
        ends = np.cumsum([0, *(x.numbers for x in slabs.functions)])
        self._parts = (last - ends[-1] + ends[:-1]).tolist()  # where numbers of functions begin
        self._nodes, self._channels = math.prod(slabs.shape), len(slabs.numbers)
        self._numbers = Numbers(slabs.numbers.reshape(-1, last))
        slopes, count = slabs.slopes, len(sloped)
        for k, constant in enumerate(layers.constants, count):
            slopes[:, :, k] /= layers.share(constant)[:, None, None]
        self._slopes = Numbers(slopes.reshape(self._numbers.nodes, -1)) if slopes.size else None
        self._lobes = Interpolated(slabs.lobes)
        self._ranges = [[mi.Float(x) for x in axis.numbers] for axis in axes]
        self._axes = [axis.scale for axis in axes], slabs.shape
        dr.make_opaque(self._ranges)

    def _vertex(self, si, active):
        """Numbers of each channel, their slopes, and those of lobes; without gradients."""
        layers = self._layers
        values = [[dr.detach(x) for x in part.read(si, active)] for part in layers.axes]
        constants = [part.read(si, active) for part in layers.constants]
        channels = max([self._channels, *map(len, (*values, *constants))])
        return only_where(active, partial(self._at_place, channels), values, si.wi)

    def _at_place(self, channels: int, values: list[list], wi) -> list:
        coordinates = [
            [Axis("", scale, 0, 0).coordinate(x, DRJIT, numbers) for x in part]
            for scale, part, numbers in zip(self._axes[0], values, self._ranges, strict=True)
        ]
        numbers, slopes = [], []
        for c in range(channels):
            own = [x[min(c, len(x) - 1)] for x in coordinates]
            first = min(c, self._channels - 1) * self._nodes
            corners = [
                (node + first, weight)
                for node, weight in simplex(self._axes[1], own, mi.UInt32, DRJIT)
            ]
            numbers.append(self._numbers.at(corners))
            slopes.append(self._slopes.at(corners) if self._slopes else [])
        places = [sum(x) * (1 / len(x)) for x in coordinates]
        side = dr.select(wi.z > 0, mi.Float(0), 1)
        return [numbers, slopes, self._lobes([dr.sqrt(dr.abs(wi.z)), side, *places[::-1]])]

    def _attached(self, vertex, si, active) -> list[list]:
        """The numbers of each channel with the gradients of the parameters."""
        numbers, slopes = [*vertex[0]], vertex[1]
        values = [x.read(si, active) for x in self._sloped]
        if dr.grad_enabled(values):
            # Outside of calls, in which Dr.Jit 1.5 counts gradients of single numbers several times
            changes = [[x - dr.detach(x) for x in part] for part in values]
            for c, slope in enumerate(slopes):
                for k, change in enumerate(changes):
                    own = slope[k * len(numbers[c]) : (k + 1) * len(numbers[c])]
                    by = change[min(c, len(change) - 1)]
                    numbers[c] = [dr.fma(by, x, y) for x, y in zip(own, numbers[c], strict=True)]
        ends = [*itertools.pairwise([0, *self._parts, None])]
        return [[own[a:b] for a, b in ends] for own in numbers]

    def _reflected(self, a, b, upper, numbers: list[list]) -> list:
        """f of each channel on the upper or the lower side, for directions above the horizon."""
        widths = [dr.exp(x) - DARK for x in numbers[0][0][2:]]
        count, inner = len(self._within[0]), []
        for k, ((i, e), (j, f)) in enumerate(zip(*self._within, strict=True)):
            width = dr.select(upper, widths[2 + k], widths[2 + count + k])
            inner.append((dr.select(upper, i, j), width, dr.select(upper, e, f)))
        alpha, eta = (dr.select(upper, *pair) for pair in (widths[:2], self._etas))
        functions = [
            interpolated(
                own, SHAPE, [dr.clip(x, 0, 1) for x in coordinates(a + b, a - b, DRJIT, k)]
            )
            for own, k in zip(self._tables[:-1], self._knots, strict=False)
        ]
        factor, lobe = mirrored_inside(a, b, inner, DRJIT), interface.reflection(a, b, alpha, eta)
        inverse, found = dr.rcp(a.z) + dr.rcp(b.z), []
        for first, *own, _ in numbers:
            rests = [self._of_sum(*x) for x in zip(functions, own, strict=True)]
            depth = dr.square(dr.select(upper, *first[:2]))
            rest = dr.select(upper, rests[0], rests[-1])
            found.append(rest * factor + lobe * dr.exp(-depth * inverse))
        return found

    def _passed(self, above, below, numbers: list[list]) -> list:
        """f of each channel that crosses the slab, without the square of its index."""
        places = passed_coordinates(above, below, self._indices, DRJIT)
        functions = interpolated(self._tables[-1], PASSED_SHAPE, [dr.clip(x, 0, 1) for x in places])
        widths = [dr.exp(x) - DARK for x in numbers[0][0][2:4]]
        faces = [*zip(widths, self._etas, strict=True)]
        scale = grazing_factor(above, below, faces, DRJIT)
        return [self._of_sum(functions, own) * scale for *_, own in numbers]

    def _of_sum(self, functions: list, numbers: list):
        """f of a table's functions and a channel's numbers."""
        log, (gain, *others) = functions[0], numbers
        for function, number in zip(functions[1:], others, strict=False):
            log = dr.fma(function, number, log)
        return dr.exp(gain) * dr.maximum(dr.exp(log) - self._faint, 0)

    def _f(self, vertex, ctx, si, wo, active):
        numbers = self._attached(vertex, si, active)
        inside, up, upper = above_surface(si), raised(wo), si.wi.z > 0
        reflected = only_where(active, self._reflected, inside.wi, up, upper, numbers)
        pair = dr.select(upper, inside.wi, up), dr.select(upper, up, inside.wi)
        through = only_where(active, self._passed, *pair, numbers)
        side = wo if ctx.mode == mi.TransportMode.Importance else si.wi
        scale = dr.select(side.z < 0, dr.square(self._index), 1)
        crosses = si.wi.z * wo.z < 0
        found = [dr.select(crosses, t * scale, r) for t, r in zip(through, reflected, strict=True)]
        return spectrum.from_channels(found, si.wavelengths)

    def _proposal(self, vertex, si, active):
        reflected, *widths = vertex[-1]
        count = len(QUANTILES)
        near, far = (Mixture(WEIGHTS, part) for part in (widths[:count], widths[count:]))
        return SlabMixture(near, far, reflected, self._index_across(si.wi))
