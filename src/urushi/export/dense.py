"""Layers of networks as shader code: unrolled products, or loops over constant tables."""

from collections.abc import Sequence

import numpy as np

from urushi.export.expressions import COLOUR, FLOAT, Expression, call, dot, expression, name
from urushi.export.statements import Function, Variable, element, integer, offset_index
from urushi.nets.mlp import POLYNOMIALS

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
