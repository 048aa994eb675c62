"""T of a material's topmost interface as shader code, as in `nets.transmittance`."""

from collections.abc import Sequence

from urushi.checks import Widths
from urushi.core.namespace import Components
from urushi.export.expressions import (
    COLOUR,
    FLOAT,
    VECTOR,
    Expression,
    colour_of,
    expression,
    name,
)
from urushi.export.lobe import alphas_of
from urushi.export.statements import Function, Texels, Variable, namespace
from urushi.nets.transmittance import transmittance

#: Places of the Fresnel term's exact part, its factor and its index, among a lobe's numbers.
EXACT = slice(3, 6)

W = Variable("w", VECTOR)


class Passed:
    """The function of T, of the numbers of a material's lobe."""

    def __init__(self, lobe: Sequence[Expression]):
        """lobe: its numbers; those that are constants and the same in all channels are no
        arguments of the function."""
        own = _numbers(lobe)
        labels = ["alpha"] if len(own) == 4 else ["alpha_u", "alpha_v"]
        variables = [Variable(label, FLOAT) for label in (*labels, "factor", "eta", "k")]
        self._given = [number.constant is None or number.kind == COLOUR for number in own]
        arguments = [v for v, given in zip(variables, self._given, strict=True) if given]
        note = "The share of light that passes the topmost interface, for a direction."
        self.function = Function("transmittance", (*arguments, W), FLOAT, note)
        values = [
            name(v.name, FLOAT) if given else number
            for v, given, number in zip(variables, self._given, own, strict=True)
        ]
        *alphas, factor, eta, k = values
        w = name(W.name, VECTOR)
        if eta.constant is None:
            self.function.leaves(eta >= 1.0, 1.0)
        self.function.returns(
            transmittance(
                Widths(*alphas) if len(alphas) == 2 else alphas[0],
                (None if _is(factor, 1.0) else factor, eta, None if _is(k, 0.0) else k),
                Components(w.x, w.y, w.z),
                namespace(self.function),
            )
        )

    def __call__(self, lobe: Sequence[Expression], w: Expression) -> Expression:
        """T of a lobe for a direction; of a lobe of three channels it is a colour."""
        numbers = [x for x, given in zip(_numbers(lobe), self._given, strict=True) if given]
        if all(number.kind == FLOAT for number in numbers):
            return self.function(*numbers, w)
        channels = [[_channel(number, k) for number in numbers] for k in range(3)]
        return colour_of(*(self.function(*channel, w) for channel in channels))


def texels_have_edges(texels: Texels) -> bool:
    """Whether T of a texel's lobe, or of one between texels, can be other than one."""
    (_, factor), (eta, _), (k, _) = (
        _range(texels, place) for place in range(EXACT.start, EXACT.stop)
    )
    return factor > 0 and eta < 1 and k <= 0


def _range(texels: Texels, place: int) -> tuple[float, float]:
    """The least and the greatest value of a number of the codes of all texels."""
    ends = [
        (offset + sum(min(f, 0.0) for _, f in terms), offset + sum(max(f, 0.0) for _, f in terms))
        for offset, terms in texels.numbers[place]
    ]
    low, high = zip(*ends, strict=True)
    return min(low), max(high)


def _numbers(lobe: Sequence[Expression]) -> list[Expression]:
    """The numbers on which T depends: widths, factor and index."""
    return [expression(number) for number in (*alphas_of(lobe), *lobe[EXACT])]


def _channel(number: Expression, channel: int) -> Expression:
    if number.kind != COLOUR:
        return number
    if number.constant is not None:
        return expression(float(number.constant[channel]))
    return number.component(channel)


def _is(number: Expression, value: float) -> bool:
    return number.constant is not None and number.constant == value
