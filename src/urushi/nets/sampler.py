"""The sampler: maps a latent code and a cosine to the proposal, from which directions are drawn.

The proposal is a mixture of GGX reflection lobes and a cosine lobe, exactly normalised. A lobe
reflects wi about a visible GGX normal. Reflected directions below the horizon are mirrored up
(z to |z|). The density of a direction is therefore the reflection density at the direction plus
that at its mirror image, and integrates to one over the upper hemisphere. Directions are (..., 3),
z is the normal, wi is above the horizon.
"""

import math
from typing import Any

from urushi.checks import MIN_ALPHA
from urushi.nets.architecture import Architecture
from urushi.nets.features import MIN_COSINE
from urushi.nets.lobe import lobe_features
from urushi.nets.mlp import Params, hidden_to_output, split_linear

#: Least weight of the cosine lobe. It bounds f cos / pdf where the network is wrong.
MIN_COSINE_SHARE = 0.02

#: ln `MIN_ALPHA`
_LOG_MIN_ALPHA = -4.605170185988092


def sampler_features(cos_i: Any) -> Any:
    """Return two features (..., 2) of an angle: its cosine and the logarithm, normalised."""
    xp = cos_i.__array_namespace__()
    raised = xp.maximum(cos_i, MIN_COSINE)
    return xp.stack([(raised - 0.5) * 3.0, xp.log(raised) + 1.0], axis=-1)


def sampler_inputs(arch: Architecture, z: Any) -> Any:
    """Return what the sampler sees of codes z (..., L): the features of their lobe, the rest."""
    xp = z.__array_namespace__()
    return xp.concat([lobe_features(z[..., : arch.lobe]), z[..., arch.lobe :]], axis=-1)


def mixture(params: Params, arch: Architecture, z: Any, cos_i: Any) -> tuple[Any, Any]:
    """Return the proposal's weights (..., K+1), the last the cosine lobe's, and widths (..., K).

    z (..., L) and cos_i (...), the cosine of wi to the normal, broadcast against each other.
    Weights are positive and add up to 1; widths are GGX alphas in [0.01, 1], the first that of
    the code's lobe.
    """
    first = split_linear(params, "sampler.0", sampler_inputs(arch, z), sampler_features(cos_i))
    output = hidden_to_output(params, "sampler", first, arch.activation)
    xp = output.__array_namespace__()
    k = 1 + arch.lobes
    logits = output[..., : k + 1]
    shares = xp.exp(logits - xp.max(logits, axis=-1, keepdims=True))
    shares = shares * ((1.0 - MIN_COSINE_SHARE) / xp.sum(shares, axis=-1, keepdims=True))
    weights = xp.concat([shares[..., :k], shares[..., k:] + MIN_COSINE_SHARE], axis=-1)
    # Logistic interpolation between ln 1 and ln MIN_ALPHA; tanh cannot overflow.
    fraction = 0.5 - 0.5 * xp.tanh(0.5 * output[..., k + 1 :])
    alphas = xp.exp(_LOG_MIN_ALPHA * fraction)
    own = xp.broadcast_to(z[..., :1], (*alphas.shape[:-1], 1))
    return weights, xp.clip(xp.concat([own, alphas], axis=-1), MIN_ALPHA, 1.0)


def mixture_pdf(weights: Any, alphas: Any, wi: Any, wo: Any) -> Any:
    """Return the density (...) of `sample_mixture` at wo [1/sr]; 0 below the horizon.

    weights (..., K+1): positive, of sum 1, the last the cosine lobe's; alphas (..., K): GGX widths.
    """
    xp = wi.__array_namespace__()
    cos_i, cos_o = wi[..., 2], wo[..., 2]
    lobes = reflection_pdf(alphas, wi[..., None, :], wo[..., None, :])
    density = xp.sum(weights[..., :-1] * lobes, axis=-1) + weights[..., -1] * (cos_o / math.pi)
    return xp.where((cos_i > 0.0) & (cos_o > 0.0), density, 0.0)


def reflection_pdf(alpha: Any, wi: Any, wo: Any) -> Any:
    """Return the density (...) [1/sr] of `sample_reflection`, for wi and wo above the horizon.

    A visible normal has the density G1(wi) (wi.h) D(h) / cos_i (Heitz 2018, eq. 1); its
    reflection has that density divided by 4 wi.h. With Smith's G1 for GGX the quotient is
    D(h) / (2 (cos_i + root)), see `_root`. D is computed from h = wi + wo without normalising it.
    The density of the mirrored directions is included.
    """
    xp = wi.__array_namespace__()
    cos_i, cos_o = wi[..., 2], wo[..., 2]
    alpha2 = alpha * alpha
    x, y = wi[..., 0] + wo[..., 0], wi[..., 1] + wo[..., 1]
    across = x * x + y * y  # the same for wo's mirror image
    up, down = cos_i + cos_o, cos_i - cos_o
    total = _scaled_ggx(alpha2, across, up) + xp.where(
        down > 0.0, _scaled_ggx(alpha2, across, down), 0.0
    )
    below = xp.maximum(cos_i, 0.0) + _root(alpha2, cos_i)  # > 0 even below the horizon
    return total * (alpha2 / (2.0 * math.pi)) / below


def _scaled_ggx(alpha2: Any, across: Any, z: Any) -> Any:
    """Return pi D(h) / alpha^2 of a half vector with |h_xy|^2 = across and h_z = z."""
    xp = across.__array_namespace__()
    ratio = (across + z * z) / xp.maximum(across + alpha2 * (z * z), 1e-18)
    return ratio * ratio


def _root(alpha2: Any, cos_i: Any) -> Any:
    """Return cos_i (1 + 2 Lambda(wi)), Smith's shadowing by GGX: G1 = 2 cos_i / (cos_i + root)."""
    xp = cos_i.__array_namespace__()
    return xp.sqrt(alpha2 + (1.0 - alpha2) * (cos_i * cos_i))


def sample_mixture(weights: Any, alphas: Any, wi: Any, u: Any) -> Any:
    """Return directions wo (..., 3) of density `mixture_pdf` from uniform u (..., 3) in [0, 1).

    u[..., 0] selects the lobe, the other two numbers the direction.
    """
    xp = wi.__array_namespace__()
    choice, u1, u2 = u[..., 0], u[..., 1], u[..., 2]
    edge, alpha = weights[..., 0], alphas[..., 0]
    for k in range(1, alphas.shape[-1]):
        alpha = xp.where(choice >= edge, alphas[..., k], alpha)
        edge = edge + weights[..., k]
    reflected = sample_reflection(alpha, wi, u1, u2)
    radius, phi = xp.sqrt(u1), (2.0 * math.pi) * u2
    cosine = [radius * xp.cos(phi), radius * xp.sin(phi), xp.sqrt(1.0 - u1)]
    cosine = xp.stack(xp.broadcast_arrays(*cosine), axis=-1)
    return xp.where((choice >= edge)[..., None], cosine, reflected)


def sample_reflection(alpha: Any, wi: Any, u1: Any, u2: Any) -> Any:
    """Return wi (..., 3) reflected about a visible normal, mirrored up; density `reflection_pdf`.

    The normal is sampled on a spherical cap (Dupuy and Benyoub 2023, listing 1).
    """
    xp = wi.__array_namespace__()
    x, y, z = alpha * wi[..., 0], alpha * wi[..., 1], wi[..., 2]
    length = xp.sqrt(x * x + y * y + z * z)
    x, y, z = x / length, y / length, z / length
    phi = (2.0 * math.pi) * u1
    cap_z = (1.0 - u2) * (1.0 + z) - z
    cap_r = xp.sqrt(xp.maximum(1.0 - cap_z * cap_z, 0.0))
    hx, hy = alpha * (cap_r * xp.cos(phi) + x), alpha * (cap_r * xp.sin(phi) + y)
    hz = cap_z + z
    scale = 2.0 * (wi[..., 0] * hx + wi[..., 1] * hy + wi[..., 2] * hz)
    scale = scale / xp.maximum(hx * hx + hy * hy + hz * hz, 1e-18)
    wo = [scale * hx - wi[..., 0], scale * hy - wi[..., 1], xp.abs(scale * hz - wi[..., 2])]
    return xp.stack(xp.broadcast_arrays(*wo), axis=-1)
