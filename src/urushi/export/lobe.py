"""The lobe of a material as shader code, as in `nets.lobe`, with T of its topmost interface.

T is that of `nets.transmittance`. Formulas take directions in a frame whose x axis is the tangent
of the material, which may be turned.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import Widths
from urushi.core import microfacet
from urushi.core.namespace import Components
from urushi.export.expressions import (
    COLOUR,
    FLOAT,
    Expression,
    Value,
    call,
    colour_of,
    equals,
    expression,
    vector,
)
from urushi.export.statements import Function, LinearNumber, Texels, Variable, namespace
from urushi.nets.lobe import WIDTH_PLACES, reflectance_of
from urushi.nets.transmittance import of_spread, spread2

#: Places of the Fresnel term's exact part, its factor and its index, among a lobe's numbers.
EXACT = slice(3, 6)

#: Arguments of the function of T: the squared spread, the numbers `EXACT`, the direction's cosine.
ARGUMENTS = tuple(Variable(label, FLOAT) for label in ("spread", "factor", "eta", "k", "cosine"))

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

    def inside(self, body: Function, w: Expression, label: str) -> Expression:
        """A direction of the caller's frame in the frame of the tangent."""
        if equals(self.x, 1.0):
            return w
        turned = vector(w.x * self.x + w.y * self.y, w.y * self.x - w.x * self.y, w.z)
        return body.let(label, turned)

    def outside(self, body: Function, w: Expression, label: str) -> Expression:
        """A direction of the tangent's frame in the caller's frame."""
        if equals(self.x, 1.0):
            return w
        turned = vector(w.x * self.x - w.y * self.y, w.x * self.y + w.y * self.x, w.z)
        return body.let(label, turned)


#: The tangent of a material that is not turned.
X_AXIS = Tangent.of(0.0)


def lobe_f(body: Function, lobe: Sequence[Value], wi: Expression, wo: Expression) -> Expression:
    """f [1/sr] of lobes, whose numbers are floats or colours; zero if none reflects."""
    numbers = [expression(number) for number in lobe]
    if all(equals(factor, 0.0) for factor in numbers[1:4]):
        return expression(0.0)
    body.note_line("The lobe: D G / (4 cos_i cos_o) of GGX with the separable Smith term, where")
    body.note_line("wi + wo stands for the half vector.")
    xp = namespace(body)
    above_i, above_o = (
        Components(w.x, w.y, body.let(f"above_{label}", call("max", w.z, 0.0)))
        for label, w in (("i", wi), ("o", wo))
    )
    h = microfacet.half_vector(above_i, above_o, xp)
    shape = microfacet.lobe_shape(width_of(numbers), above_i, above_o, h, xp)
    cosine = microfacet.facet_cosine(h, xp)
    body.note_line("Its Fresnel term at the cosine to the facet.")
    return body.let("lobe", shape * reflectance(body, numbers, cosine, "_facet"))


def alphas_of(lobe: Sequence[Expression]) -> list[Expression]:
    """The width of a lobe, or its two."""
    return [lobe[place] for place in WIDTH_PLACES[len(lobe) - 5]]


def width_of(lobe: Sequence[Expression]) -> Any:
    """The width of a lobe, or its two `Widths`."""
    alphas = alphas_of(lobe)
    return alphas[0] if len(alphas) == 1 else Widths(*alphas)


def reflectance(
    body: Function, lobe: Sequence[Expression], cosine: Value, suffix: str
) -> Expression:
    """The Fresnel term of lobes at a cosine, see `nets.lobe.reflectance_of`.

    suffix: of the names of its variables.
    """
    normal, grazing, exact, eta, k = lobe[1:6]
    numbers = (
        None if equals(normal, 0.0) and equals(grazing, 0.0) else normal,
        grazing,
        exact,
        None if equals(exact, 0.0) else eta,
        None if equals(k, 0.0) else k,
    )
    return expression(reflectance_of(numbers, expression(cosine), namespace(body, suffix)))


def transmittance() -> Function:
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
    """T of a lobe for a direction; a colour for a lobe of three channels."""
    spread = spread2(width_of(lobe), w, namespace(body, f"_{label}"))
    numbers = [expression(x) for x in (spread, *lobe[EXACT])]
    channels = range(3 if any(x.kind == COLOUR for x in numbers) else 1)
    values = [transmittance()(*(_channel(x, k) for x in numbers), w.z) for k in channels]
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
