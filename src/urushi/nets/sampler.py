"""The sampler: maps a latent code and a cosine to the proposal, from which directions are drawn.

The proposal is a mixture of GGX reflection lobes and a cosine lobe, exactly normalised. A lobe
reflects wi about a visible GGX normal. Reflected directions below the horizon are mirrored up
(z to |z|). The density of a direction is therefore the reflection density at the direction plus
that at its mirror image, and integrates to one over the upper hemisphere. Directions are (..., 3),
z is the normal, wi is above the horizon.
"""

import math
from typing import Any

from urushi.checks import MIN_ALPHA, Widths
from urushi.core.mixture import reflection_pdf, sample_reflection
from urushi.core.namespace import (
    Components,
    Namespace,
    arrays,
    components,
    stacked_components,
)
from urushi.nets.architecture import Architecture
from urushi.nets.features import MIN_COSINE
from urushi.nets.lobe import lobe_features, width
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


def sampler_inputs(arch: Architecture, z: Any) -> Any:
    """Return the sampler's inputs for codes z (..., L): the features of their lobe, the rest."""
    xp = z.__array_namespace__()
    return xp.concat([lobe_features(z[..., : arch.lobe]), z[..., arch.lobe :]], axis=-1)


def mixture(params: Params, arch: Architecture, z: Any, wi: Any) -> tuple[Any, Any]:
    """Return the proposal's weights (..., K+1), the last the cosine lobe's, and widths (..., K).

    z (..., L) and wi (..., 3) broadcast against each other. Weights are positive and add up to 1;
    widths are GGX alphas in [0.01, 1]; the first is the width of the code's lobe. They are `Widths`
    of two arrays if the networks are anisotropic.
    """
    angle = sampler_features(wi, arch.widths)
    first = split_linear(params, "sampler.0", sampler_inputs(arch, z), angle)
    output = hidden_to_output(params, "sampler", first, arch.activation)
    xp = output.__array_namespace__()
    k = 1 + arch.lobes
    logits = output[..., : k + 1]
    shares = xp.exp(logits - xp.max(logits, axis=-1, keepdims=True))
    shares = shares * ((1.0 - MIN_COSINE_SHARE) / xp.sum(shares, axis=-1, keepdims=True))
    weights = xp.concat([shares[..., :k], shares[..., k:] + MIN_COSINE_SHARE], axis=-1)
    # Logistic interpolation between ln 1 and ln MIN_ALPHA; tanh cannot overflow.
    fraction = 0.5 - 0.5 * xp.tanh(0.5 * output[..., k + 1 :])
    alphas = xp.exp(math.log(MIN_ALPHA) * fraction)

    def with_own(own: Any, others: Any) -> Any:
        own = xp.broadcast_to(own[..., None], (*others.shape[:-1], 1))
        return xp.clip(xp.concat([own, others], axis=-1), MIN_ALPHA, 1.0)

    own = width(z[..., : arch.lobe])
    if isinstance(own, Widths):
        along, across = alphas[..., : arch.lobes], alphas[..., arch.lobes :]
        return weights, Widths(with_own(own.u, along), with_own(own.v, across))
    return weights, with_own(own, alphas)


def mixture_pdf(weights: Any, alphas: Any, wi: Any, wo: Any) -> Any:
    """Return the density (...) of `sample_mixture` at wo [1/sr]; 0 below the horizon.

    weights (..., K+1): positive, of sum 1, the last the cosine lobe's; alphas (..., K): GGX widths,
    or `Widths` of two such arrays.
    """
    xp = wi.__array_namespace__()
    cos_i, cos_o = wi[..., 2], wo[..., 2]
    pair = components(wi[..., None, :]), components(wo[..., None, :])
    lobes = reflection_pdf(alphas, *pair, arrays(wi))
    density = xp.sum(weights[..., :-1] * lobes, axis=-1) + weights[..., -1] * (cos_o / math.pi)
    return xp.where((cos_i > 0.0) & (cos_o > 0.0), density, 0.0)


def sample_mixture(weights: Any, alphas: Any, wi: Any, u: Any) -> Any:
    """Return directions wo (..., 3) of density `mixture_pdf` from uniform u (..., 3) in [0, 1).

    u[..., 0] selects the lobe, the other two numbers the direction.
    """
    xp = wi.__array_namespace__()
    choice, u1, u2 = u[..., 0], u[..., 1], u[..., 2]
    alpha = Widths(alphas, alphas) if not isinstance(alphas, Widths) else alphas
    chosen, edge = alpha.map(lambda x: x[..., 0]), weights[..., 0]
    for k in range(1, weights.shape[-1] - 1):
        beyond = choice >= edge
        chosen = Widths(
            xp.where(beyond, alpha.u[..., k], chosen.u), xp.where(beyond, alpha.v[..., k], chosen.v)
        )
        edge = edge + weights[..., k]
    reflected = stacked_components(
        sample_reflection(chosen, components(wi), u1, u2, arrays(wi)), xp
    )
    radius, phi = xp.sqrt(u1), (2.0 * math.pi) * u2
    axes = Components(radius * xp.cos(phi), radius * xp.sin(phi), xp.sqrt(1.0 - u1))
    cosine = stacked_components(axes, xp)
    return xp.where((choice >= edge)[..., None], cosine, reflected)
