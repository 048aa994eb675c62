"""The latent codes of a plugin: one per channel or a texture of them.

Both classes have three operations: `vertex` computes what evaluating and sampling at a surface
interaction share, `f` evaluates every channel there, and `f_and_pdf` the proposal's density too.
"""

import os
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.material.material import Material
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.lookup import LatentTexture
from urushi.mitsuba.networks.basis import FUNCTION_SCALE, BasisDecoder
from urushi.mitsuba.networks.lobe import NO_LOBE, LobeKind, kind_of
from urushi.mitsuba.networks.proposal import CodeProposals
from urushi.mitsuba.networks.table import TabulatedDecoder, stored
from urushi.mitsuba.recording import only_where, owned
from urushi.nets.weights import Model
from urushi.textures.principal import principal_texture
from urushi.textures.store import TexelGrid, TextureStore, write_texture


class Vertex(NamedTuple):
    """Quantities that depend on the position and on wi alone."""

    # Per channel the terms of f, Dr.Jit floats; one list if all channels have the same code.
    decoder_terms: list[list]
    proposal: Any  # a mixture, of the mean code over the channels; None if it is not needed


class Held:
    """Codes whose f is a function of a vertex's terms, wi and wo."""

    channels: int

    def _evaluated(self) -> Callable[..., list]:
        """The function from terms, wi and wo to f of each channel, or of one for all."""
        raise NotImplementedError

    def f(self, vertex: Vertex, si, wo, active) -> list:
        """The BRDF [1/sr] of each channel for si.wi and wo above the horizon."""
        values = only_where(active, self._evaluated(), vertex.decoder_terms, si.wi, wo)
        return self._of_each_channel(values)

    def f_and_pdf(self, vertex: Vertex, si, wo, active) -> tuple[list, Any]:
        """`f`, and the density of the proposal [1/sr]."""
        f_of_terms = self._evaluated()

        def evaluated(terms, proposal, wi, wo):
            return f_of_terms(terms, wi, wo), proposal.pdf(wi, wo)

        values, pdf = only_where(active, evaluated, *vertex, si.wi, wo)
        return self._of_each_channel(values), pdf

    def _of_each_channel(self, values: list) -> list:
        lanes = dr.size_v(mi.Spectrum) if self.channels == spectrum.COUNT else self.channels
        return values * lanes if len(values) == 1 else values


class ConstantLatents(Held):
    """One latent code per channel. What depends on the codes alone is computed once, here."""

    # For frozen functions
    DRJIT_STRUCT: ClassVar = dict.fromkeys(("_decoder_terms", "_tables", "_proposals"), list)

    grid: TexelGrid | None = None  # the same everywhere

    def __init__(self, material: Material, half: bool = False):
        """Take the codes of a material, without its rotation.

        half: whether the table has half precision, as the material's has.
        """
        self.material = material = replace(material, rotation=0.0, coating=None)
        self.model, self.channels = material.model, material.channels
        model, latents, table = material.model, material.latents, material.table
        if table is None and (latents == latents[:1]).all():
            latents = latents[:1]  # channels of the same code are evaluated once
        self._fine = len(latents) == spectrum.COUNT
        whole = table is not None and not material.beside_lobe
        kind = NO_LOBE if whole else kind_of_codes(model, latents[None])
        self._sampler = CodeProposals(model, kind)
        self._decoder: BasisDecoder | TabulatedDecoder
        self._tables = []
        if model.widths == 2:
            self._decoder = BasisDecoder(model, kind)
        else:
            self._decoder = TabulatedDecoder(kind, material.knots)
            table = model.networks.table(latents) if table is None else table
            if table is not None:
                table = np.moveaxis(table, -1, 0)[..., None] if self._fine else table
                self._tables = [stored(table, half)]
        if self._fine:
            rows = np.stack([self._decoder.code_terms(z[None])[0] for z in latents])
            self._decoder_terms, self._kind = [owned(mi.Float, rows)], kind
        else:
            self._decoder_terms = [_opaque(terms) for terms in self._decoder.code_terms(latents)]
        mean = material.latents.mean(axis=0)
        self._proposals = [owned(mi.Float, x) for x in self._sampler.tabulated(mean)]

    def vertex(self, si, active) -> Vertex:
        """The vertex at a surface interaction."""
        # The table is no argument: it has another width than the directions.
        propose = partial(self._sampler.proposal_of_table, self._proposals)
        proposal = only_where(active, propose, si.wi)
        return self.bare_vertex(si)._replace(proposal=proposal)

    def bare_vertex(self, si) -> Vertex:
        """The vertex without its proposal, from which `f` follows."""
        terms = self._terms_at(si.wavelengths) if self._fine else self._decoder_terms
        return Vertex(terms, None)

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

    def _evaluated(self) -> Callable[..., list]:
        """The function from terms, wi and wo to f. The tables are no arguments, as in `vertex`."""
        f_of_terms: Callable = self._decoder.f_of_terms
        if isinstance(self._decoder, TabulatedDecoder):
            f_of_terms = partial(f_of_terms, self._tables)
        if not self._fine:
            return f_of_terms
        if not self._tables:
            return lambda terms, wi, wo: f_of_terms(terms[:-1], wi, wo)
        return lambda terms, wi, wo: f_of_terms(terms[:-1], wi, wo, bands=terms[-1])

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Latent codes (M, C, size) at points uv (M, 2)."""
        latents = self.material.latents
        return np.broadcast_to(latents, (len(uv), *latents.shape))

    def save(self, path: str | os.PathLike) -> None:
        """Write a file that `neural_brdf` and `urushi.load` read."""
        self.material.save(path)

    def __str__(self) -> str:
        count, size = self.material.latents.shape
        table = "" if self.material.table is None else ", with a table"
        return f"{count} x {size}{table}"


class TexturedLatents(Held):
    """A packed texture of latent codes, see `textures.packing`.

    They are rendered by principal numbers where these are fewer (`textures.principal`).
    """

    material = None

    DRJIT_STRUCT: ClassVar = {"_texture": object, "_decoder": object}  # for frozen functions
    UNRECORDED: ClassVar = ("_store", "_principal")  # kernels read `_texture` and `_decoder`

    def __init__(self, model: Model, store: TextureStore, grid: TexelGrid):
        self._store, self.model = store, model
        self.grid, self.channels = grid, store.layout.channels
        self._size, self._bytes = store.layout.size, store.layout.texel_bytes
        self._kind = kind_of_store(model, store)
        self._principal = principal_texture(model, store)
        self._sampler = CodeProposals(model, self._kind)
        # Channels of the same code are evaluated once.
        self._kept = 1 if (store.layout.constant | store.layout.same).all() else self.channels
        if self._principal is None:
            self._decoder = BasisDecoder(model, self._kind)
            self._texture = LatentTexture(store, grid)
        else:
            self._decoder = BasisDecoder(model, self._kind, self._principal.functions)
            self._texture = LatentTexture(self._principal.scaled(FUNCTION_SCALE), grid)

    def vertex(self, si, active) -> Vertex:
        """The vertex at a surface interaction."""
        return only_where(active, self._vertex, si.wi, si.uv)

    def _evaluated(self) -> Callable[..., list]:
        return self._decoder.f_of_terms

    def _vertex(self, wi, uv) -> Vertex:
        return self._vertex_of(self._texture.look_up(uv, wi)[: self._kept], wi)

    def _vertex_of(self, latents: list[list], wi) -> Vertex:
        """The vertex of the numbers that the texture holds for each channel."""
        if self._principal is None:
            proposal = self._sampler.proposal(self._kind.mean(latents), wi)
        else:
            assert isinstance(self._sampler, CodeProposals)  # for the type checker
            lobe, first = self.model.arch.lobe, self._principal.first
            mean = self._kind.mean([z[:lobe] for z in latents])
            proposal = self._sampler.proposal_of_terms(mean, latents[0][lobe:first], wi)
            latents = [z[:lobe] + z[first:] for z in latents]
        return Vertex(self._decoder.code_terms_drjit(latents), proposal)

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Latent codes (M, C, size) at points uv (M, 2)."""
        return self._store.read(self._texture.texels(uv))

    def save(self, path: str | os.PathLike) -> None:
        """Write a file that `neural_brdf` reads."""
        write_texture(path, self._store, self.grid, self.model.fingerprint)

    def __str__(self) -> str:
        return (
            f"{self.grid.width} x {self.grid.height} texels of {self.channels} x {self._size} "
            f"numbers in {self._bytes} bytes"
        )


def kind_of_codes(model: Model, codes: np.ndarray) -> LobeKind:
    """Common properties of the lobes of codes (T, C, size)."""
    lobes = codes[..., : model.arch.lobe]
    same = (lobes == lobes[:, :1]).all(axis=(0, 1))
    return kind_of(lobes.min(axis=(0, 1)), lobes.max(axis=(0, 1)), same)


def kind_of_store(model: Model, store: TextureStore) -> LobeKind:
    """Common properties of the lobes of a texture."""
    layout, packed = store.layout, store.packed
    highest, lobe = packed.lowest + layout.levels * packed.step, slice(model.arch.lobe)
    return kind_of(packed.lowest[lobe], highest[lobe], (layout.constant | layout.same)[lobe])


def _opaque(values: np.ndarray) -> list:
    """Dr.Jit scalars that kernels read from memory, so that all materials share compiled code."""
    scalars = [mi.Float(float(value)) for value in values]
    dr.make_opaque(scalars)
    return scalars
