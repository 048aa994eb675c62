"""The sampler and its proposal as shader code: the counterpart of `nets.sampler`."""

import itertools
import math
from collections.abc import Sequence

import numpy as np

from urushi.checks import Widths
from urushi.core.mixture import reflection_pdf, sample_reflection
from urushi.core.namespace import Components
from urushi.export.expressions import (
    FLOAT,
    VECTOR,
    Expression,
    call,
    dot,
    expression,
    name,
    select,
    vector,
)
from urushi.export.statements import Function, Structure, Variable, member, namespace
from urushi.nets.mlp import POLYNOMIALS
from urushi.nets.sampler import sampler_columns, sampler_inputs, weights_and_widths
from urushi.nets.weights import Model

WI, WO, U = (Variable(label, VECTOR) for label in ("wi", "wo", "u"))

#: Ends of the names of a lobe's widths, one or two.
LABELS = {1: ("",), 2: ("_u", "_v")}

SAMPLE = Structure(
    "Sample",
    (
        Variable("direction", VECTOR, note="wo, above the horizon"),
        Variable("density", FLOAT, note="its density [1/sr]"),
    ),
    "A direction drawn by `sample`.",
)


def argument(variable: Variable) -> Expression:
    """An argument inside its function."""
    return name(variable.name, variable.kind)


def dense(
    body: Function,
    label: str,
    weight: np.ndarray,
    inputs: Sequence[Expression],
    bias: Sequence[Expression] | Sequence[float],
) -> list[Expression]:
    """Outputs (out) of a layer of a network with a weight (in, out).

    label: begins the names of the outputs.
    """
    columns = weight.astype(np.float64).T
    return [
        body.let(f"{label}{k}", offset + dot([float(w) for w in column], inputs))
        for k, (column, offset) in enumerate(zip(columns, map(expression, bias), strict=True))
    ]


def activation(which: str) -> Function:
    """The function of an activation of `nets.mlp`."""
    function = Function("unit", (Variable("x", FLOAT),), FLOAT, f"The activation {which}.")
    x, (bound, coefficients) = name("x", FLOAT), POLYNOMIALS[which]
    t = function.let("t", call("clamp", x, -bound, bound))
    t2 = function.let("t2", t * t)
    *others, last = coefficients
    polynomial = expression(last)
    for coefficient in reversed(others):
        polynomial = polynomial * t2 + coefficient
    function.returns(x * (t * polynomial + 0.5))
    return function


def structure(model: Model) -> Structure:
    """The proposal for one wi: weights and widths of its lobes, first along the tangent."""
    count = _lobes(model)
    weights = [Variable(f"weight{k}", FLOAT) for k in range(count)]
    names = [f"alpha{label}" for label in LABELS[model.widths]]
    widths = [Variable(f"{name}{k}", FLOAT) for name in names for k in range(count)]
    return Structure(
        "Proposal",
        (*weights, Variable("cosine_weight", FLOAT), *widths),
        "A mixture of GGX reflection lobes and a cosine lobe.",
    )


def _lobes(model: Model) -> int:
    """The number of GGX lobes: the sampler's and the code's own."""
    return model.arch.lobes + 1


def fill(
    body: Function,
    model: Model,
    first: Sequence[Expression],
    own_alphas: Sequence[Expression],
    wi: Expression,
    activated: Function,
) -> Expression:
    """The proposal of a code for wi.

    first: the code's part of the sampler's first layer, its bias included. own_alphas: the
    widths of the code's lobe.
    """
    params = model.params
    columns = sampler_columns(wi, model.widths, namespace(body))
    inputs = [body.let(f"direction{k}", column) for k, column in enumerate(columns)]
    weight = params["sampler.0.weight"][-len(inputs) :]
    values = dense(body, "first", weight, inputs, first)
    layer = 1
    while f"sampler.{layer}.weight" in params:
        units = [body.let(f"unit{layer}_{k}", activated(value)) for k, value in enumerate(values)]
        bias = params[f"sampler.{layer}.bias"].tolist()
        values = dense(body, f"output{layer}_", params[f"sampler.{layer}.weight"], units, bias)
        layer += 1
    weights, sides = weights_and_widths(values, own_alphas, namespace(body))
    result, numbers = body.structure("result", "Proposal"), itertools.chain(weights, *sides)
    for variable, number in zip(structure(model).fields, numbers, strict=True):
        body.assign(member(result, variable), number)
    return result


def functions(model: Model) -> tuple[Function, ...]:
    """The functions reflection_density, density, sample_reflection and draw, in this order.

    density takes a proposal (`structure`), wi and wo; draw takes a proposal, wi and u.
    """
    fields, count = structure(model).fields, _lobes(model)
    mixture = Variable("mixture", "Proposal")
    parts = [member(argument(mixture), variable) for variable in fields]
    weights, cosine_weight = parts[:count], parts[count]
    # The widths of each lobe, one or two.
    alphas = [parts[count + 1 :][k::count] for k in range(count)]
    wi, wo, u = map(argument, (WI, WO, U))
    widths = [Variable(f"alpha{label}", FLOAT) for label in LABELS[model.widths]]
    own = tuple(map(argument, widths))
    width = own[0] if model.widths == 1 else Widths(*own)
    reflection = Function(
        "reflection_density",
        (*widths, WI, WO),
        FLOAT,
        "The density of wi reflected about a visible GGX normal and mirrored up (Heitz 2018).",
    )
    reflection.returns(reflection_pdf(width, wi, wo, namespace(reflection)))
    reflected = Function(
        "sample_reflection",
        (*widths, WI, U),
        VECTOR,
        "wi reflected about a visible GGX normal by u.y and u.z (Dupuy and Benyoub 2023).",
    )
    drawn = sample_reflection(width, Components(wi.x, wi.y, wi.z), u.y, u.z, namespace(reflected))
    reflected.returns(vector(*drawn))
    density = Function(
        "density", (mixture, WI, WO), FLOAT, "The density [1/sr] of the proposal at wo."
    )
    total = cosine_weight * (wo.z * (1.0 / math.pi))
    for weight, alpha in zip(weights, alphas, strict=True):
        total = total + weight * reflection(*alpha, wi, wo)
    density.returns(select(call("min", wi.z, wo.z) > 0.0, total, 0.0))
    draw = Function(
        "draw", (mixture, WI, U), VECTOR, "A direction of the proposal from uniform numbers."
    )
    draw.note_line("u.x chooses the lobe.")
    edge, alpha = weights[0], alphas[0]
    for k in range(1, count):
        alpha = [
            draw.let(f"width{label}{k}", select(u.x >= edge, own, other))
            for label, own, other in zip(LABELS[model.widths], alphas[k], alpha, strict=True)
        ]
        edge = draw.let(f"edge{k}", edge + weights[k])
    radius = draw.let("radius", call("sqrt", u.y))
    phi = draw.let("phi", (2.0 * math.pi) * u.z)
    height = draw.let("height", call("sqrt", call("max", 1.0 - u.y, 0.0)))
    cosine = vector(radius * call("cos", phi), radius * call("sin", phi), height)
    draw.returns(select(u.x >= edge, cosine, reflected(*alpha, wi, u)))
    return reflection, density, reflected, draw


def known_first(model: Model, code: np.ndarray) -> list[Expression]:
    """The code's part of the sampler's first layer, for a known code (size,)."""
    inputs = sampler_inputs(model.arch, code[None])
    weight = model.params["sampler.0.weight"][: inputs.shape[-1]]
    row = (inputs @ weight + model.params["sampler.0.bias"])[0]
    return [expression(float(value)) for value in row]
