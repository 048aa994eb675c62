"""The decoder as shader code: the counterpart of `nets.decoder`."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from urushi.export.dense import dense
from urushi.export.expressions import (
    Expression,
    call,
    colour,
    dot,
)
from urushi.export.statements import (
    Function,
    namespace,
)
from urushi.nets.architecture import SCALE
from urushi.nets.decoder import MAX_LOG, MIN_LOG
from urushi.nets.features import DIRECTIONS, direction_columns
from urushi.nets.weights import Model


class CodeTerms(NamedTuple):
    """The terms of the decoder that depend on the code only, floats or colours.

    Attributes:
        gain: added to the logarithm.
        scales, offsets: of the units of the first hidden layer.
    """

    gain: Expression
    scales: Sequence[Expression]
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
