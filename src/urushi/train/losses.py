"""The loss of decoded stacks against simulated values, its weights, and codes of coated stacks."""

import math
from typing import Any

import jax
import jax.numpy as jnp

from urushi.checks import CoatParameters
from urushi.core.direction_sets import HALF_ANGLE_RANGE, MIRROR_SHARE, MIRROR_TANGENT
from urushi.core.error_metrics import error_divisors, huber_loss
from urushi.nets.architecture import Architecture
from urushi.nets.decoder import decode
from urushi.nets.encoder import encode
from urushi.nets.features import AZIMUTH_TABLE, DIRECTION_TABLE
from urushi.nets.layerer import layer
from urushi.nets.mlp import Params

#: The loss is linear in relative errors above this: a prediction that is far too dark must not
#: dominate the gradient.
KNEE = 10.0

#: Mean squared relative error of a stack of weight one, and a constant that is added to each
#: stack's, so that nearly perfect stacks do not dominate. Both are close to the noise of
#: simulated values.
TYPICAL, EASE = 1e-2, 3e-3

#: Upper bound of the mean squared relative error in a stack's weight: a stack that is quite wrong
#: must keep a gradient large enough to recover.
WORST = 0.3

#: Bound of the numbers in a code, five times the largest that trained networks produce. Without
#: it codes diverge in the first steps, when five coats are applied one after the other.
LARGEST_CODE = 20.0

#: Consecutive pairs of one mixture, see `core.direction_sets.training_pairs`.
_PERIOD = 4


def error_scale(f_hat: Any) -> jax.Array:
    """Divisors (S, P) of errors: the prediction plus a floor, constant to the gradient.

    The gradient is linear in f, so the minimum lies at the mean of a noisy f, and Monte Carlo
    values of few walks teach without bias (Lehtinen et al. 2018). A logarithm or an L1 norm of
    them would not.
    """
    return error_divisors(jax.lax.stop_gradient(f_hat))


def squared_errors(f_hat: Any, f: Any) -> jax.Array:
    """Squared relative errors (S, P), linear beyond `KNEE`."""
    return huber_loss((f_hat - f) / error_scale(f_hat), KNEE)[0]


def stack_weights(squares: jax.Array) -> jax.Array:
    """Weights (S, P) of squared relative errors (S, P), constant to the gradient.

    Each stack's error is divided by about its own root mean square, so that the few hardest stacks
    (narrow lobes, or nearly black) do not dominate the gradient. A weight computed
    from the same noisy values that it multiplies would be biased against fireflies; therefore the
    pairs are split into halves, and each half is weighted by the error of the other.
    """
    halves = jax.lax.stop_gradient(squares).reshape(len(squares), -1, 2, _PERIOD)
    others = jnp.minimum(halves.mean(axis=(1, 3))[:, None, ::-1, None], WORST)
    weight = jnp.sqrt(TYPICAL / (EASE + others))
    return jnp.broadcast_to(weight, halves.shape).reshape(squares.shape)


def stack_loss(f_hat: Any, f: Any, weights: Any = 1.0) -> jax.Array:
    """Mean over stacks of about the root of their mean squared relative error.

    f_hat, f: (S, P) predicted and simulated values [1/sr], P a multiple of 8. weights: (S, P) of
    the pairs in these means, about 1 on average.
    """
    return mean_loss(weights * squared_errors(f_hat, f))


def mean_loss(squares: jax.Array, weights: Any = 1.0) -> jax.Array:
    """`stack_loss` from squared relative errors (S, P) and further weights (S, P) of the pairs."""
    return jnp.mean(weights * stack_weights(squares) * squares)


def compose(
    params: Params, arch: Architecture, lobes: Any, probes: Any, coats: tuple[Any, ...]
) -> Any:
    """Latent codes (B, L) of stacks: encode their bottoms, then apply coat after coat.

    lobes, probes, coats: as in `batches.Batch`.
    """
    return apply_coats(params, arch, encoded(params, arch, lobes, probes), coats)


def encoded(params: Params, arch: Architecture, lobes: Any, probes: Any) -> Any:
    """Codes (B, L) of BRDFs with these lobes (B, L) and other values (B, probes) [1/sr]."""
    return jnp.concatenate([lobes, bounded(encode(params, arch, probes))], axis=-1)


def apply_coats(params: Params, arch: Architecture, z: Any, coats: tuple[Any, ...]) -> Any:
    """Codes (B, L) of stacks from the codes z (B, L) of their bottoms; coats as of `compose`."""
    for coat in coats:
        count = coat.shape[0]
        layered = layer(params, arch, z[:count], columns_of(coat))
        layered = jnp.concatenate(
            [layered[:, : arch.lobe], bounded(layered[:, arch.lobe :])], axis=-1
        )
        z = jnp.concatenate([layered, z[count:]])
    return z


def columns_of(coats: Any) -> CoatParameters:
    """The parameters (B,) of coats (B, C), whose columns are `checks.COAT_COLUMNS`."""
    return CoatParameters.of_columns(jnp.moveaxis(coats, -1, 0))


def without_lobe(params: Params, arch: Architecture, z: Any, features: Any) -> jax.Array:
    """The decoded rest (B, P) [1/sr] of codes z (B, L) at features (B, P, D) of pairs."""
    return decode(params, arch, z[:, None, arch.lobe :], features)


@jax.custom_vjp
def bounded(z: jax.Array) -> jax.Array:
    """Codes clipped to `LARGEST_CODE`. Outside, only gradients that lead back inside remain."""
    return jnp.clip(z, -LARGEST_CODE, LARGEST_CODE)


def _bounded_pullback(z: jax.Array, gradient: jax.Array) -> tuple[jax.Array]:
    return (jnp.where((jnp.abs(z) < LARGEST_CODE) | (gradient * z > 0), gradient, 0.0),)


bounded.defvjp(lambda z: (bounded(z), z), _bounded_pullback)


#: Largest weight of a pair over the mean of its run: pairs of bright, narrow peaks are few.
LARGEST_WEIGHT = 20.0

#: Share of the drawn pairs of `direction_sets.half_angle_pairs` (one GGX width) and `slope_pairs`
#: (two) that are accepted, for the arguments of training pairs.
ABOVE_HORIZON = {1: 0.8501, 2: 0.7963}

_TABLE = DIRECTION_TABLE + AZIMUTH_TABLE
_COLUMNS = {name: column for column, (name, _, _) in enumerate(_TABLE)}


def pair_weights(f_hat: Any, features: Any, share: float) -> Any:
    """Weights (B, P) of pairs: a share of them are `energy_weights`, the others are one."""
    if share == 0.0:
        return 1.0
    return 1.0 - share + share * energy_weights(f_hat, features)


def energy_weights(f_hat: Any, features: Any) -> jax.Array:
    """Weights (B, P) of pairs by their share of the energy that E measures; of mean about one.

    E is a mean over pairs of cosine density, weighted by both cosines. Training pairs have another
    density, so a pair counts by f cos^2 theta_i cos^2 theta_o over that density.

    Args:
        f_hat: (B, P) predicted values [1/sr], which have no noise that the weights could follow.
        features: (B, P, D) of pairs of the set "training" (one GGX width) or "anisotropic" (two).
    """
    energies = jax.lax.stop_gradient(f_hat) * cosines_over_density(features)
    return jnp.minimum(energies / energies.mean(axis=-1, keepdims=True), LARGEST_WEIGHT)


def cosines_over_density(features: Any) -> jax.Array:
    """cos^2 theta_i cos^2 theta_o over the density [1/sr^2] of training pairs.

    features (..., D): `features.direction_features` of `direction_sets.training_pairs`, or for two
    GGX widths of `anisotropic_pairs`. Exact mirror directions, which are drawn with a probability
    instead of a density, give nearly zero.
    """
    widths = 2 if features.shape[-1] == len(_TABLE) else 1
    tangent2 = jnp.maximum(jnp.exp(_column(features, "ln(tan^2 theta_h + 1e-6)")) - 1e-6, 1e-9)
    cosines = jnp.exp(2.0 * _column(features, "1/2 ln(cos_i cos_o)"))
    cos_h = 1.0 / jnp.sqrt(1.0 + tangent2)
    cos_d = jnp.clip(_column(features, "cos theta_d"), 1e-3, 1.0 - 1e-6)

    # Densities of the half vector [1/sr]: of `half_angle_pairs`, of the two kinds of `slope_pairs`,
    # and near mirror directions. The span is the range of ln tan(theta_h).
    low, high = HALF_ANGLE_RANGE
    span = math.log(high / low)
    half_vector = 1.0 / (2.0 * math.pi * span * tangent2 * cos_h**3)
    half_vector = jnp.where(_within(tangent2), half_vector, 0.0)
    if widths == 2:
        x2 = jnp.maximum(jnp.exp(_column(features, "ln(h_x^2 / h_z^2 + 1e-6)")) - 1e-6, 1e-9)
        y2 = jnp.maximum(jnp.exp(_column(features, "ln(h_y^2 / h_z^2 + 1e-6)")) - 1e-6, 1e-9)
        slopes = 1.0 / (4.0 * span**2 * jnp.sqrt(x2 * y2) * cos_h**3)
        slopes = jnp.where(_within(x2) & _within(y2), slopes, 0.0)
        half_vector = 0.5 * (half_vector + slopes)
    mirrored = 1.0 / (2.0 * math.pi * MIRROR_TANGENT * jnp.sqrt(tangent2) * cos_h**3)
    mirrored = jnp.where(tangent2 < MIRROR_TANGENT**2, 0.5 * mirrored, 0.0)
    half_vector = (1.0 - MIRROR_SHARE) * half_vector + MIRROR_SHARE * mirrored
    # Of wi about it, with theta_d and phi_d uniform; and the Jacobian of h to wo, 4 cos theta_d.
    about = 1.0 / (math.pi**2 * jnp.sqrt(1.0 - cos_d * cos_d) * 4.0 * cos_d)
    density = 0.5 * half_vector * about / ABOVE_HORIZON[widths]
    density += 0.25 * cosines / math.pi**2 + 0.25 / (4.0 * math.pi**2)
    return cosines * cosines / density


def _within(slope2: Any) -> jax.Array:
    """Whether squared slopes are in the range of training pairs."""
    low, high = HALF_ANGLE_RANGE
    return (slope2 > low**2) & (slope2 < high**2)


def _column(features: Any, name: str) -> jax.Array:
    """A feature before its normalisation."""
    column = _COLUMNS[name]
    _, mean, scale = _TABLE[column]
    return features[..., column] * scale + mean
