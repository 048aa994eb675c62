"""Latent codes with gradients: values of the plain latents, derivatives of the codes.

Where a parameter of a coat or of its bottom carries a gradient, `bake` adds codes with derivatives
to the plain codes (`coding`). Dr.Jit also differentiates the bottom's values at the probe pairs, or
the parameters of a surface that is known by them.

f has the same bits as without gradients. Its derivatives come from codes that the network layers,
within the ranges of the parameters, so that they may give another f. Integrators evaluate a picture
without derivatives first; these codes are not evaluated then. A table by light transport has slopes
of its own by every number that carries a gradient (`table_gradients`), and codes give the
derivatives of the lobe beside it.

Only f is differentiated with respect to codes. Proposals depend on detached codes: as in all of
Mitsuba's differentiable integrators, samples are fixed while the integrand changes.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi import checks
from urushi.core.table import node_pairs
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents import coding, table_gradients
from urushi.mitsuba.latents.baking import Baker
from urushi.mitsuba.latents.bottoms import PROBED_TEXELS, is_finer
from urushi.mitsuba.latents.holders import ConstantLatents, TexturedLatents
from urushi.mitsuba.latents.lookup import drawn_texel, texel_draw
from urushi.mitsuba.networks.basis import BasisDecoder
from urushi.mitsuba.networks.lobe import ANY_LOBE
from urushi.mitsuba.networks.lobe import f as lobe_f
from urushi.mitsuba.networks.table import TabulatedDecoder
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.grid import varying_textures
from urushi.mitsuba.reading.kept import writable
from urushi.mitsuba.reading.offers import offer_of, tabulated
from urushi.mitsuba.reading.parameters import TWO_WIDTHS, CoatTextures
from urushi.mitsuba.recording import only_where
from urushi.nets.weights import Model
from urushi.textures.store import MIDDLE, TexelGrid

#: Largest number of rotations of an anisotropic bottom, twice an odd number: all are traced
#: together.
AZIMUTHS = 14


class DifferentiableLatents:
    """Latents with the gradients of codes; everything else is as in the plain latents."""

    # For frozen functions
    DRJIT_STRUCT: ClassVar = {"plain": object, "_codes": object, "_tables": list}

    def __init__(
        self,
        model: Model,
        plain: ConstantLatents | TexturedLatents,
        tensor: "mi.TensorXf",
        logs: Sequence | None = None,
    ):
        """tensor: the codes, ([1,] C, size), or (height, width, C, size) of a texture.

        logs: ln f of each channel at the nodes, if a table gives f beside the lobes of the codes.
        """
        self.model, self.plain, self.logs = model, plain, logs
        self.vertex, self.at, self.save = plain.vertex, plain.at, plain.save
        self.channels, self.grid = plain.channels, plain.grid
        self.material = plain.material
        self.table = mi.TensorXf() if logs is None else table_gradients.interleaved(logs)
        self._tables = [] if logs is None else [self.table.array]
        dr.make_opaque(self._tables)
        # Numbers that vanish or that channels share have gradients of their own.
        kind = ANY_LOBE._replace(widths=model.widths)
        self._decoder = BasisDecoder(model, kind)
        self._tabulated, self._lobe = TabulatedDecoder(kind), kind.size
        self._size = tensor.shape[-1]
        if plain.grid is None:
            self.tensor, self._codes = tensor, tensor.array
            dr.make_opaque(self._codes)
            return
        numbers = plain.channels * self._size
        self.tensor = mi.TensorXf(tensor.array, (plain.grid.height, plain.grid.width, numbers))
        self._codes = self.tensor.array

    def f(self, vertex, si, wo, active) -> list:
        """The BRDF [1/sr] of each channel for si.wi and wo above the horizon."""
        return self._with_gradients(self.plain.f(vertex, si, wo, active), si, wo, active)

    def f_and_pdf(self, vertex, si, wo, active) -> tuple[list, Any]:
        """`f`, and the density of the proposal [1/sr]."""
        values, pdf = self.plain.f_and_pdf(vertex, si, wo, active)
        return self._with_gradients(values, si, wo, active), pdf

    def codes(self, uv: "mi.Point2f", wi: "mi.Vector3f") -> list[list]:
        """Codes with gradients at points uv: of each channel a list (size) of Dr.Jit floats.

        Those of a texture are drawn as in `lookup`, seen from wi.
        """
        grid, count = self.plain.grid, self.plain.channels * self._size
        first = mi.UInt32(0)
        if grid is not None:
            (a, b, c), (d, e, f) = grid.to_texture
            point = a * uv.x + b * uv.y + c, d * uv.x + e * uv.y + f
            sizes = mi.Int32(grid.width), mi.Int32(grid.height)
            first = count * drawn_texel(point, sizes, grid, texel_draw(uv, wi))
        # Gathered at every call: an argument of a nested call must be the result of an operation in
        # the outer call, or Dr.Jit loses its gradient.
        numbers = [dr.gather(mi.Float, self._codes, first + i) for i in range(count)]
        return [numbers[i : i + self._size] for i in range(0, count, self._size)]

    def _codes_of_bands(self, si) -> list[list]:
        """The codes (size) of the band of each wavelength."""
        size = self._size
        return [
            [dr.gather(mi.Float, self._codes, band * size + i) for i in range(size)]
            for band in spectrum.band_at(si.wavelengths)
        ]

    def _with_gradients(self, values: list, si, wo, active) -> list:
        """Values with derivatives by the codes, besides their own derivatives by the directions."""
        bands = self.plain.channels == spectrum.COUNT
        codes = self._codes_of_bands(si) if bands else self.codes(si.uv, si.wi)
        if not dr.grad_enabled(codes):
            return values
        directions = dr.detach(si.wi), dr.detach(wo)
        evaluate: Callable[..., list] = self._decoder.f
        if self._tables:
            codes = [code[: self._lobe] for code in codes]
            places = {"bands": spectrum.band_at(si.wavelengths)} if bands else {}
            evaluate = partial(self._tabulated.f_of_terms, self._tables, **places)
        changing = only_where(active, evaluate, codes, *directions)
        return [
            value + (change - dr.detach(change))
            for value, change in zip(values, changing, strict=True)
        ]


def wanted(bsdf: "mi.BSDF") -> bool:
    """Whether any parameter of a BSDF carries a gradient; read-only codes do not count."""
    return bool(_numbers(bsdf))


def _numbers(bsdf: "mi.BSDF") -> list:
    """The parameters of a BSDF that carry gradients, as flat arrays, each once."""
    values = [value for _, value in writable(bsdf) if dr.grad_enabled(value)]
    arrays = [x for value in values for x in _flat_arrays(value) if dr.grad_enabled(x)]
    return list({x.index_ad: x for x in arrays}.values())


def _flat_arrays(value: Any) -> list:
    if dr.is_tensor_v(value):
        return [value.array]
    return [value] if dr.depth_v(value) == 1 else [x for part in value for x in _flat_arrays(part)]


def bake(
    baker: Baker,
    coat: CoatTextures,
    bottom: "mi.BSDF",
    plain: ConstantLatents | TexturedLatents,
) -> DifferentiableLatents:
    """Add codes that are differentiable in the parameters to the latents of `baker.update`."""
    model, grid = baker.model, plain.grid
    with spectrum.bands_of(grid):
        tensor, numbers = (
            _codes(baker, coat, bottom, grid),
            _transported(baker, coat, bottom, plain),
        )
        if model.widths == 1 or numbers is None:
            return DifferentiableLatents(model, plain, tensor, numbers)
        place, size = dr.arange(mi.UInt32, model.arch.lobe), model.arch.latent
        of_lobes = [
            dr.gather(mi.Float, tensor.array, place + c * size) for c in range(len(numbers))
        ]
        codes = dr.concat([x for pair in zip(of_lobes, numbers, strict=True) for x in pair])
        return DifferentiableLatents(model, plain, mi.TensorXf(codes, (len(numbers), size)))


def _codes(
    baker: Baker, coat: CoatTextures, bottom: "mi.BSDF", grid: TexelGrid | None
) -> "mi.TensorXf":
    """The codes of `bake`, ([1,] C, size), or (height, width, C, size) on a grid."""
    model = baker.model
    uv = grid.uv() if grid else np.full((1, 2), 0.5)
    si = probing.interaction(np.tile([0.0, 0.0, 1.0], (len(uv), 1)), uv)
    by_name = coat.channels(si)
    if model.widths == 2 and "alpha" in by_name:
        by_name |= dict.fromkeys(TWO_WIDTHS, by_name["alpha"])
    parameters = [by_name[name] for name in checks.COAT_COLUMNS[model.widths]]
    below = _bottom_codes(baker, coat.where, bottom, uv, grid)
    codes = coding.layered(model, coat.layering(uv), below, parameters)
    if grid is not None:
        codes = mi.TensorXf(codes.array, (grid.height, grid.width, *codes.shape[1:]))
    return codes


def _transported(baker: Baker, coat: CoatTextures, bottom: "mi.BSDF", plain: Any) -> list | None:
    """`table_gradients.attached` of constant coats by light transport; None: they are others."""
    below = baker.bottom.material
    material = tabulated(plain) if baker.model.widths == 1 else plain.material
    if material is None or below is None:
        return None
    if material.table is None and np.array_equal(material.latents, below.latents):
        return None  # the coat is absent
    offer, values, codes = offer_of(bottom), [], None
    if wanted(bottom):
        nested = offer.latents
        if isinstance(nested, DifferentiableLatents) and nested.logs is not None:
            values = [dr.exp(log) for log in nested.logs]
        elif below.table is not None:
            exact, (wi, wo) = offer.exact() or bottom, node_pairs()
            si = probing.interaction(wi, np.full((len(wi), 2), 0.5))
            out = mi.Vector3f(np.ascontiguousarray(wo.T))
            values = probing.bsdf_channels(exact, si, out)
            if below.beside_lobe:
                known = spectrum.at_bands(si, lambda: offer.lobes(si) or [])
                tops = lobe_f(known, si.wi, out, ANY_LOBE)
                values = [dr.maximum(f - top, 0) for f, top in zip(values, tops, strict=True)]
        if not values or below.beside_lobe:
            codes = _bottom_codes(baker, coat.where, bottom, MIDDLE.uv(), None)
    return table_gradients.attached(material, coat, below, _numbers(bottom), values, codes)


def _bottom_codes(
    baker: Baker, where: str, bottom: "mi.BSDF", uv: np.ndarray, grid: TexelGrid | None
) -> "mi.TensorXf":
    """The bottom's codes (M, C, L) at points uv (M, 2); M is 1 if they are the same everywhere."""
    model, offer = baker.model, offer_of(bottom)
    nested = offer.latents
    same_networks = nested is not None and nested.model.fingerprint == model.fingerprint
    if same_networks and isinstance(nested, DifferentiableLatents):
        point = mi.Point2f(np.ascontiguousarray(uv.T, np.float32))
        codes = nested.codes(point, mi.Vector3f(0, 0, 1))
        return _tensor([codes[i] for i in spectrum.FINE_AT_RGB] if is_finer(nested) else codes)
    if grid is None or (nested is None and not varying_textures(bottom)):
        grid, uv = MIDDLE, MIDDLE.uv()
    (wi, wo), fixed = model.networks.pairs(), not wanted(bottom)
    with dr.suspend_grad():
        baker.bottom.bake()  # the coat's texture may come from the disk
        plain = baker.bottom.read(0, len(uv))
        # A random walk's loop cannot be differentiated.
        if fixed or probing.needed_repeats(bottom, wi, wo, len(uv)) > 1:
            return mi.TensorXf(plain)
    si = probing.interaction(np.tile([0.0, 0.0, 1.0], (len(uv), 1)), uv)
    lobes = spectrum.at_bands(si, lambda: offer.lobes(si) or [])
    if lobes and len(lobes[0]) > model.arch.lobe:
        lobes = []  # the average over the azimuth is fitted
    lobes = [[*lobe, *lobe[: model.arch.lobe - len(lobe)]] for lobe in lobes]
    if offer.reflectance is not None:
        reflectance = partial(offer.reflectance, si)
        return _tensor(coding.diffuse(model, spectrum.at_bands(si, reflectance)))
    if lobes and offer.bare:
        rest = [mi.Float(float(value)) for value in model.networks.empty_rest()]
        return _tensor([[*lobe, *rest] for lobe in lobes])
    with dr.suspend_grad():
        average = probing.needed_averaging(bottom, wi, wo, grid, where, model.widths)
    average = average._replace(azimuths=min(average.azimuths, AZIMUTHS))
    blocks = [uv[i : i + PROBED_TEXELS] for i in range(0, len(uv), PROBED_TEXELS)]
    parts = [probing.averaged_channels(bottom, wi, wo, block, average) for block in blocks]
    f = [dr.concat(channel) for channel in zip(*parts, strict=True)]
    return coding.encoded(model, f, _tensor(lobes) if lobes else None, plain)


def _tensor(channels: Sequence[Sequence]) -> "mi.TensorXf":
    """A tensor (M, C, K) of K Dr.Jit floats, (M) or of one number, for each of C channels."""
    columns = [x for channel in channels for x in channel]
    points = max(map(len, columns))
    shape = points, len(channels), len(channels[0])
    return mi.TensorXf(coding.stacked(columns, points).array, shape)
