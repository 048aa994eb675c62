"""The latent codes of a plugin: constant ones, and what they share with `latents.over_axes`.

Codes have two operations: `vertex` computes what evaluating and sampling at a surface interaction
share, and `f_and_pdf` evaluates every channel and the proposal's density there.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.material.material import Material
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents import lobe
from urushi.mitsuba.latents.basis import BasisDecoder
from urushi.mitsuba.latents.lobe import ANY_LOBE, NO_LOBE, CodeProposals, kind_of
from urushi.mitsuba.latents.tables import stored, tabulated
from urushi.mitsuba.recording import only_where, owned


class Vertex(NamedTuple):
    """Quantities that depend on the position and on wi alone."""

    # Per channel the terms of f, Dr.Jit floats; one list if all channels have the same code.
    decoder_terms: list[list]
    proposal: Any  # a mixture, of the mean code over the channels; None if it is not needed
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
        self._decoder = BasisDecoder(model, self._kind) if model.widths == 2 else None
        self._table: Any = None  # of the rest's g, or of all of f; None: there is no rest
        if self._decoder is None:
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
            kind = ANY_LOBE._replace(widths=model.widths, edged=edged)
            self._changing = BasisDecoder(model, kind)
            self._size, self._codes = tensor.shape[-1], tensor.array
            dr.make_opaque(self._codes)

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
