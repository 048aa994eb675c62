"""Codes over axes of parameters (`textures.axes`), looked up where Mitsuba's textures say.

A vertex takes the values of the axes from the textures, and the code linearly between the nodes of
a simplex around them. The lobe of the coat has the coat's own width there. Codes are stored by
principal numbers (`textures.principal`).
"""

from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import MIN_ALPHA, CoatParameters
from urushi.core.namespace import DRJIT
from urushi.material.coated_values import coated_values
from urushi.material.layer import tabulated
from urushi.material.material import Material
from urushi.material.substrate import Substrate
from urushi.material.values import codes_of
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.holders import Held, Vertex
from urushi.mitsuba.networks.basis import ONE, BasisDecoder
from urushi.mitsuba.networks.lobe import kind_of
from urushi.mitsuba.networks.proposal import CodeProposals
from urushi.mitsuba.reading.axes import Bottom, Varying, varying_parameters
from urushi.mitsuba.reading.parameters import CoatTextures
from urushi.mitsuba.recording import only_where, owned
from urushi.nets import lobe as lobes
from urushi.nets import proposal
from urushi.nets.weights import Model
from urushi.textures.axes import Baked, bake
from urushi.textures.principal import projection_of
from urushi.textures.store import TexelGrid

#: Largest level of a number of 16 bits.
TOP = (1 << 16) - 1


class AxisLatents(Held):
    """The codes of a coat over a bottom whose parameters vary."""

    material = None

    DRJIT_STRUCT: ClassVar = {"_words": object, "_terms": object, "_decoder": object} | (
        dict.fromkeys(("_scales", "_term_scales", "_eta"), list)
    )  # for frozen functions
    UNRECORDED: ClassVar = ("baked", "_coat", "_choose_grid")

    def __init__(
        self,
        baked: Baked,
        coat: CoatTextures,
        varying: Sequence[Varying],
        choose_grid: Callable[[], TexelGrid | None],
    ):
        """choose_grid: the grid of texels for coats above."""
        self.baked, self.model, self._varying = baked, baked.model, list(varying)
        self._coat, self.channels = coat, spectrum.channel_count()
        self._choose_grid = choose_grid
        codes, size = baked.codes, self.model.arch.lobe
        functions, projection = projection_of(self.model, codes.reshape(-1, 1, codes.shape[-1]))
        numbers = projection.numbers(codes[..., size:])
        low, high = numbers.min(axis=(0, 1)), numbers.max(axis=(0, 1))
        step = np.maximum(high - low, 1e-9) / TOP
        # The mean takes the lowest values, so that numbers are levels times steps.
        functions[:, 0] += functions[:, 1:] @ low[1:]
        self._count = len(step)
        self._words = owned(mi.UInt32, _packed((numbers - low) / step))
        self._scales = [mi.Float(x) for x in (low[0], step[0], *step[1:] / ONE)]
        tops = codes[..., :size].reshape(-1, size)
        self._kind = kind_of(tops.min(axis=0), tops.max(axis=0), np.ones(size, bool))
        self._decoder = BasisDecoder(self.model, self._kind, functions)
        self._sampler = CodeProposals(self.model, self._kind)
        terms = proposal.code_terms(self.model.params, codes[..., size:].mean(axis=0))
        least = terms.min(axis=0)
        spread = np.maximum(terms.max(axis=0) - least, 1e-9) / TOP
        self._terms = owned(mi.UInt32, _packed((terms - least) / spread))
        self._term_scales = [mi.Float(x) for x in (*least, *spread)]
        self._eta = [mi.Float(float(tops[0, 4]))]
        dr.make_opaque(self._scales, self._term_scales, self._eta)
        #: Whether channels differ.
        self._differ = len(codes) > 1 or any(axis.own for axis in baked.axes)

    @property
    def grid(self) -> TexelGrid | None:
        """The grid of texels that resolves the textures, for coats above and files."""
        return self._choose_grid()

    def vertex(self, si, active) -> Vertex:
        """The vertex at a surface interaction."""
        alpha = self._coat.textures["alpha"].eval_1(si, active)
        places = self._coordinates(si, active)
        return only_where(active, self._vertex, si.wi, alpha, places)

    def bare_vertex(self, si) -> Vertex:
        """The vertex, from which `f` follows."""
        return self.vertex(si, mi.Bool(True))

    def _coordinates(self, si, active) -> list[list]:
        """The coordinate along each axis, of each channel if it has its own."""
        return [
            [x.axis.coordinate(value, DRJIT) for value in x.read(si, active)] for x in self._varying
        ]

    def _evaluated(self) -> Callable[..., list]:
        return self._decoder.f_of_terms

    def _vertex(self, wi, alpha, coordinates: list[list]) -> Vertex:
        # The derivative passes the bound, so that an optimiser can leave it.
        alpha = dr.replace_grad(dr.maximum(alpha, MIN_ALPHA), alpha)
        zero, one = mi.Float(0), mi.Float(1)
        lobe = [alpha, zero, zero, one, self._eta[0], zero]
        terms = []
        for c in range(self.channels if self._differ else 1):
            own = [x[min(c, len(x) - 1)] for x in coordinates]
            levels = self._numbers(own, min(c, len(self.baked.codes) - 1))
            gain = dr.fma(levels[0], self._scales[1], self._scales[0])
            others = [x * scale for x, scale in zip(levels[1:], self._scales[2:], strict=True)]
            terms.append([*(lobe[i] for i in self._kind.numbers(c)), gain, *others])
        middle = [sum(x) * (1 / len(x)) for x in coordinates]
        half = proposal.TERMS
        levels = _levels(self._terms, half, self._nearest(middle))
        scales = zip(self._term_scales[:half], self._term_scales[half:], strict=True)
        drawn = [dr.fma(x, step, least) for x, (least, step) in zip(levels, scales, strict=True)]
        return Vertex(terms, self._sampler.proposal_of_terms(lobe, drawn, wi))

    def _nearest(self, coordinates: Sequence) -> Any:
        """The index of the node nearest to coordinates."""
        node: Any = mi.UInt32(0)
        for x, count in zip(coordinates, self.baked.shape, strict=True):
            node = node * count + mi.UInt32(dr.clip(x, 0, 1) * (count - 1) + 0.5)
        return node

    def _numbers(self, coordinates: Sequence, channel: int) -> list:
        """Levels of the numbers, by `textures.axes.simplex`."""
        shape = self.baked.shape
        node: Any = mi.UInt32(channel)
        for x, count in zip(coordinates, shape, strict=True):
            place = x * (count - 1)
            node = node * count + dr.minimum(mi.UInt32(place), count - 2)
        shares, steps, step = [], [], 1
        for x, count in zip(coordinates[::-1], shape[::-1], strict=True):
            place = x * (count - 1)
            shares.append(place - mi.Float(dr.minimum(mi.UInt32(place), count - 2)))
            steps.append(mi.UInt32(step))
            step *= count
        for a, b in SORTING[len(shape)]:
            swap = shares[a] < shares[b]
            for parts in (shares, steps):
                parts[a], parts[b] = (
                    dr.select(swap, parts[b], parts[a]),
                    dr.select(swap, parts[a], parts[b]),
                )
        ends, total = [1, *shares, 0], list[Any]()
        for k in range(len(shape) + 1):
            dr.detail.new_scope(dr.backend_v(mi.Float))  # one corner after the other, as in `mlp`
            if k:
                node = node + steps[k - 1]
            weight, levels = ends[k] - ends[k + 1], _levels(self._words, self._count, node)
            if k:
                total = [dr.fma(weight, x, y) for x, y in zip(levels, total, strict=True)]
            else:
                total = [weight * x for x in levels]
        return total

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Latent codes (M, C, size) at points uv (M, 2)."""
        si = spectrum.points(uv)
        places = self._coordinates(si, True)
        alpha = self._coat.textures["alpha"].eval_1(si)
        dr.eval(places, alpha)
        columns = [[np.broadcast_to(x.numpy(), len(uv)) for x in place] for place in places]
        codes = np.stack(
            [
                self.baked.at(np.stack([x[min(c, len(x) - 1)] for x in columns], axis=-1), c)
                for c in range(self.channels)
            ],
            axis=1,
        )
        codes[..., 0] = np.maximum(np.broadcast_to(alpha.numpy(), len(uv)), MIN_ALPHA)[:, None]
        return codes

    def __str__(self) -> str:
        sides = " x ".join(map(str, self.baked.shape))
        names = ", ".join(axis.name for axis in self.baked.axes)
        return f"{sides} nodes over {names}, of {len(self.baked.codes)} x {self._count} numbers"


#: Comparisons that sort numbers in descending order.
SORTING = {
    1: (),
    2: ((0, 1),),
    3: ((0, 1), (1, 2), (0, 1)),
    4: ((0, 1), (2, 3), (0, 2), (1, 3), (1, 2)),
}


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


def bake_axes(
    model: Model,
    coat: CoatTextures,
    bottom: "mi.BSDF",
    constant: Callable[[], Material],
    choose_grid: Callable[[], TexelGrid | None],
) -> AxisLatents | None:
    """The codes of a coat over a bottom along the parameters that vary; None: they are not known.

    Args:
        bottom: as the coat has it nested.
        constant: the bottom as the coat sees it, if none of its parameters varies.
        choose_grid: as of `AxisLatents`.
    """
    if model.widths != 1:
        return None
    varying = varying_parameters(coat, bottom)
    if varying is None:
        return None
    known = Bottom(model, bottom, coat, varying)
    if abs(coat.eta - 1) < 1e-3 or not known.is_known():
        return None
    axes = [x.axis for x in varying]
    fixed = coat.layering(np.full((1, 2), 0.5))
    textured = any(axis.name.startswith("bottom.") for axis in axes)
    whole = None if textured else tabulated(constant())
    below = None if whole is None else Substrate.of(whole)
    names = {axis.name for axis in axes}
    grey = all(
        name in names or (column == column[:, :1]).all()
        for name, column in zip(CoatParameters._fields, fixed.columns(), strict=True)
    ) and (known.is_grey() if below is None else below.channels == 1)
    channels = 1 if grey else spectrum.channel_count()

    def columns(values: np.ndarray) -> list[np.ndarray]:
        """Columns (C, k) of the coats at values (k, d)."""
        own = {axis.name: column for axis, column in zip(axes, values.T, strict=True)}
        shape = channels, len(values)
        return [
            np.broadcast_to(own[name] if name in own else column[0][:channels, None], shape)
            for name, column in zip(CoatParameters._fields, fixed.columns(), strict=True)
        ]

    def codes_at(values: np.ndarray) -> np.ndarray:
        own = np.stack(columns(values)).astype(np.float64)
        if below is None:
            rows = {axis.name: column for axis, column in zip(axes, values.T, strict=True)}
            substrate, places = known.substrate(rows, channels)
        else:
            substrate = below
            places = np.repeat(np.arange(channels)[:, None], len(values), 1) % below.channels
        flat = own.reshape(len(own), -1)
        pairs = model.networks.pairs()
        rest = coated_values(substrate, places.ravel(), flat[:2], flat[2:], *pairs).T
        top = lobes.of_coat(flat[0], flat[1]).astype(np.float32)[:, None]
        f = rest[:, None] + lobes.f(top[:, :, None], *pairs)
        codes = codes_of(model, f, top)[:, 0].reshape(channels, len(values), -1)
        return codes[:1] if (codes == codes[:1]).all() else codes

    def lobes_at(values: np.ndarray) -> np.ndarray:
        own = columns(values)
        return lobes.of_coat(own[0][0], own[1][0]).astype(np.float32)

    return AxisLatents(bake(model, axes, codes_at, lobes_at), coat, varying, choose_grid)
