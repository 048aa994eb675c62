"""The networks as shader code: layers, the lobe and the decoder, as in `nets.lobe` and `.decoder`.

The networks take directions in a frame whose x axis is the tangent. `Tangent` is the tangent of a
rotated material in the frame of the caller's directions.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from urushi.checks import Widths
from urushi.core import microfacet
from urushi.core.namespace import Components
from urushi.core.table import MAX_LOG, MIN_LOG
from urushi.export.expressions import (
    COLOUR,
    FLOAT,
    Expression,
    Value,
    call,
    colour,
    dot,
    expression,
    is_zero,
    name,
    vector,
)
from urushi.export.statements import Function, Variable, element, integer, namespace, offset_index
from urushi.nets.architecture import SCALE
from urushi.nets.features import DIRECTIONS, direction_columns
from urushi.nets.lobe import COSINES, FEATURES, WIDTH_PLACES, feature_columns, reflectance_of
from urushi.nets.mlp import POLYNOMIALS
from urushi.nets.weights import Model

#: Fields of an anisotropic material: components of its tangent, of length one.
FIELDS = (
    Variable("tangent_x", FLOAT, note="the tangent in the frame of wi and wo, a unit vector:"),
    Variable("tangent_y", FLOAT, note="the cosine and the sine of the material's rotation"),
)


class Tangent(NamedTuple):
    """The tangent (x, y, 0) of a material, of length one."""

    x: Expression
    y: Expression

    @classmethod
    def of(cls, rotation: float) -> "Tangent":
        """The tangent of a material with a known rotation [degrees]."""
        angle = np.radians(rotation)
        return cls(expression(float(np.cos(angle))), expression(float(np.sin(angle))))

    @property
    def _is_x_axis(self) -> bool:
        return self.x.constant is not None and self.x.constant == 1.0

    def inside(self, body: Function, w: Expression, label: str) -> Expression:
        """A direction of the caller's frame in the frame of the tangent."""
        if self._is_x_axis:
            return w
        turned = vector(w.x * self.x + w.y * self.y, w.y * self.x - w.x * self.y, w.z)
        return body.let(label, turned)

    def outside(self, body: Function, w: Expression, label: str) -> Expression:
        """A direction of the tangent's frame in the caller's frame."""
        if self._is_x_axis:
            return w
        turned = vector(w.x * self.x - w.y * self.y, w.x * self.y + w.y * self.x, w.z)
        return body.let(label, turned)


#: The tangent of a material that is not turned.
X_AXIS = Tangent.of(0.0)


#: Layers with more weights than this are loops over a table. Compilers are quicker with literals: a
#: software rasteriser takes a second for 4,000 of them, and half a minute for as many in tables.
UNROLLED = 2048


def dense(
    body: Function,
    label: str,
    weight: np.ndarray,
    inputs: Sequence[Expression],
    bias: Sequence[Expression] | Sequence[float] | None = None,
) -> list[Expression]:
    """Outputs (out) of a weight (in, out) and inputs (in) that are floats or colours.

    label: begins the names of the outputs. bias: constants, if the layer is too large to unroll.
    """
    columns = weight.astype(np.float64).T
    offsets = [expression(0.0)] * len(columns) if bias is None else list(map(expression, bias))
    if weight.size <= UNROLLED:
        return [
            body.let(f"{label}{k}", offset + dot([float(w) for w in column], inputs))
            for k, (column, offset) in enumerate(zip(columns, offsets, strict=True))
        ]
    label = label.rstrip("_")
    table = body.table(f"{label}_weights", columns)
    known = [offset.constant for offset in offsets if offset.constant is not None]
    biases = body.table(f"{label}_biases", np.array(known))
    kind = COLOUR if any(value.kind == COLOUR for value in inputs) else FLOAT
    outputs = body.array(label, kind, len(columns))
    with body.loop(f"{label}_unit", len(columns)) as unit:
        start = unit * integer(len(inputs))
        total = element(biases, unit)
        for i, value in enumerate(inputs):
            total = total + value * element(table, offset_index(i, start))
        body.assign(element(outputs, unit), total)
    return [element(outputs, k) for k in range(len(columns))]


def activation(kind: str, which: str, label: str) -> Function:
    """The function `label` of an activation of `nets.mlp`, for floats or colours."""
    function = Function(label, (Variable("x", kind),), kind, f"The activation {which}.")
    x = name("x", kind)
    if which in POLYNOMIALS:
        bound, coefficients = POLYNOMIALS[which]
        t = function.let("t", call("clamp", x, -bound, bound))
        t2 = function.let("t2", t * t)
        *others, last = coefficients
        polynomial = expression(last)
        for coefficient in reversed(others):
            polynomial = polynomial * t2 + coefficient
        function.returns(x * (t * polynomial + 0.5))
    else:  # "relu"
        function.returns(call("max", x, 0.0))
    return function


def lobe_f(body: Function, lobe: Sequence[Value], wi: Expression, wo: Expression) -> Expression:
    """f [1/sr] of lobes, whose numbers are floats or colours; zero if none reflects."""
    numbers = [expression(number) for number in lobe]
    if all(is_zero(factor) for factor in numbers[1:4]):
        return expression(0.0)
    body.note_line("The lobe: D G / (4 cos_i cos_o) of GGX with the separable Smith term, where")
    body.note_line("wi + wo stands for the half vector.")
    xp, alphas = namespace(body), _alphas(numbers)
    above_i, above_o = (
        Components(w.x, w.y, body.let(f"above_{label}", call("max", w.z, 0.0)))
        for label, w in (("i", wi), ("o", wo))
    )
    h = microfacet.half_vector(above_i, above_o, xp)
    alpha = alphas[0] if len(alphas) == 1 else Widths(*alphas)
    shape = microfacet.lobe_shape(alpha, above_i, above_o, h, xp)
    cosine = microfacet.facet_cosine(h, xp)
    body.note_line("Its Fresnel term at the cosine to the facet.")
    return body.let("lobe", shape * _reflectance(body, numbers, cosine, "_facet"))


def lobe_features(body: Function, lobe: Sequence[Expression]) -> list[Expression]:
    """The features of a lobe of floats, see `nets.lobe.lobe_features`."""
    at = [_reflectance(body, lobe, cosine, f"_at{i}") for i, cosine in enumerate(COSINES)]
    alphas = _alphas(lobe)
    columns = FEATURES[len(alphas)].each(feature_columns(alphas, at, namespace(body)))
    return [body.let(f"lobe_feature{i}", column) for i, column in enumerate(columns)]


def _alphas(lobe: Sequence[Expression]) -> list[Expression]:
    """The width of a lobe, or its two."""
    places = next(places for places in WIDTH_PLACES.values() if len(lobe) == 5 + len(places))
    return [lobe[place] for place in places]


def _reflectance(
    body: Function, lobe: Sequence[Expression], cosine: Value, suffix: str
) -> Expression:
    """The Fresnel term of lobes at a cosine, see `nets.lobe.reflectance_of`.

    suffix: of the names of its variables.
    """
    normal, grazing, exact, eta, k = lobe[1:6]
    schlick = not (is_zero(normal) and is_zero(grazing))
    numbers = (
        normal if schlick else None,
        grazing,
        exact,
        None if is_zero(exact) else eta,
        None if is_zero(k) else k,
    )
    return expression(reflectance_of(numbers, expression(cosine), namespace(body, suffix)))


class FTable(NamedTuple):
    """A table of ln f that shaders read from a texture; see `material.table`."""

    shape: Sequence[int]  # its nodes in three coordinates
    # From wi + wo, wi - wo, the number of widths and a namespace to coordinates.
    coordinates: Callable[..., Sequence[Expression]]
    beside_lobe: bool  # whether it holds the rest alone


def tabulated(
    body: Function, table: FTable, texture: Expression, wi: Expression, wo: Expression
) -> Expression:
    """f [1/sr] of a table; its texture has the coordinates in the opposite order."""
    body.note_line("The table's coordinates, from the first node to the last.")
    both = body.let("both", wi + wo)
    apart = body.let("apart", wi - wo)
    places = table.coordinates(both, apart, 1, namespace(body))
    at = (
        (place * (count - 1.0) + 0.5) * (1.0 / count)
        for place, count in zip(places, table.shape, strict=True)
    )
    place = body.let("place", vector(*reversed(tuple(at))))
    return call("exp", Expression("texel", COLOUR, (texture, place)))


class CodeTerms(NamedTuple):
    """The terms of the decoder that depend on the code only, floats or colours."""

    gain: Expression  # added to the logarithm
    scales: Sequence[Expression]  # of the units of the first hidden layer
    offsets: Sequence[Expression]


def of_code(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """The linear map from a code without lobe and gain to scales and offsets of the first layer.

    Returns the weight (numbers, 2 x width) and the bias (2 x width,).
    """
    params, numbers = model.params, model.arch.latent - model.arch.lobe - 1
    weight = np.concatenate([params[SCALE], params["decoder.0.weight"][:numbers]], axis=1)
    ones = np.ones(model.arch.decoder[0], np.float32)
    return weight, np.concatenate([ones, params["decoder.0.bias"]])


def split_terms(model: Model, gain: Expression, terms: Sequence[Expression]) -> CodeTerms:
    """The outputs of `of_code`, by their meaning."""
    width = model.arch.decoder[0]
    return CodeTerms(gain, terms[:width], terms[width:])


def known_terms(model: Model, codes: np.ndarray) -> CodeTerms:
    """The terms of known codes (C, size), C being 1 or 3, as constants."""
    lobe = model.arch.lobe
    weight, bias = of_code(model)
    # In single precision, as Material.f computes them.
    rows = codes[:, lobe + 1 :] @ weight + bias
    return split_terms(model, colour(codes[:, lobe]), [colour(column) for column in rows.T])


def features(body: Function, wi: Expression, wo: Expression, widths: int = 1) -> list[Expression]:
    """The features of two directions, see `nets.features.direction_features`."""
    body.note_line("Features of the two directions, the same with wi and wo exchanged.")
    columns = DIRECTIONS[widths].each(direction_columns(wi, wo, widths, namespace(body)))
    return [body.let(f"feature{i}", column) for i, column in enumerate(columns)]


def rest(
    body: Function,
    model: Model,
    terms: CodeTerms,
    inputs: Sequence[Expression],
    activated: Function,
) -> Expression:
    """The decoded rest [1/sr] for the terms of a code and `features`."""
    params, numbers = model.params, model.arch.latent - model.arch.lobe - 1
    output = len(model.arch.decoder)
    body.note_line("The first hidden layer, scaled and shifted by the code.")
    responses = dense(body, "response", params["decoder.0.weight"][numbers:], inputs)
    changes = zip(terms.scales, terms.offsets, responses, strict=True)
    values = [
        body.let(f"unit0_{k}", activated(offset + scale * response))
        for k, (scale, offset, response) in enumerate(changes)
    ]
    for layer in range(1, output):
        body.note_line(f"Hidden layer {layer + 1}.")
        bias = params[f"decoder.{layer}.bias"].tolist()
        sums = dense(body, f"sum{layer}_", params[f"decoder.{layer}.weight"], values, bias)
        values = [body.let(f"unit{layer}_{k}", activated(value)) for k, value in enumerate(sums)]
    total = dot(params[f"decoder.{output}.weight"][:, 0].tolist(), values)
    logarithm = total + (terms.gain + float(params[f"decoder.{output}.bias"][0]))
    return body.let("rest", call("exp", call("clamp", logarithm, MIN_LOG, MAX_LOG)))
