"""Weights of training pairs by the energy that they reflect, as the error E weighs them."""

import math
from typing import Any

import jax
import jax.numpy as jnp

from urushi.core.direction_sets import HALF_ANGLE_RANGE, MIRROR_SHARE, MIRROR_TANGENT
from urushi.errors import ParameterError
from urushi.nets.features import AZIMUTH_TABLE, DIRECTION_TABLE

#: Largest weight of a pair over the mean of its run: pairs of bright, narrow peaks are few.
LARGEST = 20.0

#: Share of the drawn pairs of `direction_sets.slope_pairs` whose directions are both above the
#: horizon, for the range and the mirror share of training pairs.
ABOVE_HORIZON = 0.7963

_TABLE = DIRECTION_TABLE + AZIMUTH_TABLE
_COLUMNS = {name: column for column, (name, _, _) in enumerate(_TABLE)}


def pair_weights(f_hat: Any, features: Any, share: float) -> Any:
    """Weights (B, P) of pairs: a share of them are `energy_weights`, the others are one.

    Raises:
        ParameterError: a share above zero and features (B, P, D) of one GGX width, whose training
            pairs have another density.
    """
    if share == 0.0:
        return 1.0
    if features.shape[-1] != len(_TABLE):
        raise ParameterError(
            f"energy_share is {share} with features of one GGX width; it must be 0 unless the "
            "networks have widths=2"
        )
    return 1.0 - share + share * energy_weights(f_hat, features)


def energy_weights(f_hat: Any, features: Any) -> jax.Array:
    """Weights (B, P) of pairs by their share of the energy that E measures; of mean about one.

    E is a mean over pairs of cosine density, weighted by both cosines. Training pairs have another
    density, so a pair counts by f cos^2 theta_i cos^2 theta_o over that density.

    Args:
        f_hat: (B, P) predicted values [1/sr], which have no noise that the weights could follow.
        features: (B, P, D) of pairs of the set "anisotropic", for networks of two GGX widths.
    """
    energies = jax.lax.stop_gradient(f_hat) * cosines_over_density(features)
    return jnp.minimum(energies / energies.mean(axis=-1, keepdims=True), LARGEST)


def cosines_over_density(features: Any) -> jax.Array:
    """cos^2 theta_i cos^2 theta_o over the density [1/sr^2] of `direction_sets.anisotropic_pairs`.

    features (..., D): `features.direction_features` of the pairs, for two GGX widths. Exact mirror
    directions, which are drawn with a probability instead of a density, give nearly zero.
    """
    tangent2 = jnp.maximum(jnp.exp(_column(features, "ln(tan^2 theta_h + 1e-6)")) - 1e-6, 1e-9)
    x2 = jnp.maximum(jnp.exp(_column(features, "ln(h_x^2 / h_z^2 + 1e-6)")) - 1e-6, 1e-9)
    y2 = jnp.maximum(jnp.exp(_column(features, "ln(h_y^2 / h_z^2 + 1e-6)")) - 1e-6, 1e-9)
    cosines = jnp.exp(2.0 * _column(features, "1/2 ln(cos_i cos_o)"))
    cos_h = 1.0 / jnp.sqrt(1.0 + tangent2)
    cos_d = jnp.clip(_column(features, "cos theta_d"), 1e-3, 1.0 - 1e-6)

    # Densities of the half vector [1/sr] of the three kinds of `slope_pairs`. The span is that of
    # ln tan(theta_h).
    low, high = HALF_ANGLE_RANGE
    span = math.log(high / low)
    radial = 1.0 / (2.0 * math.pi * span * tangent2 * cos_h**3)
    slopes = 1.0 / (4.0 * span**2 * jnp.sqrt(x2 * y2) * cos_h**3)
    mirrored = 1.0 / (2.0 * math.pi * MIRROR_TANGENT * jnp.sqrt(tangent2) * cos_h**3)
    half_vector = (1.0 - MIRROR_SHARE) * 0.5 * (
        jnp.where(_within(tangent2), radial, 0.0)
        + jnp.where(_within(x2) & _within(y2), slopes, 0.0)
    ) + jnp.where(tangent2 < MIRROR_TANGENT**2, 0.5 * MIRROR_SHARE * mirrored, 0.0)
    # Of wi about it, with theta_d and phi_d uniform; and the Jacobian of h to wo, 4 cos theta_d.
    about = 1.0 / (math.pi**2 * jnp.sqrt(1.0 - cos_d * cos_d) * 4.0 * cos_d)
    density = 0.5 * half_vector * about / ABOVE_HORIZON
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
