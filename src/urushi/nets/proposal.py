"""The proposal of a code: the density from which directions are drawn.

It is a mixture of GGX reflection lobes and a cosine lobe, exactly normalised. A lobe reflects wi
about a visible GGX normal. Reflected directions below the horizon are mirrored up (z to |z|). The
density of a direction is therefore the sum of the reflection densities at the direction and at its
mirror image, and integrates to one over the upper hemisphere. Directions are (..., 3), z is the
normal, wi is above the horizon.

The first lobe has the width of the code's own lobe, the others have `ALPHAS`; codes of two GGX
widths stretch them by their last number, ln s, to alpha / s and alpha s. The weights are
estimates of what each lobe reflects. With mu the cosine of wi and c the code without its lobe,

    own lobe   A = F(mu + FACET alpha (1 - mu)) (1 - 0.4 alpha^2) / (1 + alpha^2),
    the rest   e_k = T exp(t_k + s_k ln mu), less o_k e_(k+1), smoothly limited to positive numbers

where T is that of `nets.transmittance` at wi, and o_k e_(k+1) the part that the next wider lobe
covers. t and s are linear in c, and e_k is proportional to the gain of c. A wide lobe gives shares
of A to the widest of `ALPHAS` and to the cosine lobe, which cover it better than its own visible
normals. `urushi.train.proposal_fit` fits t, s and o to the variance of f cos / pdf.
"""

import functools
import math
import operator
from collections.abc import Callable, Sequence
from typing import Any

from urushi.checks import Widths
from urushi.core.mixture import Mixture
from urushi.core.namespace import Namespace, arrays
from urushi.core.stretched import LARGEST as LARGEST_STRETCH
from urushi.core.table import MIN_COSINE
from urushi.nets import lobe as lobes
from urushi.nets import transmittance
from urushi.nets.mlp import Params, product

#: Least weight of the cosine lobe. It bounds f cos / pdf where the weights are wrong.
MIN_COSINE_SHARE = 0.02

#: GGX widths of the lobes beside the code's own. Other numbers hardly lower the variance.
ALPHAS = (0.04, 0.12, 0.3)

#: Numbers of a code from which the weights follow: t and s of `ALPHAS` and of the cosine lobe.
TERMS = 2 * (len(ALPHAS) + 1)

#: Logarithm of the largest energy of a lobe of the rest, for codes unlike those of materials.
MOST_LOG = math.log(4.0)

#: Square of the share of a lobe of the rest that always remains, and a number for sums of zeros.
EDGE, TINY = 1e-3, 1e-12

#: Shift of the cosine at which the own lobe's reflectance is taken: facets turn towards wi.
FACET = 0.5

#: Shares of the own lobe's energy relative to its own share, of the widest of `ALPHAS` and of the
#: cosine lobe: exp(a - ((ln alpha - b) / c)^2). Fitted to lobes of dielectrics and metals.
SPREAD = (1.305, -0.629, 0.401), (1.762, -0.28, 0.381)


def code_terms(params: Params, rest: Any) -> Any:
    """The terms (..., `TERMS`) of codes without their lobes (..., K)."""
    return product(rest, params["proposal.weight"]) + params["proposal.bias"]


def own_energies(
    own: Any, fresnel: Callable[[Any], Any], cosine: Any, xp: Namespace
) -> tuple[Any, Any, Any]:
    """What the code's lobe reflects: shares of itself, of the widest lobe and of the cosine lobe.

    own: its width, or `Widths`. fresnel: from the cosine to a facet to its reflectance. cosine: of
    wi.
    """
    named = xp.named
    mu = named("raised", xp.maximum(cosine, MIN_COSINE))
    alpha = named("width", xp.sqrt(own.u * own.v)) if isinstance(own, Widths) else own
    alpha2, log_alpha = named("width2", alpha * alpha), named("log_width", xp.log(alpha))
    albedo = fresnel(named("to_facet", mu + FACET * alpha * (1.0 - mu)))
    shares = []
    for k, (height, centre, width) in enumerate(SPREAD):
        x = named(f"away{k}", (log_alpha - centre) * (1.0 / width))
        shares.append(named(f"spread{k}", xp.exp(height - x * x)))
    total = (1.0 + alpha2) * (1.0 + shares[0] + shares[1])
    top = named("top", albedo * (1.0 - 0.4 * alpha2) / total)
    return top, top * shares[0], top * shares[1]


def weights(
    terms: Sequence[Any],
    overlaps: Sequence[float],
    own: Any,
    fresnel: Callable[[Any], Any],
    cosine: Any,
    xp: Namespace,
    passed: Any = 1.0,
) -> list[Any]:
    """The weights, positive and of sum 1: of the own lobe, of `ALPHAS` and of the cosine lobe.

    terms: of `code_terms`. overlaps: the numbers o, ``proposal.overlap``. own, fresnel, cosine: as
    of `own_energies`. passed: T(wi) of `nets.transmittance`, which darkens the rest.
    """
    half, top = TERMS // 2, own_energies(own, fresnel, cosine, xp)
    log_mu = xp.named("log_cosine", xp.log(xp.maximum(cosine, MIN_COSINE)))
    energies = [
        xp.named(f"energy{k}", passed * xp.exp(xp.minimum(t + s * log_mu, MOST_LOG)))
        for k, (t, s) in enumerate(zip(terms[:half], terms[half:], strict=True))
    ]
    for k, overlap in enumerate(overlaps):  # from the narrowest on: the next is still whole
        alone = xp.named(f"alone{k}", energies[k] - overlap * energies[k + 1])
        smooth = xp.sqrt(alone * alone + EDGE * energies[k] * energies[k] + TINY)
        energies[k] = xp.named(f"part{k}", 0.5 * (alone + smooth))
    parts = [top[0], *energies[:-2], energies[-2] + top[1], energies[-1] + top[2]]
    total = functools.reduce(operator.add, parts) + TINY
    scale = xp.named("unit_sum", (1.0 - MIN_COSINE_SHARE) / total)
    found = [xp.named(f"weight{k}", part * scale) for k, part in enumerate(parts[:-1])]
    return [*found, 1.0 - functools.reduce(operator.add, found)]


def mixture(params: Params, widths: int, z: Any, wi: Any) -> Mixture:
    """The proposal of codes z (..., L) for wi (..., 3) above the horizon, which broadcast.

    widths: GGX widths of a surface.
    """
    size = len(lobes.NUMBERS[widths])
    lobe, xp = z[..., :size], arrays(wi)
    terms = code_terms(params, z[..., size:])
    own = lobes.width(lobe)
    numbers = weights(
        [terms[..., k] for k in range(TERMS)],
        params["proposal.overlap"].tolist(),
        own,
        functools.partial(lobes.reflectance, lobe),
        wi[..., 2],
        xp,
        transmittance.of_lobe(lobe, wi),
    )
    return Mixture(numbers, widths_of(own, z[..., -1], xp))


def widths_of(own: Any, log_stretch: Any, xp: Namespace) -> list[Any]:
    """The widths of all lobes: the own one's, and `ALPHAS` or their stretched `Widths`.

    log_stretch: ln s; it counts where own is `Widths`.
    """
    if not isinstance(own, Widths):
        return [own, *ALPHAS]
    stretch = xp.exp(xp.clip(log_stretch, -LARGEST_STRETCH, LARGEST_STRETCH))
    return [own, *stretched_widths(xp.named("stretch", stretch))]


def stretched_widths(stretch: Any) -> list[Widths]:
    """`ALPHAS` stretched by s."""
    return [Widths((1.0 / stretch) * alpha, stretch * alpha) for alpha in ALPHAS]
