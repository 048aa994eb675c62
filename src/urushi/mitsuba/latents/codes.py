"""The latent codes of a plugin: constant ones, and what they share with `latents.over_axes`.

Codes have two operations: `vertex` computes what evaluating and sampling at a surface interaction
share, and `f_and_pdf` evaluates every channel and the proposal's density there.

The linear basis in Dr.Jit is the counterpart of `nets.basis`, for channels that share directions:
its functions are looked up once for all channels. A table holds the mean and the functions but the
first, which is one, as numbers of 16 bits. Codes of two widths have a stretch, on which the
functions depend. Channels of one stretch share the look-up.
"""

import weakref
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core.lanes import cell
from urushi.core.namespace import DRJIT
from urushi.core.stretched import stretched
from urushi.core.table import MAX_LOG, MIN_LOG, SHAPE, coordinates, corner_steps
from urushi.material.material import Material
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents import lobe
from urushi.mitsuba.latents.lobe import NO_LOBE, LobeKind, kind_of
from urushi.mitsuba.latents.proposal import CodeProposals
from urushi.mitsuba.recording import only_where, owned
from urushi.mitsuba.tables import Numbers, stored, tabulated
from urushi.nets.networks import Networks
from urushi.nets.weights import Model
from urushi.textures.principal import projection_of


class BasisTable:
    """Mean and functions at the nodes of `core.table`, in Dr.Jit's memory."""

    def __init__(self, rows: np.ndarray, factors: Sequence[int] = ()):
        """Store functions.

        Args:
            rows: (P, N) mean and functions, without the constant one.
            factors: (N,) of `core.stretched`, for two widths; 0: none.
        """
        self._factors, self._numbers = factors, Numbers(rows)
        self.count = rows.shape[1]  # N

    def at(self, wi, wo, stretch2=None) -> list:
        """Mean and functions (N) of a pair above the horizon.

        stretch2: the squared stretch, for two widths; the functions are times their factors.
        """
        if stretch2 is None:
            return self._at(coordinates(wi + wo, wi - wo, DRJIT))
        places, around = stretched(wi + wo, wi - wo, stretch2, DRJIT)
        pairs = zip(self._at(places), self._factors, strict=True)
        return [value * around[factor - 1] if factor else value for value, factor in pairs]

    def _at(self, places: Sequence) -> list:
        """Mean and functions (N) at coordinates (3)."""
        clipped = [dr.clip(place, 0, 1) for place in places]
        first, shares = cell(SHAPE, clipped, mi.UInt32(0))
        weights: list[Any] = [1]
        for share in shares:
            weights = [x * y for x in weights for y in (1 - share, share)]
        nodes = [first + step for step in corner_steps(SHAPE)]
        return self._numbers.at([*zip(nodes, weights, strict=True)])


#: The tables of networks by fingerprint and variant, while any plugin uses them.
_tables: weakref.WeakValueDictionary[tuple[str, str], BasisTable] = weakref.WeakValueDictionary()


def table_of(model: Model) -> BasisTable:
    """The table of a model, which plugins share."""
    key = model.fingerprint, mi.variant()
    table = _tables.get(key)
    if table is None:
        networks = model.networks
        assert isinstance(networks, Networks)  # for the type checker
        rows, factors = (
            np.delete(x, 1, axis=-1) for x in (networks.basis.rows, networks.basis.factors)
        )
        table = BasisTable(rows, factors.tolist())
        _tables[key] = table
    return table


class BasisDecoder:
    """f [1/sr] of latent codes: the lobe, and the rest by the basis below `nets.transmittance`.

    The terms of a channel's code are the numbers of its lobe that `LobeKind.numbers` names, its
    gain, and its other numbers; of two widths also the squared stretch, which channels may share.
    """

    def __init__(
        self,
        model: Model,
        kind: LobeKind,
        table: BasisTable | None = None,
        faint: float = 0.0,
        one_stretch: bool = False,
    ):
        """Decode codes of a model.

        Args:
            model: of the codes.
            kind: common properties of their lobes.
            table: mean and functions of the codes' numbers; None: those of the basis.
            faint: [1/sr] by which g of the codes is too large.
            one_stretch: whether all channels have the stretch of the first.
        """
        self._one_stretch = one_stretch
        self._kind, self._lobe, self._faint = kind, model.arch.lobe, faint
        self._table = table_of(model) if table is None else table
        self._end = self._lobe + self._table.count  # of the numbers of functions

    def code_terms(self, latents: Sequence[Sequence]) -> list[list]:
        """Terms of the code of each channel, from numbers or Dr.Jit floats (C, size)."""
        terms = []
        for c, z in enumerate(latents):
            stretch2 = [dr.exp(2 * x) for x in z[self._end :] if self.has_stretch(c)]
            lobe = (z[i] for i in self._kind.numbers(c))
            terms.append([*lobe, *z[self._lobe : self._end], *stretch2])
        return terms

    def f_of_terms(self, terms: Sequence[Sequence], wi, wo) -> list:
        """f of each channel, from a list of Dr.Jit floats, its terms, for each.

        Exchanging wi and wo gives the same bits.
        """
        rests, lobes, stretch2 = list[Any](), list[Any](), None
        for c, channel in enumerate(terms):
            if self.has_stretch(c):
                *channel, stretch2 = channel
            if c == 0 or self.has_stretch(c):
                mean, *functions = self._table.at(wi, wo, stretch2)
            gain, *numbers = channel[-self._table.count :]
            lobes.append(channel[: -self._table.count])
            log = mean + gain
            for number, function in zip(numbers, functions, strict=True):
                log = dr.fma(number, function, log)
            rest = dr.exp(dr.clip(log, MIN_LOG, MAX_LOG))
            if self._faint:  # the derivative passes the bound, so that an optimiser can leave black
                rest = rest - self._faint
                rest = rest + dr.detach(dr.maximum(-rest, 0))
            rests.append(rest)
        return lobe.with_rests(self._kind.complete(lobes), rests, wi, wo, self._kind)

    def has_stretch(self, channel: int) -> bool:
        """Whether the terms of a channel have a stretch."""
        return self._kind.widths == 2 and (channel == 0 or not self._one_stretch)


class Vertex(NamedTuple):
    """Quantities that depend on the position and on wi alone."""

    # Per channel the terms of f, Dr.Jit floats; one list if all channels have the same code.
    decoder_terms: list[list]
    proposal: Any  # a mixture, of the mean code over the channels
    # Per channel and parameter that carries a gradient, slopes of the terms after the lobe.
    slopes: Sequence[list[list]] = ()


class EvaluatedCodes:
    """Codes whose f is a function of a vertex's terms, wi and wo."""

    channels: int

    def _values(self, terms: Sequence, wi, wo) -> list:
        """f of each channel, or of one for all. Tables are no arguments: they have other widths."""
        raise NotImplementedError

    def f_and_pdf(self, vertex: Vertex, si, wo, active) -> tuple[list, Any]:
        """The BRDF [1/sr] of each channel for si.wi and wo above the horizon, and the density of
        the proposal [1/sr]."""

        def evaluated(terms, proposal, wi, wo):
            return self._values(terms, wi, wo), proposal.pdf(wi, wo)

        values, pdf = only_where(active, evaluated, *vertex[:2], si.wi, wo)
        lanes = dr.size_v(mi.Spectrum) if self.channels == spectrum.COUNT else self.channels
        return values * lanes if len(values) == 1 else values, pdf


class ConstantLatents(EvaluatedCodes):
    """One latent code per channel. What depends on the codes alone is computed once, here.

    Codes with gradients of their own numbers have an f of the same bits. Only f is differentiated
    with respect to them: as in all of Mitsuba's differentiable integrators, samples are fixed while
    the integrand changes.
    """

    def __init__(self, material: Material, tensor: "mi.TensorXf | None" = None):
        """Take the codes of a material, without its rotation; tensor: the same, with gradients."""
        self.material = material = replace(material, rotation=0.0, coating=None)
        self.model, self.channels = material.model, material.channels
        model, latents, table = material.model, material.latents, material.table
        if table is None and (latents == latents[:1]).all():
            latents = latents[:1]  # channels of the same code are evaluated once
        self._fine = len(latents) == spectrum.COUNT
        whole = table is not None and not material.beside_lobe
        self._kind = NO_LOBE if whole else kind_of(latents[:, : model.arch.lobe])
        self._sampler = CodeProposals(model, self._kind)
        self._decoder = None
        self._table: Any = None  # of the rest's g, or of all of f; None: there is no rest
        if model.widths == 2:
            self._decoder, latents = self._own_decoder(latents)
        else:
            table = model.networks.table(latents) if table is None else table
            if table is not None:
                table = np.moveaxis(table, -1, 0)[..., None] if self._fine else table
                self._table = stored(table, half=False)
        if self._fine:
            rows = np.array([self._code_terms(z[None])[0] for z in latents], np.float32)
            self._decoder_terms = [owned(mi.Float, rows)]
        else:
            # Read from memory, so that all materials share compiled code
            self._decoder_terms = [[*map(mi.Float, terms)] for terms in self._code_terms(latents)]
            dr.make_opaque(self._decoder_terms)
        mean = material.latents.mean(axis=0)
        self._proposals = [owned(mi.Float, x) for x in self._sampler.tabulated(mean)]
        self._codes: Any = None  # with gradients
        if tensor is not None:
            # Numbers that vanish or that channels share have gradients of their own.
            edged = kind_of(material.latents[:, : model.arch.lobe]).edged
            every = (True,) * model.arch.lobe
            self._changing = BasisDecoder(model, LobeKind(every, edged=edged))
            self._size, self._codes = tensor.shape[-1], tensor.array
            dr.make_opaque(self._codes)

    def _own_decoder(self, latents: np.ndarray) -> tuple[BasisDecoder | None, np.ndarray]:
        """The decoder of codes (C, L) of two widths, None without rests; the codes that it takes.

        Codes of one stretch have functions of their own: the bands of a spectrum principal ones,
        a few channels their tables (`Basis.table`), each times one for its own channel.
        """
        size = self.model.arch.lobe
        if (latents[:, -1] != latents[0, -1]).any():
            return BasisDecoder(self.model, self._kind), latents
        tops, rests = latents[:, :size], latents[:, size:]
        if self._fine:
            rows, projection = projection_of(self.model, tops[None], rests[None])
            numbers, which = projection.numbers(rests), projection.factors.tolist()
        else:
            table = self.model.networks.table(latents)
            if table is None:
                return None, latents
            channels, factors = table.shape[-2:]
            rows = np.pad(table.reshape(-1, channels * factors), [(0, 0), (1, 0)])
            which = [*range(factors)] * channels
            chosen = np.repeat(np.eye(channels), factors, axis=1)
            numbers = np.concatenate([np.zeros((channels, 1)), chosen, rests[:, -1:]], axis=1)
        own = BasisTable(rows, [0, *which])
        decoder = BasisDecoder(self.model, self._kind, own, one_stretch=True)
        return decoder, np.concatenate([tops, numbers], axis=1)

    def vertex(self, si, active) -> Vertex:
        """The vertex at a surface interaction."""
        propose = partial(self._sampler.proposal_of_table, self._proposals)
        terms = self._terms_at(si.wavelengths) if self._fine else self._decoder_terms
        return Vertex(terms, only_where(active, propose, si.wi))

    def _code_terms(self, latents: np.ndarray) -> list[list]:
        """Terms of the code of each channel; beside a table, numbers of the lobe."""
        if self._decoder is not None:
            return self._decoder.code_terms(latents.tolist())
        return [code[self._kind.numbers(c)].tolist() for c, code in enumerate(latents)]

    def _terms_at(self, wavelengths) -> list[list]:
        """The terms of the band of each wavelength [nm], and then these bands."""
        bands, numbers = spectrum.band_at(wavelengths), self._decoder_terms[0]
        count, places = len(numbers) // spectrum.COUNT, self._kind.numbers(0)
        terms = []
        for i, band in enumerate(bands):
            own = self._kind.numbers(i)  # without those that are the same in all channels
            kept = [k for k in range(count) if k >= len(places) or places[k] in own]
            if self._decoder is not None and not self._decoder.has_stretch(i):
                kept = kept[:-1]
            terms.append([dr.gather(mi.Float, numbers, band * count + k) for k in kept])
        return [*terms, bands]

    def _values(self, terms, wi, wo):
        channels, bands = (terms[:-1], terms[-1]) if self._fine else (terms, None)
        if self._decoder is not None:
            return self._decoder.f_of_terms(channels, wi, wo)
        lobes = self._kind.complete(channels)
        if self._table is None:
            return lobe.f(lobes, wi, wo, self._kind)
        rests = tabulated(self._table, len(channels), wi, wo, bands=bands)
        return lobe.with_rests(lobes, rests, wi, wo, self._kind)

    def f_and_pdf(self, vertex: Vertex, si, wo, active) -> tuple[list, Any]:
        """See `EvaluatedCodes`; f has derivatives by the codes, besides those by directions."""
        values, pdf = super().f_and_pdf(vertex, si, wo, active)
        if self._codes is None or not dr.grad_enabled(self._codes):
            return values, pdf
        fine = self.channels == spectrum.COUNT
        places = spectrum.band_at(si.wavelengths) if fine else map(mi.UInt32, range(self.channels))
        codes, directions = [*map(self._code, places)], (dr.detach(si.wi), dr.detach(wo))

        def evaluated(codes, wi, wo):
            return self._changing.f_of_terms(self._changing.code_terms(codes), wi, wo)

        changing = only_where(active, evaluated, codes, *directions)
        pairs = zip(values, changing, strict=True)
        return [value + (change - dr.detach(change)) for value, change in pairs], pdf

    def _code(self, channel) -> list:
        """The code (L) of a channel, an index. An argument of a nested call must be the result of
        an operation in the outer call, or Dr.Jit loses its gradient."""
        first = channel * self._size
        return [dr.gather(mi.Float, self._codes, first + i) for i in range(self._size)]

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Latent codes (M, C, size) at points uv (M, 2)."""
        latents = self.material.latents
        return np.broadcast_to(latents, (len(uv), *latents.shape))

    def __str__(self) -> str:
        count, size = self.material.latents.shape
        table = "" if self.material.table is None else ", with a table"
        return f"{count} x {size}{table}"
