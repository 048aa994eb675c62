"""Codes over axes (`textures.baking`), looked up where Mitsuba's textures say.

A vertex takes the values of the parameters from the textures, and the code linearly between the
nodes of a simplex around them. The lobe of the coat has the coat's own width and index there. Where
the nodes are texels, it takes the code of one (`texel_axes`). Codes are stored by principal numbers
(`textures.principal`). Where a parameter carries a gradient, the code changes with it by the slope
along its axis.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core.namespace import DRJIT, NUMPY
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.codes import BasisDecoder, BasisTable, EvaluatedCodes, Vertex
from urushi.mitsuba.latents.lobe import kind_of
from urushi.mitsuba.latents.proposal import CodeProposals
from urushi.mitsuba.recording import only_where
from urushi.mitsuba.tables import Numbers
from urushi.nets import proposal
from urushi.nets.weights import Model
from urushi.textures.axes import LINEAR, Axis, Varying, nearest, whole_numbers
from urushi.textures.baking import Baked
from urushi.textures.point_codes import FAINT
from urushi.textures.principal import projection_of
from urushi.textures.store import TexelGrid

#: Largest change of a number of a code along its slopes that is represented.
REACH = 0.3

#: Places of parameters among the numbers of a lobe, by the number of widths.
LOBE = {
    1: {"alpha": [0], "eta": [4]},
    2: {"alpha": [0, 6], "alpha_u": [0], "alpha_v": [6], "eta": [4]},
}

#: Number of steps of a texel's weight along an axis. A point within half a step of the centre of a
#: texel has this texel alone.
WEIGHT_STEPS = 256


class AxisLatents(EvaluatedCodes):
    """The codes of a material that varies."""

    material = None

    UNRECORDED: ClassVar = ("baked", "varying")

    def __init__(self, baked: Baked, varying: Sequence[Varying]):
        """varying: the parameters along the axes, and then constants that carry gradients."""
        self.baked, self.model, self.varying = baked, baked.model, list(varying)
        #: Numbers of the parameters that carry gradients.
        self._sloped = [k for k, x in enumerate(varying) if x.differentiable]
        self._places = LOBE[baked.model.widths]
        #: Channels of a vertex; one if all are alike.
        own = any(axis.own for axis in baked.axes)
        self._evaluated_channels = dr.size_v(mi.Spectrum) if own else baked.channels
        self.channels = max(spectrum.channel_count(), baked.channels)
        self._store()
        # Numbers in memory, so that all materials of the same axes share compiled code
        self._ranges = [[mi.Float(x) for x in axis.numbers] for axis in baked.axes]
        self._axes = [(axis.name, axis.scale, axis.own) for axis in baked.axes], baked.shape
        self._one = mi.Float(1)  # an operation with it is kept
        dr.make_opaque(self._ranges, self._fixed, self._one)

    def _store(self) -> None:
        """Store the numbers at the nodes, and their slopes, in Dr.Jit's memory."""
        model, tops, rests = self.baked.extended, self.baked.lobes, self.baked.rests()
        changes = self.baked.slopes(self._sloped)
        terms = proposal.code_terms(model.params, rests.mean(axis=0))
        if model.widths == 2:
            terms = np.append(terms, rests[..., -1:].mean(axis=0), axis=1)
        # Codes that slopes reach are represented, too.
        largest = [np.maximum(np.abs(x).max(), 1e-9) for x in np.moveaxis(changes, 2, 0)]
        reached = [rests + changes[:, :, k] * (REACH / x) for k, x in enumerate(largest)]
        every = np.concatenate([rests, *reached], axis=1)
        functions, projection = projection_of(model, np.tile(tops, (1, 1 + len(reached), 1)), every)
        rests = projection.numbers(rests)
        known = {i for axis in self.baked.axes for i in self._places.get(axis.name, ())}
        differ = np.ptp(tops, axis=(0, 1)) > 0
        #: Places of the numbers of lobes that nodes hold.
        self._stored = [i for i in np.flatnonzero(differ).tolist() if i not in known]
        self._fixed = [mi.Float(float(x)) for x in tops[0, 0]]
        own = np.broadcast_to(tops[..., self._stored], (*rests.shape[:2], len(self._stored)))
        numbers = np.concatenate([own, rests], axis=-1)
        numbers = numbers.reshape(-1, numbers.shape[-1])
        self._numbers = Numbers(numbers)
        self._terms = Numbers(terms)
        self._kind = kind_of(tops)
        table = BasisTable(functions, [0, *projection.factors.tolist()])
        #: Whether channels share a stretch: on axes that of the place, or the mean of their places.
        self._one_stretch = self.baked.grid is None or bool((rests == rests[:1])[..., -1].all())
        self._decoder = BasisDecoder(
            model, self._kind, table, self.baked.faint, one_stretch=self._one_stretch
        )
        self._sampler = CodeProposals(model, self._kind)
        changes = projection.changes(changes)
        #: Of each parameter in turn.
        self._slopes = Numbers(changes.reshape(len(numbers), -1)) if self._sloped else None

    def vertex(self, si, active) -> Vertex:
        """The vertex at a surface interaction, without gradients: it may be used several times."""
        read = (part.read(si, active) for part in self.varying[: len(self.baked.axes)])
        values = [[dr.detach(x) for x in part] for part in read]
        return only_where(active, self._vertex, si.wi, values)

    def f_and_pdf(self, vertex, si, wo, active) -> tuple[list, Any]:
        """See `EvaluatedCodes`."""
        return super().f_and_pdf(self._attached(vertex, si, active), si, wo, active)

    def _attached(self, vertex: Vertex, si, active) -> Vertex:
        """The vertex with the gradients of the parameters."""
        sloped = [self.varying[k] for k in self._sloped]
        values = [part.read(si, active) for part in sloped]
        if not dr.grad_enabled(values):
            return vertex
        # Outside of the call: inside, Dr.Jit 1.5 counts gradients of single numbers several times.
        changes = [[x - dr.detach(x) for x in part] for part in values]
        terms, two, turned = [], self._kind.widths == 2, mi.Float(0)
        for c, channel in enumerate(vertex.decoder_terms):
            places, moved = self._kind.numbers(c), list(channel)
            for part, own, slope in zip(sloped, changes, vertex.slopes[c], strict=True):
                change = _of(own, c)
                for place in self._places.get(part.axis.name, ()):
                    if place in places:
                        at = places.index(place)
                        moved[at] = dr.fma(self._one, change, moved[at])
                if two:  # the last number is the stretch, the mean over all channels
                    *slope, stretch = slope
                    turned = dr.fma(stretch, change, turned)
                for i, number in enumerate(slope, len(places)):
                    moved[i] = dr.fma(number, change, moved[i])
            terms.append(moved)
        if two:
            stretch2 = terms[0][-1]
            terms[0][-1] = dr.fma((2 / len(terms)) * dr.detach(stretch2), turned, stretch2)
        return vertex._replace(decoder_terms=terms)

    def _values(self, terms, wi, wo):
        return self._decoder.f_of_terms(terms, wi, wo)

    def _vertex(self, wi, values: list[list]) -> Vertex:
        coordinates, baked = [], self.baked
        for axis, part, numbers in zip(baked.axes, values, self._ranges, strict=True):
            coordinates.append([axis.coordinate(x, DRJIT, numbers) for x in part])
        codes, slopes, nodes = [], [], math.prod(baked.shape)
        for c in range(self._evaluated_channels):
            first = min(c, baked.channels - 1) * nodes
            found = baked.corners([_of(x, c) for x in coordinates], mi.UInt32, DRJIT)
            corners = [(node + first, weight) for node, weight in found]
            code = self._numbers.at(corners)
            lobe = self._lobe(values, code[: len(self._stored)])
            codes.append([*lobe, *code[len(self._stored) :]])
            if self._slopes is not None:
                every = self._slopes.at(corners)
                size = len(every) // len(self._sloped)
                slopes.append([every[i : i + size] for i in range(0, len(every), size)])
        if self._kind.widths == 2 and self._one_stretch:
            codes[0][-1] = sum(code[-1] for code in codes) * (1 / len(codes))
        mean = self._kind.mean([code[: len(self._fixed)] for code in codes])
        node = nearest(baked.shape, [sum(x) * (1 / len(x)) for x in coordinates], mi.UInt32)
        drawn = self._terms.at([(node, 1.0)])
        stretch = drawn[proposal.TERMS :]
        mixture = self._sampler.proposal_of_terms(mean, drawn[: proposal.TERMS], wi, *stretch)
        return Vertex(self._decoder.code_terms(codes), mixture, slopes)

    def _lobe(self, values: Sequence[Sequence], stored: Sequence) -> list:
        """The numbers of the lobe; its width and index are those of the coat there."""
        lobe = list(self._fixed)
        for place, number in zip(self._stored, stored, strict=True):
            lobe[place] = number
        parts = zip(self.baked.axes, values, self._ranges, strict=True)
        for axis, (value, *_), (least, most, *_) in parts:
            for place in self._places.get(axis.name, ()):
                lobe[place] = dr.clip(value, least, most)
        return lobe

    def codes(self, values: Mapping[str, np.ndarray]) -> np.ndarray:
        """Codes (C, k, L), whose g is too large by `Baked.faint`.

        values: by the parameters' names, (C, k), one row for each channel or one for all.
        """
        return self._codes(values, self._at_nodes(), self.baked.channels)

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Codes (M, C, L) at points uv (M, 2), seen from above."""
        return next(self.at_all([uv]))

    def at_all(self, points: Iterable[np.ndarray]) -> Iterator[np.ndarray]:
        """The codes of `at` for each array of points."""
        nodes, own = self._at_nodes(), self.baked.extended
        for uv in points:
            values = {x.axis.name: spectrum.channels_at(uv, x.read) for x in self.varying}
            codes = np.moveaxis(self._codes(values, nodes, self.channels), 0, 1)
            yield without_faint(self.model, own, codes) if self.baked.faint else codes

    def _at_nodes(self) -> np.ndarray:
        """Codes at the nodes, and then their slopes by constants: (C, N, 1 + constants, L)."""
        baked = self.baked
        slopes = baked.slopes(range(len(baked.axes), len(baked.axes) + len(baked.constants)))
        rests = np.concatenate([baked.rests()[:, :, None], slopes], axis=2)
        tops = np.zeros((*rests.shape[:3], baked.lobes.shape[-1]), np.float32)
        tops[:, :, 0] = baked.lobes
        return np.concatenate([tops, rests], axis=-1)

    def _codes(
        self, values: Mapping[str, np.ndarray], at_nodes: np.ndarray, channels: int
    ) -> np.ndarray:
        """Codes (channels, k, L) at values, as of `codes`, by those of `_at_nodes`."""
        baked, count = self.baked, np.shape(next(iter(values.values())))[-1]
        found = np.zeros((channels, count, at_nodes.shape[-1]), np.float32)
        for c, codes in enumerate(found):
            own = {name: _of(x, c) for name, x in values.items()}
            places = [axis.coordinate(own[axis.name], NUMPY) for axis in baked.axes]
            changes = {name: own.get(name, np.zeros(count)) for name in baked.constants}
            factors = np.stack([np.ones(count), *changes.values()], axis=-1)
            for node, weight in baked.corners(places, whole_numbers, NUMPY):
                shares = factors * np.broadcast_to(weight, count)[:, None]
                rows = _of(at_nodes, c)[np.broadcast_to(node, count)]
                codes += np.einsum("kj,kjl->kl", shares, rows)
            for axis in baked.axes:
                for place in self._places.get(axis.name, ()):
                    codes[:, place] = np.clip(own[axis.name], axis.least, axis.most)
            for name, change in changes.items():
                for place in self._places.get(name, ()):
                    codes[:, place] += change
        return found

    def __str__(self) -> str:
        sides = " x ".join(map(str, self.baked.shape))
        names = ", ".join(axis.name for axis in self.baked.axes)
        return (
            f"{sides} nodes over {names}, of {self.baked.channels} x {self._numbers.count} numbers"
        )


def _of(parts: Any, channel: int) -> Any:
    """The part of a channel among one for each, or the only one."""
    return parts[min(channel, len(parts) - 1)]


def without_faint(model: Model, extended: Model, codes: np.ndarray) -> np.ndarray:
    """Codes (..., L) whose g has `FAINT` less than that of codes of the extended model."""
    flat, own = codes.reshape(-1, codes.shape[-1]), extended.networks
    rests = np.maximum(own.g_at_all(flat, own.basis.probe_rows) - FAINT, 0)
    result = model.networks.encode_rest(rests[:, None], flat[:, None, : model.arch.lobe])
    return result.reshape(*codes.shape[:-1], -1)


def texel_axes(grid: TexelGrid) -> list[Varying]:
    """The axes v and u of the texels of a grid, one of which is drawn at each point.

    f is filtered, not the code: f of the code halfway between two codes is far from the mean of
    both f where they differ much. A texel is drawn in proportion to its weight in the filter (Pharr
    et al. 2024, *Filtering After Shading With Stochastic Texture Filtering*). f, density and sample
    of a vertex belong to one texel, and f is right in the mean over positions.
    """

    def read(si, active, along: int) -> list:
        count = (grid.width, grid.height)[along]
        return [mi.Float(drawn_texel(si, grid)[along]) * (1 / max(count - 1, 1))]

    return [
        Varying(Axis(name, LINEAR, 0.0, 1.0), partial(read, along=along))
        for name, along in (("v", 1), ("u", 0))
    ]


def drawn_texel(si, grid: TexelGrid) -> list:
    """Column and row (Int32) of one of the texels around a point, drawn by its weight.

    The numbers in (0, 1) by which it is drawn are a hash of uv and wi, multiples of
    1 / `WEIGHT_STEPS` plus half of it.
    """
    values = (si.uv.x, si.uv.y, si.wi.x, si.wi.y)
    singles = (dr.float32_array_t(type(x))(dr.detach(x)) for x in values)
    bits = [dr.reinterpret_array(mi.UInt32, x) for x in singles]
    hashed, _ = mi.sample_tea_32(bits[0] + 0x9E3779B9 * bits[2], bits[1] + 0x85EBCA6B * bits[3])
    found = []
    sides = grid.width, grid.height
    for x, texels, shift in zip(si.uv, sides, (8, 16), strict=True):
        u = (mi.Float((hashed >> shift) % WEIGHT_STEPS) + 0.5) / WEIGHT_STEPS
        count = mi.Int32(texels)
        texel = mi.Int32(dr.floor((x - dr.floor(x)) * count - (0.5 - u)))
        texel = dr.select(texel >= count, 0, dr.select(texel < 0, count - 1, texel))
        found.append(dr.clip(texel, 0, count - 1))  # NaN too
    return found
