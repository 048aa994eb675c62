"""T of a material's topmost interface as shader code, as in `nets.transmittance`."""

from collections.abc import Sequence

from urushi.export.expressions import COLOUR, FLOAT, Expression, colour_of, expression
from urushi.export.lobe import width_of
from urushi.export.statements import Function, LinearNumber, Texels, Variable, namespace
from urushi.nets.transmittance import of_spread, spread2

#: Places of the Fresnel term's exact part, its factor and its index, among a lobe's numbers.
EXACT = slice(3, 6)

#: Arguments of the function of T: the squared spread, the numbers `EXACT`, the direction's cosine.
ARGUMENTS = tuple(Variable(label, FLOAT) for label in ("spread", "factor", "eta", "k", "cosine"))


def function() -> Function:
    """The function of T, `transmittance`, of one channel."""
    note = "The share of light that passes the topmost interface, for a direction."
    made = Function("transmittance", ARGUMENTS, FLOAT, note)
    spread, factor, eta, k, cosine = (variable.value for variable in ARGUMENTS)
    made.leaves(eta >= 1.0, 1.0)
    made.returns(of_spread(spread, (factor, eta, k), cosine, namespace(made)))
    return made


def passed(
    body: Function, lobe: Sequence[Expression], w: Expression, label: str = "passed"
) -> Expression:
    """T of a lobe for a direction, by `function`; of a lobe of three channels it is a colour."""
    spread = spread2(width_of(lobe), w, namespace(body, f"_{label}"))
    numbers = [expression(x) for x in (spread, *lobe[EXACT])]
    channels = range(3 if any(x.kind == COLOUR for x in numbers) else 1)
    values = [function()(*(_channel(x, k) for x in numbers), w.z) for k in channels]
    return body.let(label, colour_of(*values) if len(values) > 1 else values[0])


def texels_have_edges(texels: Texels) -> bool:
    """Whether T of a texel's lobe, or of one between texels, can be other than one."""
    (_, factor), (eta, _), (k, _) = (_range(numbers) for numbers in texels.numbers[EXACT])
    return factor > 0 and eta < 1 and k <= 0


def _range(channels: Sequence[LinearNumber]) -> tuple[float, float]:
    """The least and the greatest value of a number of the codes of all texels."""
    low, high = (
        [offset + sum(end(f, 0.0) for _, f in terms) for offset, terms in channels]
        for end in (min, max)
    )
    return min(low), max(high)


def _channel(number: Expression, channel: int) -> Expression:
    if number.kind != COLOUR:
        return number
    if number.constant is not None:
        return expression(float(number.constant[channel]))
    return number.component(channel)
