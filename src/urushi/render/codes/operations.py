"""Encoding and layering as operations of Dr.Jit's differentiation, computed by NumPy."""

from collections.abc import Sequence

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.material import gradients
from urushi.material.texture import encode_texels, layer_texels
from urushi.nets.weights import Model
from urushi.render.codes import arrays
from urushi.render.reading import probing

#: Of each channel, numbers of M points as Dr.Jit floats of that size, or of one for all points.
Columns = Sequence[Sequence]

#: In the order of derivatives.
COAT = ("alpha", "eta", "albedo", "sigma_t", "g")


def encode(model: Model, where: str, parts: Sequence[Sequence]) -> Columns:
    """`material.texture.encode_texels`, attached to f: codes, 32 columns a channel.

    parts: the points in groups, f (M * P) [1/sr] of each channel and group at the probe pairs.
    where: begins errors.

    Raises:
        ParameterError: f is negative or not finite.
    """
    return dr.custom(_Encode, model, where, list(parts))


def layer(
    model: Model, table: dict[str, np.ndarray], z_bottom: Columns, coat: Columns
) -> "mi.TensorXf":
    """`material.texture.layer_texels`, attached to the bottoms' codes and to coats.

    table: the coats' checked parameters, (M or 1, C or 1), in double precision.
    coat: the same in the order of `COAT`: of each parameter a column, or one for each channel.

    Returns:
        Codes (M, C, 32).
    """
    return dr.custom(_Layer, model, table, z_bottom, coat)


def columns(values: np.ndarray) -> Columns:
    """Numbers (M, C, K) as Dr.Jit floats, K of each channel."""
    channels = np.moveaxis(values, 1, 0)
    return [[mi.Float(np.ascontiguousarray(k, np.float32)) for k in z.T] for z in channels]


def rows(columns: Columns, points: int = 1) -> np.ndarray:
    """The numbers (M, C, K) in columns, K of each channel; M is at least `points`."""
    arrays = [column.numpy() for channel in columns for column in channel]
    points = max(points, *map(len, arrays))
    stacked = np.stack([np.broadcast_to(array, points) for array in arrays], axis=-1)
    return stacked.reshape(points, len(columns), -1)


class _Encode(dr.CustomOp):
    def eval(self, model, where, parts):
        self._model, self._pairs = model, len(model.networks.pairs()[0])
        self._points = [len(part[0]) // self._pairs for part in parts]
        self._f = probing.checked(self._joined(parts), where)
        self._z = encode_texels(model, self._f)
        return columns(self._z)

    def forward(self):
        df = self._joined(self.grad_in("parts"))
        dz = gradients.encode_pushforward(self._model, *map(_flat, (self._f, self._z, df)))
        self.set_grad_out(columns(dz.reshape(self._z.shape)))

    def backward(self):
        dz = rows(self.grad_out(), len(self._z))
        df = gradients.encode_pullback(self._model, *map(_flat, (self._f, self._z, dz)))
        parts = np.split(df.reshape(self._f.shape), np.cumsum(self._points)[:-1])
        channels = [np.moveaxis(part, 1, 0).reshape(part.shape[1], -1) for part in parts]
        self.set_grad_in("parts", [[mi.Float(f) for f in part] for part in channels])

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
        coats = np.stack(np.broadcast_arrays(*(table[name] for name in COAT)), axis=-1)
        self._model, self._shape = model, z.shape
        self._channels = [len(parameter) for parameter in coat]
        self._inputs = (
            _flat(np.broadcast_to(bottom, z.shape)),
            _flat(np.broadcast_to(coats, (*z.shape[:-1], len(COAT)))),
            _flat(z),
        )
        return mi.TensorXf(arrays.owned(mi.Float, z), z.shape)

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
