"""Codes of simulated stacks, fitted to values that have the noise of few random walks.

`urushi.material.fit` compares logarithms at the probe pairs, where the noise of few walks would
make f too dark. Here errors are linear in f, and the divisor of an error does not depend on the
value: the minimum is at the mean of noisy values (Lehtinen et al. 2018), so that many pairs of few
walks each can be used. The objective of every channel is

    mean rho((f(z) - f) / s)  +  ALBEDO_WEIGHT mean max(a(z) - a - e, 0)^2  +  HOLD |z - z_0|^2,

where rho is the square, linear beyond `KNEE` (Huber 1964), s the values of the code before the last
few steps plus a floor, a the directional albedo, e its standard error and z_0 the encoder's code.
The second term is for energy: without it, single albedos are up to 2 % too large
(`benchmarks.quality.anisotropy`). Without e it would lower f by its noise.

A fifth of the pairs has cosine density. The others have a few directions wi, and each of these has
directions wo that the material's own proposal draws; their weighted sum is the albedo.
"""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import error_divisors, huber_loss
from urushi.material import energy
from urushi.material.fit import code_steps
from urushi.material.material import Material
from urushi.nets.features import direction_features
from urushi.nets.least_squares import FitState
from urushi.nets.networks import UrushiNetworks
from urushi.parallel import one_blas_thread

#: Pairs of cosine density, directions wi of the albedos, and directions wo of each of these.
COSINE_PAIRS, ANGLES, PER_ANGLE = 2048, 32, 256

#: Random walks of a Stack for each pair and channel.
FIT_WALKS = 256

#: Seed of the pairs.
SEED = 1

#: Times that the divisors of the errors are computed, and steps after each.
ROUNDS, STEPS = 6, 6

#: Relative error above which the loss is linear.
KNEE = 3.0

#: Weights of squared albedos that are too large, and of the distance from the encoder's code.
ALBEDO_WEIGHT, HOLD = 200.0, 1e-5

#: Golden ratio less one, whose multiples are evenly spread modulo 1.
_GOLDEN = 0.6180339887498949


class Pairs(NamedTuple):
    """Pairs of directions of a fit.

    The last `ANGLES` x `PER_ANGLE` pairs measure the albedos.
    """

    wi: np.ndarray  # float32 (N, 3)
    wo: np.ndarray  # float32 (N, 3)
    share: np.ndarray  # (N,) weights of the errors; their sum is 1
    # (ANGLES, PER_ANGLE) weights by which the sum of f is an estimate of the albedo.
    light: np.ndarray


class Aim(NamedTuple):
    """Target values of one channel."""

    features: np.ndarray  # (N, D) of the pairs
    top: np.ndarray  # (N,) [1/sr] what the code's lobe reflects
    f: np.ndarray  # (N,) [1/sr] the simulated values
    # (`ANGLES`,) excesses of the albedos that are not penalised: their standard errors.
    allowed: np.ndarray
    pairs: Pairs
    start: np.ndarray  # (L,) the encoder's code


def fit_to_walks(
    material: Material, simulated: Callable[[np.ndarray, np.ndarray], tuple[Any, Any]]
) -> Material:
    """The material with codes that are fitted to simulated values.

    Args:
        material: the encoded stack of C channels; its anchors and its table are kept.
        simulated: simulated(wi, wo) -> f, se, (N, C) each [1/sr], values without bias and their
            standard errors, for float32 unit vectors (N, 3) above the horizon.
    """
    networks = material.model.networks
    pairs = drawn_pairs(material, np.random.default_rng(SEED))
    f, se = (np.asarray(x, np.float64) for x in simulated(pairs.wi, pairs.wo))
    features = direction_features(pairs.wi, pairs.wo, networks.arch.widths)
    codes: list[np.ndarray] = []
    with one_blas_thread():
        for channel, (z, anchor) in enumerate(zip(material.latents, material.anchors, strict=True)):
            top = networks.top(z, pairs.wi, pairs.wo)
            error = se[COSINE_PAIRS:, channel].reshape(pairs.light.shape)
            allowed = np.linalg.norm(pairs.light * error, axis=1)
            aim = Aim(features, top, f[:, channel], allowed, pairs, anchor)
            codes.append(fit_code(networks, z, aim))
    limited = energy.limit_albedo(
        material.model, np.stack(codes), np.full((len(codes), 1), 1 - energy.MARGIN)
    )
    return Material(limited, material.model, material.anchors, material.table)


def drawn_pairs(material: Material, rng: np.random.Generator) -> Pairs:
    """Pairs for the fit of a material."""
    place = (np.arange(ANGLES) + rng.random(ANGLES)) / ANGLES
    azimuth = 2 * np.pi * ((_GOLDEN * np.arange(ANGLES) + rng.random()) % 1)
    cosine, sine = np.sqrt(place), np.sqrt(1 - place)
    angles = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine], axis=-1)
    repeated = np.repeat(angles.astype(np.float32), PER_ANGLE, axis=0)
    wo, pdf = material.sample(repeated, rng.random((len(repeated), 3)))
    drawn = pdf > 0
    wo = np.where(drawn[:, None], wo, np.array([0, 0, 1], np.float32))
    light = np.where(drawn, wo[:, 2] / np.where(drawn, pdf, 1), 0) / PER_ANGLE
    spread = cosine_pairs(rng, COSINE_PAIRS)
    used = np.concatenate([np.ones(COSINE_PAIRS, bool), drawn])
    return Pairs(
        np.concatenate([spread[0], repeated]),
        np.concatenate([spread[1], wo]),
        used / used.sum(),
        light.reshape(ANGLES, PER_ANGLE),
    )


def fit_code(networks: UrushiNetworks, z: np.ndarray, aim: Aim) -> np.ndarray:
    """The code float32 (L,) that fits the aim, from z (L,)."""
    for _ in range(ROUNDS):
        scale = error_divisors(aim.top + networks.rest(z, aim.features))
        z = code_steps(functools.partial(_state_at, networks, aim, scale), z, STEPS)
    return z


def _state_at(networks: UrushiNetworks, aim: Aim, scale: np.ndarray, z: np.ndarray) -> FitState:
    """The objective at a code z (L,), for divisors scale (N,) [1/sr] of the errors."""
    log_rest, slopes = networks.decode_log(z, aim.features)
    rest = np.exp(log_rest)
    difference = aim.top + rest - aim.f
    slopes = (slopes * rest[:, None]).astype(np.float64)  # df/dz, (N, R)
    losses, far = huber_loss(difference / scale, KNEE)
    weight = aim.pairs.share / (far * scale * scale)

    light = aim.pairs.light
    own = slice(COSINE_PAIRS, None)
    excess = (light * difference[own].reshape(light.shape)).sum(axis=1) - aim.allowed
    excess = np.maximum(excess, 0.0)
    of_angles = np.einsum("ap,apr->ar", light, slopes[own].reshape(*light.shape, -1))
    of_angles *= (excess > 0)[:, None]
    albedo_weight = ALBEDO_WEIGHT / len(light)

    moved = (z - aim.start)[networks.arch.lobe :].astype(np.float64)
    weighted = slopes.T * weight
    return FitState(
        z,
        float(aim.pairs.share @ losses + albedo_weight * excess @ excess + HOLD * moved @ moved),
        weighted @ difference + albedo_weight * excess @ of_angles + HOLD * moved,
        weighted @ slopes + albedo_weight * of_angles.T @ of_angles + HOLD * np.eye(len(moved)),
    )
