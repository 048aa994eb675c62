"""Codes over axes of parameters (`textures.axes`), looked up where Mitsuba's textures say.

A vertex takes the values of the parameters from the textures, and the code linearly between the
nodes of a simplex around them. The lobe of the coat has the coat's own width and index there. Codes
are stored by principal numbers (`textures.principal`). Where a parameter carries a gradient, the
code changes with it by the slope along its axis.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core.namespace import DRJIT, NUMPY
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.holders import Held, Vertex
from urushi.mitsuba.networks.basis import ONE, BasisDecoder
from urushi.mitsuba.networks.lobe import kind_of
from urushi.mitsuba.networks.proposal import CodeProposals
from urushi.mitsuba.reading.axes import Varying
from urushi.mitsuba.recording import only_where, owned
from urushi.nets import lobe as lobes
from urushi.nets import proposal
from urushi.nets.weights import Model
from urushi.textures.axes import FAINT, Baked, simplex
from urushi.textures.principal import projection_of

#: Largest level of a number of 16 bits.
TOP = (1 << 16) - 1

#: Largest change of a number of a code along its slopes that is represented.
REACH = 0.3

#: Places of the widths and the index among the numbers of a lobe, by the parameters' names.
LOBE = {"alpha": (0, 6), "alpha_u": (0,), "alpha_v": (6,), "eta": (4,)}


class AxisVertex(NamedTuple):
    """A `Vertex`, and the slopes of its terms."""

    decoder_terms: list[list]
    proposal: Any
    slopes: list[list[list]]  # for each channel and parameter, of the numbers of the rest


class AxisLatents(Held):
    """The codes of a coat over a bottom whose parameters vary."""

    material = None

    DRJIT_STRUCT: ClassVar = dict.fromkeys(("_words", "_terms", "_decoder", "_one"), object) | (
        dict.fromkeys(
            ("_steps", "_lows", "_term_steps", "_term_lows", "_fixed", "_slopes", "_ranges"), list
        )
    )  # for frozen functions
    UNRECORDED: ClassVar = ("baked", "varying", "_changes")

    def __init__(self, baked: Baked, varying: Sequence[Varying], differentiable: bool):
        """differentiable: whether a parameter carries a gradient."""
        self.baked, self.model, self.varying = baked, baked.model, list(varying)
        self.differentiable = differentiable
        self.channels, size = spectrum.channel_count(), baked.model.arch.lobe
        rests, functions, projection = baked.rests, None, None
        self._changes = baked.slopes() if differentiable else np.zeros((*rests.shape[:2], 0, 0))
        if self.model.widths == 1:
            # Codes that slopes reach are represented, too.
            largest = [np.maximum(np.abs(x).max(), 1e-9) for x in np.moveaxis(self._changes, 2, 0)]
            reached = [rests + self._changes[:, :, k] * (REACH / x) for k, x in enumerate(largest)]
            every = np.concatenate([rests, *reached], axis=1)
            tops = np.tile(baked.lobes, (1 + len(reached), 1))
            functions, projection = projection_of(self.model, tops, every)
            rests = projection.numbers(rests)
        low, high = rests.min(axis=(0, 1)), rests.max(axis=(0, 1))
        step = np.maximum(high - low, 1e-9) / TOP
        self._words, self._count = owned(mi.UInt32, _packed((rests - low) / step)), len(step)
        self._projected, scale = functions is not None, np.ones(len(step))
        if functions is not None:
            # The mean takes the lowest values, so that numbers are levels times steps.
            functions[:, 0] += functions[:, 1:] @ low[1:]
            low, scale[1:] = low[:1], 1 / ONE
        self._steps, self._lows = ([mi.Float(x) for x in part] for part in (step * scale, low))
        same = np.ones(size, bool)
        self._kind = kind_of(baked.lobes.min(axis=0), baked.lobes.max(axis=0), same)
        self._decoder = BasisDecoder(self.model, self._kind, functions, FAINT)
        self._sampler = CodeProposals(self.model, self._kind)
        terms = proposal.code_terms(self.model.params, baked.rests.mean(axis=0))
        if self.model.widths == 2:
            terms = np.append(terms, baked.rests[..., -1:].mean(axis=0), axis=1)
        least = terms.min(axis=0)
        spread = np.maximum(terms.max(axis=0) - least, 1e-9) / TOP
        self._terms = owned(mi.UInt32, _packed((terms - least) / spread))
        parts = (spread, least)
        self._term_steps, self._term_lows = ([mi.Float(x) for x in part] for part in parts)
        self._fixed = [mi.Float(float(x)) for x in baked.lobes[0]]
        # Numbers in memory, so that all materials of the same axes share compiled code
        self._ranges = [[mi.Float(x) for x in axis.numbers] for axis in baked.axes]
        self._axes = [(axis.name, axis.scale, axis.own) for axis in baked.axes], baked.shape
        self._all = [x.axis.name for x in varying]
        self._one = mi.Float(1)  # an operation with it is kept
        numbers = self._steps, self._lows, self._term_steps, self._term_lows, self._ranges
        dr.make_opaque(*numbers, self._fixed, self._one)
        self._slopes = []
        if differentiable:
            slopes = self._changes if projection is None else projection.changes(self._changes)
            self._slopes = [owned(mi.Float, slopes * scale * self._decoder.factors)]
        #: Whether channels differ.
        self._differ = len(baked.rests) > 1 or any(axis.own for axis in baked.axes)

    def vertex(self, si, active) -> "AxisVertex":
        """The vertex at a surface interaction, without gradients: it may be used several times."""
        read = (part.read(si, active) for part in self.varying[: len(self.baked.axes)])
        values = [[dr.detach(x) for x in part] for part in read]
        return AxisVertex(*only_where(active, self._vertex, si.wi, values))

    def f(self, vertex, si, wo, active) -> list:
        """See `Held`."""
        return super().f(self._attached(vertex, si, active), si, wo, active)

    def f_and_pdf(self, vertex, si, wo, active) -> tuple[list, Any]:
        """See `Held`."""
        return super().f_and_pdf(self._attached(vertex, si, active), si, wo, active)

    def _attached(self, vertex: "AxisVertex", si, active) -> Vertex:
        """The vertex with the gradients of the parameters."""
        plain = Vertex(vertex.decoder_terms, vertex.proposal)
        values = [part.read(si, active) for part in self.varying] if self._slopes else []
        if not dr.grad_enabled(values):
            return plain
        # Outside of the call: inside, Dr.Jit 1.5 counts gradients of single numbers several times.
        changes = [[x - dr.detach(x) for x in part] for part in values]
        return plain._replace(
            decoder_terms=self._moved(plain.decoder_terms, vertex.slopes, changes)
        )

    def _moved(self, terms: list[list], slopes: list[list[list]], changes: list[list]) -> list:
        """The terms of a vertex, which change as values do."""
        found = []
        for c, channel in enumerate(terms):
            places, moved = self._kind.numbers(c), list(channel)
            for name, own, slope in zip(self._all, changes, slopes[c], strict=True):
                change, start = own[min(c, len(own) - 1)], len(places)
                for place in self._lobe_places(name):
                    if place in places:
                        at = places.index(place)
                        moved[at] = dr.fma(self._one, change, moved[at])
                if self.model.widths == 2:  # the last number is the squared stretch
                    slope = [*slope[:-1], 2 * channel[-1] * slope[-1]]
                for i, number in enumerate(slope):
                    moved[start + i] = dr.fma(number, change, moved[start + i])
            found.append(moved)
        return found

    def bare_vertex(self, si) -> AxisVertex:
        """The vertex, from which `f` follows."""
        return self.vertex(si, mi.Bool(True))

    def _evaluated(self) -> Callable[..., list]:
        return self._decoder.f_of_terms

    def _vertex(self, wi, values: list[list]) -> "AxisVertex":
        lobe, coordinates = self._lobe(values), []
        for axis, part, numbers in zip(self.baked.axes, values, self._ranges, strict=True):
            coordinates.append([axis.coordinate(x, DRJIT, numbers) for x in part])
        codes, slopes = [], []
        for c in range(len(spectrum.to_channels(mi.Spectrum(0))) if self._differ else 1):
            own = [x[min(c, len(x) - 1)] for x in coordinates]
            rest, slope = self._numbers(own, min(c, len(self.baked.rests) - 1))
            codes.append([*lobe, *rest])
            slopes.append(slope)
        terms = self._decoder.code_terms_drjit(codes)
        node = self._nearest([sum(x) * (1 / len(x)) for x in coordinates])
        levels = _levels(self._terms, len(self._term_steps), node)
        drawn = _scaled(levels, self._term_steps, self._term_lows)
        stretch = drawn[proposal.TERMS :]
        mixture = self._sampler.proposal_of_terms(lobe, drawn[: proposal.TERMS], wi, *stretch)
        return AxisVertex(terms, mixture, slopes)

    def _lobe(self, values: Sequence[Sequence]) -> list:
        """The numbers of the lobe; its width and index are those of the coat there."""
        lobe = list(self._fixed)
        parts = zip(self.baked.axes, values, self._ranges, strict=True)
        for axis, (value, *_), (least, most, *_) in parts:
            for place in self._lobe_places(axis.name):
                lobe[place] = dr.clip(value, least, most)
        return lobe

    def _lobe_places(self, name: str) -> tuple[int, ...]:
        """The places of a parameter among the numbers of the lobe."""
        return LOBE.get(name, ())[: self.model.widths]

    def _nearest(self, coordinates: Sequence) -> Any:
        """The index of the node nearest to coordinates."""
        node: Any = mi.UInt32(0)
        for x, count in zip(coordinates, self.baked.shape, strict=True):
            node = node * count + mi.UInt32(dr.clip(x, 0, 1) * (count - 1) + 0.5)
        return node

    def _numbers(self, coordinates: Sequence, channel: int) -> tuple[list, list[list]]:
        """The numbers of a code by `textures.axes.simplex`, and their slopes along each axis."""
        shape, total = self.baked.shape, list[Any]()
        slopes = [[mi.Float(0)] * self._count for _ in self._all if self._slopes]
        for corner, (node, weight) in enumerate(_simplex(shape, coordinates, channel)):
            dr.detail.new_scope(dr.backend_v(mi.Float))  # one corner after the other, as in `mlp`
            levels = _levels(self._words, self._count, node)
            if corner:
                total = [dr.fma(weight, x, y) for x, y in zip(levels, total, strict=True)]
            else:
                total = [weight * x for x in levels]
            for k, slope in enumerate(slopes):
                first = (node * len(slopes) + k) * self._count
                slopes[k] = [
                    dr.fma(dr.gather(mi.Float, self._slopes[0], first + i), weight, x)
                    for i, x in enumerate(slope)
                ]
        return _scaled(total, self._steps, self._lows), slopes

    def codes(self, values: Mapping[str, np.ndarray]) -> np.ndarray:
        """Codes (C, k, L) at values (k,) of the parameters by name, C as of `Baked.rests`.

        Their rests have `FAINT` more than the material.
        """
        baked = self.baked
        columns = [axis.coordinate(values[axis.name], NUMPY) for axis in baked.axes]
        x = (
            np.stack(columns, axis=-1)
            if columns
            else np.zeros((len(next(iter(values.values()))), 0))
        )
        rests = np.stack([baked.at(x, c) for c in range(len(baked.rests))])
        tops = np.tile(baked.lobes[0], (*rests.shape[:2], 1))
        for axis in baked.axes:
            for place in self._lobe_places(axis.name):
                tops[..., place] = np.clip(values[axis.name], axis.least, axis.most)
        for k, name in enumerate(baked.constants, len(baked.axes)):
            change = values.get(name, np.zeros(len(x)))[:, None]
            for node, weight in simplex(baked.shape, x):
                rests = rests + self._changes[:, node, k] * (weight[:, None] * change)
            for place in self._lobe_places(name):
                tops[..., place] += change[:, 0]
        return np.concatenate([tops, rests], axis=-1, dtype=np.float32)

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Codes (M, C, L) at points uv (M, 2)."""
        si, count = spectrum.points(uv), spectrum.channel_count()
        values = [spectrum.at_bands(si, lambda x=x: x.read(si, True)) for x in self.varying]
        dr.eval(values)
        columns = [[np.broadcast_to(x.numpy(), len(uv)) for x in part] for part in values]
        channels = []
        for c in range(count):
            own = {
                x.axis.name: part[min(c, len(part) - 1)]
                for x, part in zip(self.varying, columns, strict=True)
            }
            codes = self.codes(own)
            channels.append(codes[min(c, len(codes) - 1)])
        return without_faint(self.model, np.stack(channels, axis=1))

    def __str__(self) -> str:
        sides = " x ".join(map(str, self.baked.shape))
        names = ", ".join(axis.name for axis in self.baked.axes)
        return f"{sides} nodes over {names}, of {len(self.baked.rests)} x {self._count} numbers"


def without_faint(model: Model, codes: np.ndarray) -> np.ndarray:
    """Codes (..., L) of rests that have `FAINT` less."""
    rests = model.networks.rest_at_all(
        codes.reshape(-1, codes.shape[-1]), model.networks.basis.probe_rows
    )
    lobe = codes[..., : model.arch.lobe]
    rest = np.maximum(rests - FAINT, 0).reshape(*codes.shape[:-1], -1)
    top = lobes.f(lobe[..., None, :], *model.networks.pairs())
    return model.networks.encode((rest + top)[..., None, :], lobe[..., None, :])[..., 0, :]


def _simplex(shape: Sequence[int], coordinates: Sequence, channel: int) -> list[tuple[Any, Any]]:
    """Nodes and weights of the corners of the simplex around coordinates in [0, 1]."""
    node: Any = mi.UInt32(channel)
    shares, steps, step = [], [], int(np.prod(shape))
    for x, count in zip(coordinates, shape, strict=True):
        place = x * (count - 1)
        first = dr.minimum(mi.UInt32(place), count - 2)
        node, step = node * count + first, step // count
        shares.append(place - mi.Float(first))
        steps.append(mi.UInt32(step))
    for end in range(len(shape) - 1, 0, -1):  # in descending order
        for a in range(end):
            swap = shares[a] < shares[a + 1]
            for parts in (shares, steps):
                pair = parts[a : a + 2]
                parts[a : a + 2] = [dr.select(swap, *pair[::-1]), dr.select(swap, *pair)]
    ends, corners = [mi.Float(1), *shares, mi.Float(0)], []
    for k in range(len(shape) + 1):
        if k:
            node = node + steps[k - 1]
        corners.append((node, ends[k] - ends[k + 1]))
    return corners


def _scaled(levels: Sequence, steps: Sequence, lows: Sequence) -> list:
    """Levels times steps, and the first ones' lowest values added."""
    lows = [*lows, *[None] * (len(levels) - len(lows))]
    return [
        x * step if low is None else dr.fma(x, step, low)
        for x, step, low in zip(levels, steps, lows, strict=True)
    ]


def _packed(levels: np.ndarray) -> np.ndarray:
    """Levels (..., N) as words uint32 (..., W), two to a word; W is a power of two."""
    words = 1 << (-(-levels.shape[-1] // 2) - 1).bit_length()
    space = [(0, 0)] * (levels.ndim - 1) + [(0, 2 * words - levels.shape[-1])]
    whole = np.pad(np.rint(levels).astype(np.uint32), space)
    return whole[..., ::2] + (whole[..., 1::2] << 16)


def _levels(packed, count: int, node) -> list:
    """Levels (count) at a node."""
    words = 1 << (-(-count // 2) - 1).bit_length()
    if words == 1:
        found = [dr.gather(mi.UInt32, packed, node)]
    else:
        size = min(words, 8)  # larger packets are slower
        found = [
            word
            for part in range(words // size)
            for word in dr.gather(
                mi.ArrayXu, packed, node * (words // size) + part, shape=(size, dr.width(node))
            )
        ]
    return [mi.Float(half) for word in found for half in (word & 0xFFFF, word >> 16)][:count]
