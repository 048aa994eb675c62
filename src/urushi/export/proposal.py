"""The proposal as shader code: the counterpart of `nets.proposal`."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from urushi.checks import Widths
from urushi.core.mixture import reflection_pdf, sample_reflection
from urushi.core.namespace import Components
from urushi.export.expressions import (
    FLOAT,
    VECTOR,
    Expression,
    Value,
    call,
    dot,
    expression,
    select,
    vector,
)
from urushi.export.lobe import alphas_of, reflectance, width_of
from urushi.export.statements import Function, Structure, Variable, member, namespace
from urushi.nets.proposal import ALPHAS, LARGEST_STRETCH, stretched_widths, weights
from urushi.nets.weights import Model

WI, WO, U = (Variable(label, VECTOR) for label in ("wi", "wo", "u"))

#: Names of the widths of a GGX lobe, one or two.
WIDTHS = {1: ("alpha",), 2: ("alpha_u", "alpha_v")}

SAMPLE = Structure(
    "Sample",
    (
        Variable("direction", VECTOR, note="wo, above the horizon"),
        Variable("density", FLOAT, note="its density [1/sr]"),
    ),
    "A direction drawn by `sample`.",
)

#: The weights of a proposal: of the code's own lobe, of `ALPHAS` and of the cosine lobe.
WEIGHTS = tuple(Variable(f"weight{k}", FLOAT) for k in range(len(ALPHAS) + 2))


class Terms(NamedTuple):
    """What the proposal needs of a code, the mean of the channels."""

    lobe: Sequence[Expression]  # its numbers
    rest: Sequence[Expression]  # of `nets.proposal.code_terms`
    overlaps: Sequence[float]  # the same for all codes
    stretch: Expression | None = None  # s of two widths


def structure(widths: int) -> Structure:
    """The proposal for one wi; widths: of a lobe, one or two."""
    own = [Variable(label, FLOAT, note="of the first lobe") for label in WIDTHS[widths]]
    own += [Variable("stretch", FLOAT, note="of the other lobes")] * (widths - 1)
    note = "A mixture of GGX reflection lobes, and a cosine lobe, the last."
    return Structure("Proposal", (*WEIGHTS, *own), note)


def terms_of(model: Model, code: Sequence[Expression]) -> Terms:
    """The terms of a code (L,) of floats."""
    size, limit = model.arch.lobe, LARGEST_STRETCH
    matrix, bias = (model.params[f"proposal.{part}"].T.tolist() for part in ("weight", "bias"))
    sums = [offset + dot(row, code[size:]) for row, offset in zip(matrix, bias, strict=True)]
    two = model.widths == 2
    stretch = call("exp", call("clamp", code[-1], -limit, limit)) if two else None
    return Terms(code[:size], list(map(expression, sums)), overlaps_of(model), stretch)


def overlaps_of(model: Model) -> Sequence[float]:
    """The overlaps of neighbouring lobes."""
    return model.params["proposal.overlap"].tolist()


def fill(body: Function, terms: Terms, wi: Expression, passed: Value = 1.0) -> Expression:
    """The proposal of a code for wi; passed: T(wi) of the code."""
    alphas = alphas_of(terms.lobe)
    found = weights(
        terms.rest,
        terms.overlaps,
        width_of(terms.lobe),
        lambda cosine: reflectance(body, terms.lobe, cosine, "_own"),
        wi.z,
        namespace(body),
        passed,
    )
    made = structure(len(alphas))
    result = body.declare("result", made.name)
    stretch = [] if terms.stretch is None else [terms.stretch]
    for variable, number in zip(made.fields, [*found, *alphas, *stretch], strict=True):
        body.assign(member(result, variable), number)
    return result


def functions(count: int) -> tuple[Function, ...]:
    """The functions reflection_density, density, sample_reflection and draw, in this order.

    count: widths of a lobe, one or two. density takes a proposal, wi and wo; draw takes a proposal,
    wi and u.
    """
    mixture = Variable("mixture", "Proposal")
    parts = [member(mixture.value, part) for part in structure(count).fields]
    shares, cosine_weight, *own = parts[: len(ALPHAS) + 1], *parts[len(ALPHAS) + 1 :]
    alphas = [own[:count], *([expression(alpha)] for alpha in ALPHAS)]
    if count == 2:
        alphas[1:] = ([alpha.u, alpha.v] for alpha in stretched_widths(own[-1]))
    wi, wo, u = (variable.value for variable in (WI, WO, U))
    labels = WIDTHS[count]
    widths = [Variable(label, FLOAT) for label in labels]
    width = Widths(*(x.value for x in widths)) if count == 2 else widths[0].value
    note = "The density of wi reflected about a visible GGX normal and mirrored up (Heitz 2018)."
    reflection = Function("reflection_density", (*widths, WI, WO), FLOAT, note)
    reflection.returns(reflection_pdf(width, wi, wo, namespace(reflection)))
    note = "wi reflected about a visible GGX normal by u.y and u.z (Dupuy and Benyoub 2023)."
    reflected = Function("sample_reflection", (*widths, WI, U), VECTOR, note)
    drawn = sample_reflection(width, Components(wi.x, wi.y, wi.z), u.y, u.z, namespace(reflected))
    reflected.returns(vector(*drawn))
    note = "The density [1/sr] of the proposal at wo."
    density = Function("density", (mixture, WI, WO), FLOAT, note)
    total = cosine_weight * (wo.z * (1.0 / math.pi))
    for share, alpha in zip(shares, alphas, strict=True):
        total = total + share * reflection(*alpha, wi, wo)
    density.returns(select(call("min", wi.z, wo.z) > 0.0, total, 0.0))
    note = "A direction of the proposal from uniform numbers."
    draw = Function("draw", (mixture, WI, U), VECTOR, note)
    draw.note_line("u.x chooses the lobe.")
    edge, chosen = shares[0], alphas[0]
    for k, (share, alpha) in enumerate(zip(shares[1:], alphas[1:], strict=True)):
        chosen = [
            draw.let(f"{label}{k}", select(u.x >= edge, further, other))
            for label, further, other in zip(labels, alpha, chosen, strict=True)
        ]
        edge = draw.let(f"edge{k}", edge + share)
    radius = draw.let("radius", call("sqrt", u.y))
    phi = draw.let("phi", (2.0 * math.pi) * u.z)
    height = draw.let("height", call("sqrt", call("max", 1.0 - u.y, 0.0)))
    cosine = vector(radius * call("cos", phi), radius * call("sin", phi), height)
    draw.returns(select(u.x >= edge, cosine, reflected(*chosen, wi, u)))
    return reflection, density, reflected, draw
