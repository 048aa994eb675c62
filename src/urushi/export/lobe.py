"""The analytic lobe as shader code: the counterpart of `nets.lobe`."""

import math
from collections.abc import Sequence

from urushi.export.expressions import Expression, Value, call, expression, is_zero
from urushi.export.statements import Function
from urushi.nets.lobe import COSINES, FEATURE_MEANS, FEATURE_SCALES, LOBE_NUMBERS, VISIBLE


def f(body: Function, lobe: Sequence[Value], wi: Expression, wo: Expression) -> Expression:
    """f [1/sr] of lobes, whose numbers are floats or colours; zero if none reflects."""
    numbers = [expression(number) for number in lobe]
    if all(is_zero(factor) for factor in numbers[1:4]):
        return expression(0.0)
    body.note_line("The lobe: D G / (4 cos_i cos_o) of GGX with the separable Smith term, where")
    body.note_line("wi + wo stands for the half vector.")
    cos_i = body.let("above_i", call("max", wi.z, 0.0))
    cos_o = body.let("above_o", call("max", wo.z, 0.0))
    x, y = body.let("half_x", wi.x + wo.x), body.let("half_y", wi.y + wo.y)
    z = body.let("half_z", cos_i + cos_o)
    across, z2 = body.let("half_xy2", x * x + y * y), body.let("half_z2", z * z)
    if len(numbers) == len(LOBE_NUMBERS):
        alpha2 = body.let("alpha2", numbers[0] * numbers[0])
        squeezed = across
        rest = body.let("remaining", 1.0 - alpha2)
        roots = [alpha2 + rest * (cos * cos) for cos in (cos_i, cos_o)]
    else:
        alpha2, along, aside = products(body, numbers[0], numbers[-1])
        squeezed = x * x * aside + y * y * along
        roots = [
            alpha2 * (w.x * w.x * along + w.y * w.y * aside) + cos * cos
            for w, cos in ((wi, cos_i), (wo, cos_o))
        ]
    ratio = body.let("ratio", (across + z2) / (squeezed + alpha2 * z2 + 1e-18))
    # Two names: a product of sums is the same with wi and wo exchanged, whatever is contracted.
    masking_i = body.let("masking_i", cos_i + call("sqrt", roots[0]))
    masking_o = body.let("masking_o", cos_o + call("sqrt", roots[1]))
    shape = body.let(
        "lobe_shape", (alpha2 * (1.0 / math.pi)) * (ratio * ratio) / (masking_i * masking_o)
    )
    cosine = body.let("cos_facet", call("min", 0.5 * call("sqrt", across + z2), 1.0))
    body.note_line("Its Fresnel term at the cosine to the facet.")
    return body.let("lobe", shape * reflectance(body, numbers, cosine, "facet"))


def products(
    body: Function, along: Expression, across: Expression
) -> tuple[Expression, Expression, Expression]:
    """The product of two GGX widths, and the quotients along / across and across / along."""
    return (
        body.let("alpha2", along * across),
        body.let("u_over_v", along / across),
        body.let("v_over_u", across / along),
    )


def reflectance(
    body: Function, lobe: Sequence[Expression], cosine: Value, suffix: str
) -> Expression:
    """The Fresnel term of lobes at a cosine, see `nets.lobe.reflectance`.

    suffix: of the names of its variables.
    """
    normal, grazing, exact, eta, k = lobe[1 : len(LOBE_NUMBERS)]
    value = expression(0.0)
    if not (is_zero(normal) and is_zero(grazing)):
        away = body.let(f"away_{suffix}", call("clamp", 1.0 - expression(cosine), 0.0, 1.0))
        away2 = body.let(f"away2_{suffix}", away * away)
        fifth = body.let(f"fifth_{suffix}", away2 * away2 * away)
        value = normal * (1.0 - fifth) + grazing * fifth
    if not is_zero(exact):
        value = value + exact * _fresnel(body, expression(cosine), eta, k, suffix)
    return body.let(f"fresnel_{suffix}", value)


def _fresnel(
    body: Function, cosine: Expression, eta: Expression, k: Expression, suffix: str
) -> Expression:
    """The reflectance of a smooth surface of index eta - i k, see `nets.lobe.fresnel`."""

    def let(label: str, value: Value) -> Expression:
        return body.let(f"{label}_{suffix}", value)

    cos2 = let("cos2", cosine * cosine)
    sin2 = let("sin2", 1.0 - cos2)
    difference = let("difference", ((eta - 1.0) * (eta + 1.0) - k * k) + cos2)
    if is_zero(k):
        size = let("size", call("abs", difference))
    else:
        size = let("size", call("sqrt", difference * difference + 4.0 * (eta * eta) * (k * k)))
    a = let("root", call("sqrt", 0.5 * call("max", size + difference, 0.0)))
    first, second = let("first", size + cos2), let("second", 2.0 * a * cosine)
    perpendicular = let("across", (first - second) / (first + second))
    third = let("third", cos2 * size + sin2 * sin2)
    fourth = let("fourth", second * sin2)
    ratio = let("parallel", (third - fourth + 1e-12) / (third + fourth + 1e-12))
    return 0.5 * perpendicular * (1.0 + ratio)


def features(body: Function, lobe: Sequence[Expression]) -> list[Expression]:
    """The features of a lobe of floats, see `nets.lobe.lobe_features`."""
    alpha = lobe[0]
    at = [reflectance(body, lobe, cosine, f"at{i}") for i, cosine in enumerate(COSINES)]
    mean = body.let("mean_fresnel", (at[0] + at[1] + at[2]) * (1.0 / 3.0))
    seen = body.let("seen", mean / (mean + VISIBLE))
    columns = [seen * call("log", alpha), seen * alpha, *at, call("log", mean + VISIBLE)]
    means: tuple[float, ...] = FEATURE_MEANS
    scales: tuple[float, ...] = FEATURE_SCALES
    if len(lobe) > len(LOBE_NUMBERS):
        columns += [seen * call("log", lobe[-1]), seen * lobe[-1]]
        means, scales = means + means[:2], scales + scales[:2]
    return [
        body.let(f"lobe_feature{i}", (column - offset) * (1.0 / scale))
        for i, (column, offset, scale) in enumerate(zip(columns, means, scales, strict=True))
    ]
