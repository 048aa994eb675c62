"""Fits of decoders of single BRDFs (`urushi.nets.own_decoder`) to values at some thousand pairs.

The lobe of the code is kept, and the decoder learns the rest. For each channel by itself, damped
steps (Marquardt 1963) lower the weighted sum of rho(e), where e is the error of ln(f +
`DARK_OFFSET`) and rho the square, linear beyond `KNEE` (Huber 1964). Pairs of cosine density weigh
by their share of the reflected light, as in the error E, to the power `POWER`. They are too few in
narrow peaks, so the training pairs that are log-uniform in the half angle weigh by their light too.
Besides, all training pairs weigh the same, for peaks and tails. The nodes of the albedo's
quadrature weigh by their light, of a BRDF brighter by its mean, so that none is left free.

A decoder that reflects more than its BRDF at some angle is scaled down as a whole
(`urushi.material.energy`).
"""

import functools

import numpy as np

from urushi.geometry.direction_sets import cosine_pairs, training_pairs
from urushi.geometry.error_metrics import DARK_OFFSET, energy_weight
from urushi.material import energy
from urushi.nets import own_decoder
from urushi.nets.decoder import MAX_LOG, MIN_LOG
from urushi.nets.features import DIRECTION_FEATURES, direction_features
from urushi.nets.least_squares import damped_step
from urushi.parallel import one_blas_thread

#: Numbers of pairs of cosine density, and of `direction_sets.training_pairs`.
COSINE_PAIRS, TRAINING_PAIRS = 1500, 3600

#: Shares in the error: of the pairs of cosine density, of the training pairs by their light, of the
#: training pairs evenly, and of the albedo's nodes.
SHARES = (0.15, 0.25, 0.2, 0.4)

#: Exponent of the light of a pair in its weight, and the error of ln f from which errors count
#: linearly.
POWER, KNEE = 0.5, 0.2

#: Least curvature by a weight, relative to the mean.
LEAST_CURVATURE = 1e-3

#: Number of trial steps; first damping, relative to the curvature; its factors after accepted
#: and rejected steps; and the damping at which no step helps any more.
STEPS, DAMPING, DECREASE, INCREASE, GREATEST_DAMPING = 100, 1e-2, 0.3, 5.0, 1e6


@functools.cache
def fit_pairs() -> tuple[np.ndarray, np.ndarray]:
    """The pairs wi, wo (N, 3) at which a BRDF has to be known: float32, always the same.

    Those of cosine density come first, then training pairs.
    """
    rng = np.random.default_rng(0)
    sets = cosine_pairs(rng, COSINE_PAIRS), training_pairs(rng, TRAINING_PAIRS)
    wi, wo = (np.concatenate(sides).astype(np.float32) for sides in zip(*sets, strict=True))
    wi.flags.writeable = wo.flags.writeable = False
    return wi, wo


def all_pairs() -> tuple[np.ndarray, np.ndarray]:
    """`fit_pairs`, and after them the nodes of `energy.albedo_rule`."""
    (wi, wo), nodes = fit_pairs(), energy.albedo_rule()
    return np.concatenate([wi, nodes.wi]), np.concatenate([wo, nodes.wo])


@functools.cache
def _features() -> np.ndarray:
    return direction_features(*all_pairs())


def fit_own_decoders(f: np.ndarray, top: np.ndarray, ceiling: np.ndarray) -> np.ndarray:
    """Return decoders float32 (C, `own_decoder.WEIGHTS`) of values f (C, N) [1/sr] at `all_pairs`.

    Args:
        f: the values.
        top: (C, N) [1/sr] the part of the lobes.
        ceiling: (C, D) greatest directional albedos of the rests at the cosines of
            `energy.albedo_rule`.
    """
    with one_blas_thread():
        fitted = np.stack(
            [
                _fitted(own.astype(np.float32), lobe.astype(np.float32))
                for own, lobe in zip(f, top, strict=True)
            ]
        )
    return limited(fitted, ceiling)


def limited(weights: np.ndarray, ceiling: np.ndarray) -> np.ndarray:
    """Decoders scaled down so that their directional albedos are at most a ceiling (C, D)."""
    rule = energy.albedo_rule()
    albedos = rule.albedo(own_decoder.rest(weights, rule.features).T)
    excess = (np.maximum(albedos, energy.LEAST_ALBEDO) / ceiling).max(axis=-1)
    return own_decoder.scaled(weights, 1 / np.maximum(excess, 1))


def _fitted(f: np.ndarray, top: np.ndarray) -> np.ndarray:
    """The decoder (`WEIGHTS`,) of one channel's values (N,), of which `top` (N,) is the lobe's."""
    features, shares, logs = _features(), _weights(f), np.log(f + DARK_OFFSET)

    def state(
        weights: np.ndarray,
    ) -> tuple[float, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        log_rest, slopes = own_decoder.log_rest_slopes(weights, features)
        rest = np.exp(log_rest.clip(MIN_LOG, MAX_LOG))
        made = top + rest + DARK_OFFSET
        error = np.log(made) - logs
        far = np.maximum(np.abs(error) / KNEE, 1)
        loss = float((shares * error**2 * (2 - 1 / far) / far).sum())
        return loss, error, shares / far, rest / made, slopes

    def system(found: tuple) -> tuple[np.ndarray, np.ndarray]:
        _, error, reduced, chain, slopes = found
        slopes *= chain[:, None]
        weighted = slopes.T * reduced
        return (weighted @ slopes).astype(np.float64), (weighted @ error).astype(np.float64)

    weights = _initial(np.maximum(f - top, 0.0))
    found, damping = state(weights), DAMPING
    equations = system(found)
    for _ in range(STEPS):
        tried = (weights - _scaled_step(*equations, damping)).astype(np.float32)
        new = state(tried)
        if new[0] < found[0]:  # false for NaN
            weights, found, damping = tried, new, damping * DECREASE
            equations = system(found)
        else:
            damping *= INCREASE
        if damping > GREATEST_DAMPING:
            break
    return weights


def _scaled_step(curvature: np.ndarray, slope: np.ndarray, damping: float) -> np.ndarray:
    """`damped_step` in units of each weight's own curvature: they differ by orders of magnitude."""
    own = np.diagonal(curvature)
    unit = 1 / np.sqrt(own + LEAST_CURVATURE * own.mean() + 1e-12)
    return unit * damped_step(curvature * unit[:, None] * unit, slope * unit, damping)


def _weights(f: np.ndarray) -> np.ndarray:
    """Weights (N,) of the pairs, float32; their sum is 1."""
    wi, wo = fit_pairs()
    cosine, training, nodes = np.split(f, [COSINE_PAIRS, COSINE_PAIRS + TRAINING_PAIRS])
    rule = energy.albedo_rule()
    parts = [
        cosine * energy_weight(wi[:COSINE_PAIRS, 2], wo[:COSINE_PAIRS, 2]),
        training * _half_angle_measure(wi[COSINE_PAIRS:], wo[COSINE_PAIRS:]),
        np.ones(TRAINING_PAIRS),
        (nodes + nodes.mean()) * rule.weights * rule.wi[:, 2],
    ]
    by_light, by_angle, even, at_nodes = (
        share * part**POWER / max((part**POWER).sum(), 1e-30)
        for share, part in zip(SHARES, parts, strict=True)
    )
    return np.concatenate([by_light, by_angle + even, at_nodes]).astype(np.float32)


def _half_angle_measure(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """The share (N,) of a training pair in the integral of E, up to a factor.

    Every second pair is log-uniform in tan(theta_h) and uniform in theta_d; the others are left
    out. Its share is the reciprocal of that density, where d wi d wo = 4 cos(theta_d) d h d d.
    """
    h = wi.astype(np.float64) + wo
    length = np.linalg.norm(h, axis=1)
    cos_h, cos_d = h[:, 2] / length, np.minimum(0.5 * length, 1)
    sin_h2, sin_d = np.maximum(1 - cos_h**2, 0), np.sqrt(1 - cos_d**2)
    measure = (wi[:, 2] * wo[:, 2]) ** 2 * cos_d * sin_d * sin_h2 * cos_h
    measure[1::2] = 0.0
    return measure


def _initial(rest: np.ndarray) -> np.ndarray:
    """Random weights (`WEIGHTS`,), always the same, of the median brightness of values (N,)."""
    rng, hidden = np.random.default_rng(0), own_decoder.HIDDEN
    parts = [
        rng.standard_normal((DIRECTION_FEATURES, hidden)) / np.sqrt(DIRECTION_FEATURES),
        rng.standard_normal(hidden),
        0.6 * rng.standard_normal(hidden) / np.sqrt(hidden),
        np.zeros(1),
    ]
    weights = np.concatenate([part.ravel() for part in parts]).astype(np.float32)
    log_rest, _ = own_decoder.log_rest_slopes(weights, _features())
    weights[-1] = np.median(np.log(rest + DARK_OFFSET) - log_rest)
    return weights
