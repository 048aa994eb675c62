"""Codes of values and of coats with derivatives by Dr.Jit.

Codes have the values that NumPy computes. Dr.Jit differentiates the formulas of `core` and `nets`
at these values. NumPy multiplies by matrices: the network's weights, and the derivatives of least
squares, of fitted lobes and of the energy limit.

Codes are tensors (M, C, L) of M points, or one for all points, and C channels. Functions of codes
have N = M C rows.
"""

from collections.abc import Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import CoatParameters, Widths
from urushi.core.namespace import DRJIT
from urushi.material import energy
from urushi.material.layer import absent, layer_texels, within_training
from urushi.mitsuba.latents.bottoms import white_code
from urushi.mitsuba.networks import lobe as lobes
from urushi.mitsuba.networks.mlp import activate
from urushi.mitsuba.recording import owned
from urushi.nets import code_fit
from urushi.nets.features import COATS, coat_columns
from urushi.nets.layerer import LEAST_GAIN
from urushi.nets.lobe_fit_slopes import FITTED, fit_slopes
from urushi.nets.mlp import linear
from urushi.nets.weights import Model
from urushi.parallel import fill_blocks

#: Reflectance of the diffuse surface at whose code darker rests are differentiated.
LEAST_REFLECTANCE = 0.02

#: Least 1 - albedo and least sigma_t at which the derivatives by the medium of a coat are taken: at
#: the ends of both ranges, the network's slopes are farther from the slopes of light transport.
MIN_ABSORPTION, MIN_DEPTH = 1e-3, 0.02

#: Codes whose gains differ by more were scaled down by the energy limit.
_ROUNDING = 1e-5

#: Codes whose matrices of derivatives by the values are in memory at once.
_MATRICES = 64

#: Places of widths and index among the columns of a coat, and among the numbers of its lobe.
_OF_COAT = {1: ((0, 1), (0, 4)), 2: ((0, 1, 5), (0, 4, 6))}


def stacked(columns: Sequence, count: int) -> "mi.TensorXf":
    """K Dr.Jit floats, each of one number or `count`, as a tensor (count, K)."""
    return dr.custom(_Stack, [column + dr.zeros(mi.Float, count) for column in columns])


def layered(
    model: Model, checked: CoatParameters, bottom: "mi.TensorXf", coat: Sequence[Sequence]
) -> "mi.TensorXf":
    """`layer_texels`, differentiable in the bottoms' codes and the coats.

    checked: the coats' parameters, (M or 1, C or 1), in double precision.
    bottom: (M or 1, C, L).
    coat: the same in the order of `checks.COAT_COLUMNS`: a column per parameter, or per channel.

    Returns:
        Codes (M, C, L). A coat that is absent changes the code of the bottom by its own change.
    """
    chosen, lobe = within_training(checked), model.arch.lobe
    if model.widths == 2 and not isinstance(chosen.alpha, Widths):
        chosen = chosen._replace(alpha=Widths(chosen.alpha, chosen.alpha))
    below = bottom.numpy()
    codes = layer_texels(model, below, checked)
    (points, channels, size), z = codes.shape, codes.reshape(-1, codes.shape[-1])
    row = dr.arange(mi.UInt32, len(z))
    places = row % (len(below) * channels) * size
    own = [dr.gather(mi.Float, bottom.array, places + i) for i in range(size)]
    own[lobe] = dr.maximum(own[lobe], LEAST_GAIN)
    below = np.broadcast_to(below, codes.shape).reshape(z.shape)
    at = np.stack([np.broadcast_to(x, (points, channels)).ravel() for x in chosen.columns()])
    at = at.astype(np.float32)
    moves = []
    for values in coat:
        place = row // channels * len(values) + row % len(values)
        moves.append(_change(dr.gather(mi.Float, stacked(values, points).array, place)))
    inside, share = _inside(at)
    outside, moving = (inside != at).any(axis=0), np.ones_like(at)
    moving[2:5] = ~outside
    moving[[0, *range(5, len(at))]] *= at[1] != 1  # no interface has a width
    # The slope of a root is finite below an albedo of 1.
    finite = np.concatenate([at[:2], np.minimum(at[2:3], 1 - 1e-7), at[3:]])
    first = [x * move for x, move in zip(_rows(moving), moves, strict=True)]
    changes = [mi.Float(0)] * lobe
    for column, number in zip(*_OF_COAT[model.widths], strict=True):
        changes[number] = first[column]
    rests = _columns(_layerer(model, own, finite, first))
    changes += [_change(x + y) for x, y in zip(own[lobe:], rests, strict=True)]
    if outside.any():
        again = [x * move for x, move in zip(_rows(share), moves, strict=True)]
        rests = _columns(_layerer(model, [dr.detach(x) for x in own], inside, again))
        changes[lobe:] = [x + _change(y) for x, y in zip(changes[lobe:], rests, strict=True)]
    none = absent(CoatParameters.of_columns(at))
    unlimited = model.networks.layer(below, CoatParameters.of_columns(at))
    limited = (z[:, lobe] < unlimited[:, lobe] - _ROUNDING) & ~none
    if limited.any():
        slopes = np.zeros((size, len(z)), np.float32)
        slopes[:, limited] = np.stack([energy.factor_slopes(model, x) for x in z[limited]], axis=1)
        changes[lobe] += sum(x * y for x, y in zip(_rows(slopes), changes, strict=True))
    if none.any():
        of_layer, of_bottom = _rows(np.stack([~none, none]))
        parts = zip(own, changes, strict=True)
        changes = [of_bottom * _change(x) + of_layer * y for x, y in parts]
    return _tensor(codes, changes)


def diffuse(model: Model, reflectances: Sequence) -> list[list]:
    """Codes (size) of Lambertian surfaces, one for each reflectance, all Dr.Jit floats.

    Their logarithmic gains are differentiated as in `encoded`.
    """
    code, codes = [mi.Float(float(x)) for x in white_code(model)], []
    for reflectance in reflectances:
        at = dr.maximum(dr.detach(reflectance), LEAST_REFLECTANCE)
        gain = code[model.arch.lobe] + dr.log(at) + _change(reflectance) / at
        codes.append([*code[: model.arch.lobe], gain, *code[model.arch.lobe + 1 :]])
    return codes


def encoded(
    model: Model, f: Sequence, lobe: "mi.TensorXf | None", codes: np.ndarray
) -> "mi.TensorXf":
    """Codes of a bottom (M, C, L), differentiable in its values and its lobes.

    The limit of a bottom's albedo is ignored, so that an optimiser can leave white. A rest darker
    than a diffuse surface of `LEAST_REFLECTANCE` has the code of this surface: codes follow
    logarithms, whose derivatives have no bound there.

    f: of each channel (M * P) [1/sr] at the probe pairs of M points.
    lobe: (M or 1, C, K) if it is known; None: it is fitted to the values.
    codes: (M or 1, C, L) as they are without gradients.
    """
    wi, wo = (mi.Vector3f(np.ascontiguousarray(w.T)) for w in model.networks.pairs())
    pairs, channels, size = dr.width(wi), len(f), model.arch.lobe
    points = len(f[0]) // pairs
    lane, count = dr.arange(mi.UInt32, points * channels * pairs), points * channels
    row, pair = lane // pairs, lane % pairs
    place = (row // channels * pairs + pair) * channels + row % channels
    values = dr.gather(mi.Float, stacked(f, points * pairs).array, place)
    z = np.broadcast_to(codes, (points, *codes.shape[1:])).reshape(count, -1)
    plain = values.numpy().reshape(count, pairs)
    rest, seen, z = _rests(model, plain, z)
    numbers = _rows(z[:, :size].T)
    if lobe is not None:
        first = dr.arange(mi.UInt32, count) % (lobe.shape[0] * channels) * size
        numbers = [
            x + _change(dr.gather(mi.Float, lobe.array, first + i)) for i, x in enumerate(numbers)
        ]
    else:

        def by_values(f: np.ndarray, z: np.ndarray) -> np.ndarray:
            return np.swapaxes(fit_slopes(f, z[:, :size], model.widths), 1, 2)

        fitted = z[:, FITTED[model.widths]]
        found = dr.custom(_Linear, mi.TensorXf(values, plain.shape), fitted, by_values, (plain, z))
        for i, column in zip(FITTED[model.widths], _columns(found), strict=True):
            numbers[i] = numbers[i] + _change(column)
    kind = lobes.ANY_LOBE._replace(widths=model.widths)
    at = [dr.gather(mi.Float, x, row) for x in numbers]
    wi, wo = (dr.gather(mi.Vector3f, w, pair) for w in (wi, wo))
    top = lobes.f([at], wi, wo, kind)[0]
    plain_rest, visible = _rows(np.stack([rest.ravel(), seen.ravel()]))
    rests = mi.TensorXf(plain_rest + visible * _change(values - top), plain.shape)

    def by_rests(rest: np.ndarray, z: np.ndarray) -> np.ndarray:
        return code_fit.slopes(model.networks.basis, rest, z[:, size:])

    found = dr.custom(_Linear, rests, z[:, size:], by_rests, (rest, z))
    changes = [_change(x) for x in (*numbers, *_columns(found))]
    return _tensor(z.reshape(points, channels, -1), changes)


def _rests(model: Model, f: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, ...]:
    """Values f (N, P) without the lobes of codes z (N, L).

    Returns:
        The rest (N, P) [1/sr], whether f changes it (N, P), and the codes (N, L) of both: those of
        darker rests have changed, see `encoded`.
    """
    networks, size, rest = model.networks, model.arch.lobe, np.empty_like(f)
    fill_blocks(rest, lambda f, z: f - networks.top(z[:, None], *networks.pairs()), f, z)
    seen, least = rest >= 0, np.float32(LEAST_REFLECTANCE / np.pi)
    np.maximum(rest, 0, out=rest)
    dark = rest @ networks.basis.measure < least
    if dark.any():
        rest[dark], seen[dark], z = least, True, np.array(z)
        white = white_code(model)
        z[dark, size:] = networks.rest_scaled(white, np.float32(LEAST_REFLECTANCE))[size:]
    return rest, seen, z


def _inside(coat: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coats (K, N) moved to `MIN_ABSORPTION` and `MIN_DEPTH`, and shares (K, N) of derivatives.

    A share is what a derivative at the moved coat counts. It is zero for coats that have not moved
    and for the interface, and below one for albedo and g, which have no effect without a medium.
    """
    inside, share = coat.copy(), np.zeros_like(coat)
    inside[2], inside[3] = np.minimum(coat[2], 1 - MIN_ABSORPTION), np.maximum(coat[3], MIN_DEPTH)
    share[2:5] = (inside != coat).any(axis=0)
    share[[2, 4]] *= coat[3] / inside[3]
    return inside, share


def _layerer(model: Model, below: Sequence, values: np.ndarray, moves: Sequence) -> "mi.TensorXf":
    """The network's change (N, R) of the rests of codes `below`, at coats (K, N) that move."""
    kind, size = lobes.ANY_LOBE._replace(widths=model.widths), model.arch.lobe
    columns = [value + move for value, move in zip(_rows(values), moves, strict=True)]
    coat = coat_columns(*CoatParameters.of_columns(columns), DRJIT)
    inputs = *below[size:], *lobes.lobe_features(below[:size], kind)
    x = stacked([*inputs, *COATS[model.widths].each(coat)], values.shape[1])
    index, params = 0, model.params
    while (name := f"layerer.{index}") + ".weight" in params:
        if index:
            x = mi.TensorXf(activate(x.array, model.arch.activation), x.shape)
        values = linear(params, name, x.numpy())
        x, index = dr.custom(_Linear, x, values, params[f"{name}.weight"], ()), index + 1
    return x


def _columns(tensor: "mi.TensorXf") -> list:
    """The columns of a tensor (N, K)."""
    count, size = tensor.shape
    place = size * dr.arange(mi.UInt32, count)
    return [dr.gather(mi.Float, tensor.array, place + i) for i in range(size)]


def _tensor(values: np.ndarray, changes: Sequence) -> "mi.TensorXf":
    """Codes (M, C, L) of these values that change as the columns (M C) `changes`, which are 0."""
    own = owned(mi.Float, values.astype(np.float32))
    return mi.TensorXf(own + stacked(changes, len(own) // len(changes)).array, values.shape)


def _change(x: Any) -> Any:
    """0 with the derivatives of x."""
    return x - dr.detach(x)


def _rows(values: np.ndarray) -> list:
    """K Dr.Jit floats of values (K, N)."""
    source, count = owned(mi.Float, values.astype(np.float32)), values.shape[1]
    place = dr.arange(mi.UInt32, count)
    return [dr.gather(mi.Float, source, place + i * count) for i in range(len(values))]


class _Stack(dr.CustomOp):
    def eval(self, columns):
        size, place = len(columns), len(columns) * dr.arange(mi.UInt32, len(columns[0]))
        result = dr.zeros(mi.Float, size * len(place))
        for i, column in enumerate(columns):
            dr.scatter(result, column, place + i)
        return mi.TensorXf(result, (len(place), size))

    def forward(self):
        self.set_grad_out(self.eval(self.grad_in("columns")))

    def backward(self):
        self.set_grad_in("columns", _columns(self.grad_out()))

    def name(self):
        return "stack"


class _Linear(dr.CustomOp):
    """Given values (N, R) that change with rows (N, K) by a matrix (K, R), or by one for each row:
    a function of arrays (n, ...) gives matrices (n, K, R)."""

    def eval(self, rows, values, matrix, arrays):
        self._matrix, self._arrays = matrix, arrays
        self._inputs, self._outputs = rows.shape[1], values.shape[1]
        return mi.TensorXf(owned(mi.Float, values.astype(np.float32)), values.shape)

    def forward(self):
        self.set_grad_out(self._times(self.grad_in("rows"), self._outputs, lambda x: x))

    def backward(self):
        swapped = self._times(self.grad_out(), self._inputs, lambda x: np.swapaxes(x, -1, -2))
        self.set_grad_in("rows", swapped)

    def _times(self, change, size, turned):
        def block(x, *arrays):
            matrix = turned(self._matrix(*arrays) if arrays else self._matrix)
            return x @ matrix if matrix.ndim == 2 else (x[:, None] @ matrix)[:, 0]

        rows = change.numpy()
        result = np.empty((len(rows), size), np.float32)
        fill_blocks(result, block, rows, *self._arrays, rows=_MATRICES if self._arrays else None)
        return mi.TensorXf(owned(mi.Float, result), result.shape)

    def name(self):
        return "linear"
