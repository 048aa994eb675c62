"""The sampler: maps a latent code and a cosine to the proposal, from which directions are drawn.

The proposal is a mixture of GGX reflection lobes and a cosine lobe, exactly normalised. A lobe
reflects wi about a visible GGX normal. Reflected directions below the horizon are mirrored up
(z to |z|). The density of a direction is therefore the sum of the reflection densities at the
direction and at its mirror image, and integrates to one over the upper hemisphere. Directions are
(..., 3), z is the normal, wi is above the horizon.
"""

import functools
import math
import operator
from collections.abc import Sequence
from typing import Any

from urushi.checks import MIN_ALPHA, Widths
from urushi.core.namespace import (
    Namespace,
    arrays,
    components,
)
from urushi.core.table import MIN_COSINE
from urushi.nets.features import stacked
from urushi.nets.lobe import WIDTH_PLACES, lobe_features
from urushi.nets.mlp import Params, hidden_to_output, split_linear

#: Least weight of the cosine lobe. It bounds f cos / pdf where the network is wrong.
MIN_COSINE_SHARE = 0.02


def sampler_features(wi: Any, widths: int = 1) -> Any:
    """Return features (..., A) of directions (..., 3), normalised.

    These are the cosine and its logarithm. For widths = 2 there are the squares of x and y, too.
    """
    columns = sampler_columns(components(wi), widths, arrays(wi))
    return wi.__array_namespace__().stack(columns, axis=-1)


def sampler_columns(wi: Any, widths: int, xp: Namespace) -> list[Any]:
    """`sampler_features` of a direction as a list."""
    raised = xp.named("raised", xp.maximum(wi.z, MIN_COSINE))
    columns = [(raised - 0.5) * 3.0, xp.log(raised) + 1.0]
    if widths == 2:
        columns += [(wi.x * wi.x - 0.33) * 3.0, (wi.y * wi.y - 0.33) * 3.0]
    return columns


def sampler_inputs(arch: Any, z: Any) -> Any:
    """Return the sampler's inputs for codes z (..., L): the features of their lobe, the rest."""
    xp = z.__array_namespace__()
    return xp.concat([lobe_features(z[..., : arch.lobe]), z[..., arch.lobe :]], axis=-1)


def mixture(params: Params, arch: Any, z: Any, wi: Any) -> tuple[Any, Any]:
    """Return the proposal's weights (..., K+1), the last the cosine lobe's, and widths (..., K).

    z (..., L) and wi (..., 3) broadcast against each other. Weights are positive and add up to 1;
    widths are GGX alphas in [0.01, 1]; the first is the width of the code's lobe. They are `Widths`
    of two arrays if the networks are anisotropic.
    """
    angle = sampler_features(wi, arch.widths)
    first = split_linear(params, "sampler.0", sampler_inputs(arch, z), angle)
    output = hidden_to_output(params, "sampler", first, arch.activation)
    columns = [output[..., i] for i in range(output.shape[-1])]
    own = [z[..., place] for place in WIDTH_PLACES[arch.widths]]
    weights, sides = weights_and_widths(columns, own, arrays(output))
    along, *across = map(stacked, sides)
    return stacked(weights), Widths(along, *across) if across else along


def weights_and_widths(
    output: Sequence[Any], own: Sequence[Any], xp: Namespace
) -> tuple[list[Any], list[list[Any]]]:
    """The K + 1 weights of a proposal, the last the cosine lobe's, and its K widths.

    output: the network's numbers. own: the widths of the code's lobe, one or two; the proposal has
        a list of widths for each.
    """
    lobes = (len(output) - 2) // (1 + len(own))
    logits, others = output[: lobes + 2], output[lobes + 2 :]
    largest = xp.named("largest", functools.reduce(xp.maximum, logits))
    shares = [xp.named(f"share{k}", xp.exp(x - largest)) for k, x in enumerate(logits)]
    total = functools.reduce(operator.add, shares)
    scale = xp.named("unit_sum", (1.0 - MIN_COSINE_SHARE) / total)
    weights = [share * scale for share in shares]
    weights[-1] = weights[-1] + MIN_COSINE_SHARE
    # Logistic interpolation between ln 1 and ln MIN_ALPHA.
    widths = [xp.exp(math.log(MIN_ALPHA) * xp.falling_logistic(x)) for x in others]
    sides = [[first, *widths[i * lobes :][:lobes]] for i, first in enumerate(own)]
    return weights, [[xp.clip(x, MIN_ALPHA, 1.0) for x in side] for side in sides]
