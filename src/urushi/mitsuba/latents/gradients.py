"""Baking with gradients: latent codes that are differentiable in the parameters of a scene.

Where a parameter of a coat or of its bottom carries a gradient, `bake` adds codes with derivatives
to those of `baking.Baker`. The bottom's values at the probe pairs, or the parameters of a surface
that is known by them, are differentiated by Dr.Jit. Encoder and layerer are custom operations of
Dr.Jit, whose derivatives NumPy computes (`material.gradients`).
"""

from collections.abc import Sequence

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi import checks
from urushi.checks import CoatParameters, Widths
from urushi.material import gradients
from urushi.material.layer import layer_texels, within_training
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents import lookup
from urushi.mitsuba.latents.baking import Baker
from urushi.mitsuba.latents.bottoms import PROBED_TEXELS, is_finer
from urushi.mitsuba.latents.differentiable import DifferentiableLatents
from urushi.mitsuba.latents.holders import ConstantLatents, TexturedLatents
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.grid import varying_textures
from urushi.mitsuba.reading.parameters import TWO_WIDTHS, CoatTextures
from urushi.mitsuba.reading.surfaces import known_surface
from urushi.nets.lobe import no_lobe
from urushi.nets.networks import UrushiNetworks
from urushi.nets.weights import Model
from urushi.textures.grid import IDENTITY, TexelGrid

#: For each channel a list of Dr.Jit floats, each with one entry per point, or one for all points.
Columns = Sequence[Sequence]

#: Largest number of rotations of an anisotropic bottom, twice an odd number: all are traced
#: together.
AZIMUTHS = 14

#: The grid of a bottom without textures.
MIDDLE = TexelGrid(1, 1, IDENTITY, "repeat", False)


def wanted(bsdf: "mi.BSDF") -> bool:
    """Whether any parameter of a BSDF carries a gradient; read-only codes do not count."""
    parameters = mi.traverse(bsdf)
    flags, read_only = parameters.flags, mi.ParamFlags.ReadOnly
    return any(dr.grad_enabled(value) for key, value in parameters if not flags(key) & read_only)


def bake(
    baker: Baker,
    coat: CoatTextures,
    bottom: "mi.BSDF",
    plain: ConstantLatents | TexturedLatents,
) -> DifferentiableLatents:
    """Add codes that are differentiable in the parameters to the latents of `baker.update`.

    Raises:
        ParameterError: the networks have no derivatives.
    """
    model, grid = baker.model, plain.grid
    gradients.check_differentiable(model, coat.where)
    with spectrum.bands_of(grid):
        return DifferentiableLatents(model, plain, _codes(baker, coat, bottom, grid))


def _codes(
    baker: Baker, coat: CoatTextures, bottom: "mi.BSDF", grid: TexelGrid | None
) -> "mi.TensorXf":
    """The codes of `bake`, ([1,] C, size), or (height, width, C, size) on a grid."""
    model = baker.model
    uv = grid.uv() if grid else np.full((1, 2), 0.5)
    table = coat.layering(uv)
    si = probing.interaction(np.tile([0.0, 0.0, 1.0], (len(uv), 1)), uv)
    by_name = coat.channels(si)
    if model.widths == 2 and "alpha" in by_name:
        by_name |= dict.fromkeys(TWO_WIDTHS, by_name["alpha"])
    parameters = [by_name[name] for name in checks.COAT_COLUMNS[model.widths]]
    codes = layer(model, table, _bottom_codes(baker, coat.where, bottom, uv, grid), parameters)
    if grid is not None:
        codes = mi.TensorXf(codes.array, (grid.height, grid.width, *codes.shape[1:]))
    return codes


def _bottom_codes(
    baker: Baker, where: str, bottom: "mi.BSDF", uv: np.ndarray, grid: TexelGrid | None
) -> Columns:
    """The bottom's codes at points uv (M, 2), or one code if it is the same everywhere."""
    model, nested = baker.model, getattr(bottom, "latents", None)
    same_networks = nested is not None and bottom.model.fingerprint == model.fingerprint
    if same_networks and isinstance(nested, DifferentiableLatents):
        point = mi.Point2f(np.ascontiguousarray(uv.T, np.float32))
        codes = nested.codes(point, mi.Vector3f(0, 0, 1))
        return [codes[i] for i in spectrum.FINE_AT_RGB] if is_finer(nested) else codes
    if grid is None or (nested is None and not varying_textures(bottom)):
        grid, uv = MIDDLE, MIDDLE.uv()
    wi, wo = model.networks.pairs()
    fixed = not wanted(bottom)
    with dr.suspend_grad():
        baker.bottom.bake()  # the coat's texture may come from the disk
        plain = baker.bottom.read(0, len(uv))
        # A random walk's loop cannot be differentiated.
        if fixed or probing.needed_repeats(bottom, wi, wo, len(uv)) > 1:
            return columns(plain)
    surface, lobes = known_surface(bottom), []
    if surface is not None and not surface.bare:
        lobes = [[mi.Float(x) for x in no_lobe(model.widths)]] * spectrum.channel_count()
    elif surface is not None:
        lobes = surface.lobes(uv)
    elif method := getattr(bottom, "lobes", None):
        si = probing.interaction(np.tile([0.0, 0.0, 1.0], (len(uv), 1)), uv)
        lobes = spectrum.at_bands(si, lambda: method(si) or [])
    if lobes and len(lobes[0]) > model.arch.lobe:
        lobes = []  # the average over the azimuth is fitted
    lobes = [[*lobe, *lobe[: model.arch.lobe - len(lobe)]] for lobe in lobes]
    if lobes and (surface.bare if surface is not None else getattr(bottom, "bare", False)):
        assert isinstance(model.networks, UrushiNetworks)  # for the type checker
        rest = [mi.Float(float(value)) for value in model.networks.empty_rest()]
        return [[*lobe, *rest] for lobe in lobes]
    with dr.suspend_grad():
        average = probing.needed_averaging(bottom, wi, wo, grid, where, model.widths)
    starts = range(0, len(uv), PROBED_TEXELS)
    parts = [_probed(bottom, wi, wo, uv[i : i + PROBED_TEXELS], average) for i in starts]
    return encode(model, parts, lobes, plain)


def _probed(
    bottom: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, uv: np.ndarray, average: probing.Averaging
) -> list:
    """`probing.texel_values` with gradients: per channel f (M * P) [1/sr] at points uv (M, 2)."""
    average = average._replace(azimuths=min(average.azimuths, AZIMUTHS))
    averaged = average.pairs(wi, wo)
    everywhere = np.repeat(uv, len(wi), axis=0)
    total = [dr.zeros(mi.Float, len(everywhere))] * spectrum.channel_count()
    for pair in averaged:
        a, b = (np.tile(w, (len(uv), 1)) for w in pair)
        for one, other in ((a, b), (b, a))[: 1 + average.exchanged]:
            out = mi.Vector3f(np.ascontiguousarray(other.T))
            channels = probing.bsdf_channels(bottom, probing.interaction(one, everywhere), out)
            total = [a + b for a, b in zip(total, channels, strict=True)]
    return [value / (len(averaged) * (1 + average.exchanged)) for value in total]


def encode(model: Model, parts: Sequence[Sequence], lobes: Columns, anchors: np.ndarray) -> Columns:
    """Anchors of a bottom, differentiable in its values and lobes: L columns per channel.

    parts: groups of points; for each group and channel f (M * P) [1/sr] at the probe pairs.
    lobes: the lobes of each channel if they are known; empty: they are fitted to the values.
    anchors: (M or 1, C, L) as they are without gradients, see `gradients.linearised`.
    """
    return dr.custom(_Encode, model, list(parts), lobes, anchors)


def layer(
    model: Model, table: dict[str, np.ndarray], z_bottom: Columns, coat: Columns
) -> "mi.TensorXf":
    """`material.layer.layer_texels`, differentiable in the bottoms' codes and the coats.

    table: the coats' checked parameters, (M or 1, C or 1), in double precision.
    coat: the same in the order of `checks.COAT_COLUMNS`: a column per parameter, or per channel.

    Returns:
        Codes (M, C, L).
    """
    return dr.custom(_Layer, model, table, z_bottom, coat)


def columns(values: np.ndarray) -> Columns:
    """Values (M, C, K) as Dr.Jit floats, K for each channel."""
    channels = np.moveaxis(values, 1, 0)
    return [[mi.Float(np.ascontiguousarray(k, np.float32)) for k in z.T] for z in channels]


def rows(columns: Columns, points: int = 1) -> np.ndarray:
    """The values (M, C, K) of columns, K for each channel; M is at least `points`."""
    arrays = [column.numpy() for channel in columns for column in channel]
    points = max(points, *map(len, arrays))
    stacked = np.stack([np.broadcast_to(array, points) for array in arrays], axis=-1)
    return stacked.reshape(points, len(columns), -1)


class _Encode(dr.CustomOp):
    def eval(self, model, parts, lobes, anchors):
        self._model, self._pairs = model, len(model.networks.pairs()[0])
        self._points = [len(part[0]) // self._pairs for part in parts]
        f, self._fitted = self._joined(parts), not lobes
        anchors = np.broadcast_to(anchors, (*f.shape[:2], anchors.shape[-1]))
        self._shape, self._f = anchors.shape, _flat(f)
        self._z = gradients.linearised(model, self._f, _flat(anchors))
        return columns(self._z.reshape(self._shape))

    def forward(self):
        df, dlobe = _flat(self._joined(self.grad_in("parts"))), None
        if not self._fitted:
            dlobe = _flat(rows(self.grad_in("lobes"), self._shape[0]))
        dz = gradients.encode_pushforward(self._model, self._f, self._z, df, dlobe)
        self.set_grad_out(columns(dz.reshape(self._shape)))

    def backward(self):
        dz = _flat(rows(self.grad_out(), self._shape[0]))
        df, dlobe = gradients.encode_pullback(self._model, self._f, self._z, dz, self._fitted)
        parts = np.split(df.reshape(*self._shape[:2], -1), np.cumsum(self._points)[:-1])
        channels = [np.moveaxis(part, 1, 0).reshape(part.shape[1], -1) for part in parts]
        self.set_grad_in("parts", [[mi.Float(f) for f in part] for part in channels])
        if not self._fitted:
            self.set_grad_in("lobes", columns(dlobe.reshape(*self._shape[:2], -1)))

    def _joined(self, parts):
        """The values (M, C, P) of all parts."""
        arrays = [
            rows([part], count * self._pairs).reshape(count, self._pairs, -1)
            for part, count in zip(parts, self._points, strict=True)
        ]
        return np.moveaxis(np.concatenate(arrays), -1, 1)

    def name(self):
        return "encode"


class _Layer(dr.CustomOp):
    def eval(self, model, table, z_bottom, coat):
        bottom = rows(z_bottom)
        z = layer_texels(model, bottom, **table)
        chosen = within_training(CoatParameters(**table))
        if model.widths == 2 and not isinstance(chosen.alpha, Widths):
            chosen = chosen._replace(alpha=Widths(chosen.alpha, chosen.alpha))
        coats = np.stack(np.broadcast_arrays(*chosen.columns()), axis=-1)
        self._model, self._shape = model, z.shape
        self._channels = [len(parameter) for parameter in coat]
        self._inputs = (
            _flat(np.broadcast_to(bottom, z.shape)),
            _flat(np.broadcast_to(coats, (*z.shape[:-1], coats.shape[-1]))),
            _flat(z),
        )
        return mi.TensorXf(lookup.owned(mi.Float, z), z.shape)

    def forward(self):
        points, channels, _ = self._shape
        dz_bottom = np.broadcast_to(rows(self.grad_in("z_bottom"), points), self._shape)
        changes = [rows([parameter], points)[:, 0] for parameter in self.grad_in("coat")]
        dcoat = np.stack([np.broadcast_to(c, (points, channels)) for c in changes], axis=-1)
        dz = gradients.layer_pushforward(self._model, *self._inputs, _flat(dz_bottom), _flat(dcoat))
        self.set_grad_out(mi.TensorXf(dz.reshape(self._shape)))

    def backward(self):
        points, channels, _ = self._shape
        dz = _flat(self.grad_out().numpy().reshape(self._shape))
        of_bottom, of_coat = gradients.layer_pullback(self._model, *self._inputs, dz)
        self.set_grad_in("z_bottom", columns(of_bottom.reshape(self._shape)))
        of_coat = np.moveaxis(of_coat.reshape(points, channels, -1), -1, 0)
        summed = [
            gradient if count > 1 else gradient.sum(axis=1, keepdims=True)
            for gradient, count in zip(of_coat, self._channels, strict=True)
        ]
        self.set_grad_in("coat", [columns(gradient[:, None])[0] for gradient in summed])

    def name(self):
        return "layer"


def _flat(array: np.ndarray) -> np.ndarray:
    return array.reshape(-1, array.shape[-1])
