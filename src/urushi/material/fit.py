"""Codes from which a refinement may start: the encoder's, and those of plain surfaces.

A BRDF unlike all that the encoder was trained on may get a code that is far off, from which no step
leads back; one of a rough conductor or a diffuse surface is then nearer.

Refinement: a few steps that bring a code closer to the BRDF it was encoded from.

The code that fits a BRDF's values best cannot be layered: many codes decode to nearly the same
values, and the layering network knows only those that the encoder makes. So with l the logarithmic
values ln(f + `DARK_OFFSET`) at the probe pairs, l(z) those of what a code decodes to, D(z) the same
as the encoder E sees them (`encoder.log_values`), what is minimised for every channel is

    mean rho(l(z) - l)  +  hold mean d^2,

where rho is the square, linear beyond `KNEE` (Huber 1964), and d is the least change of D(z) after
which the encoder gives z again, E(D(z) + d) = z to first order. Training asks for codes with d = 0
(`train.losses`, the cycle). Both terms are relative errors of f, so that their balance depends
neither on the sizes of the networks nor on the scale of codes. By the damped steps of Marquardt
(1963).

A code that is too bright at one angle would be scaled down at all (`urushi.material.energy`). So
where it reflects more light than the BRDF, the values asked for at that angle are lowered by as
much, and a few more steps follow.

All is done twice: held by `ANCHORED`, which gives the anchor, the code that coats are layered over;
and from there held by hardly anything, `LOOSE`, which gives the code that is looked at.

Correction: two steps of Gauss and Newton that follow the encoder's pass.

They take off a third to a half of what the encoder misses. A code that is corrected is beside
those that the encoder makes, so that coats lie over the encoder's own, the anchor (`refine` says
why, and does all of this with more patience).
"""

import functools
from typing import NamedTuple

import numpy as np

from urushi.geometry.error_metrics import DARK_OFFSET
from urushi.material import energy
from urushi.material.energy import LEAST_ALBEDO
from urushi.nets.encoder import OFFSET, log_values
from urushi.nets.features import direction_features
from urushi.nets.least_squares import damped_step
from urushi.nets.networks import Networks, UrushiNetworks
from urushi.parallel import one_blas_thread
from urushi.reference.stack import conductor, diffuse

#: Widths of the conductors, and what share of white is added to each.
INITIAL_ALPHAS, INITIAL_WHITE_SHARES = (0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0), (0.0, 0.02, 0.2)


def initial_code(networks: UrushiNetworks, f: np.ndarray) -> np.ndarray:
    """The code float32 (L,) of these that decodes to what is closest to values f (P,) [1/sr].

    Codes of plain surfaces are brought to the values' brightness. Closest is the least mean
    difference of logarithms.
    """
    pairs = networks.pairs()
    plain = networks.encode(_surface_codes(networks))
    logs = np.log(f + DARK_OFFSET)
    gains = np.median(logs - np.log(networks.f(plain[:, None], *pairs) + DARK_OFFSET), axis=-1)
    codes = np.concatenate([networks.encode(f[None]), networks.scaled(plain, np.exp(gains))])
    errors = np.abs(np.log(networks.f(codes[:, None], *pairs) + DARK_OFFSET) - logs).mean(axis=-1)
    return codes[errors.argmin()].astype(np.float32)


def _surface_codes(networks: UrushiNetworks) -> np.ndarray:
    """Values float32 (M, P) of plain surfaces at the networks' pairs."""
    wi, wo = networks.pairs()
    return _surface_values(np.asarray(wi).tobytes(), np.asarray(wo).tobytes())


@functools.lru_cache(4)
def _surface_values(wi: bytes, wo: bytes) -> np.ndarray:
    from urushi.reference import analytic  # lazily: it starts Dr.Jit

    pairs = [np.frombuffer(w, np.float32).reshape(-1, 3) for w in (wi, wo)]
    white = analytic.f(diffuse(1.0), *pairs)[:, 0]
    lobes = [analytic.f(conductor(alpha, 0.9), *pairs)[:, 0] for alpha in INITIAL_ALPHAS]
    return np.stack(
        [white] + [lobe + share * white for lobe in lobes for share in INITIAL_WHITE_SHARES]
    )


#: Steps that are tried, each for one pass of decoder and encoder and back.
REFINEMENT_STEPS = 20

#: How much a code's distance from what the encoder makes weighs against its error. With less,
#: layering over odd BRDFs gets worse; without it, layering fails (`python -m
#: benchmarks.quality.refinement`).
ANCHOR_HOLD = 4.0

#: The same for codes that nothing is layered over. Not zero: the probe pairs do not see everything.
CODE_HOLD = 0.0005

#: The nodes' share of the error, where their values are known; and the power of the light they
#: reflect that weighs them.
NODES_SHARE, NODES_POWER = 0.5, 0.5

#: How often values asked for are lowered where a code is too bright, and the steps that follow.
CEILING_ROUNDS, CEILING_STEPS = 2, 6

#: Errors of ln f above this count linearly (Huber 1964). What the decoder cannot make at
#: all must not drag along what it can.
HUBER_KNEE = 0.5

#: The first damping, relative to the mean curvature; its factors after good and bad steps.
FIRST_DAMPING, DAMPING_DECREASE, DAMPING_INCREASE = 1e-3, 0.25, 8.0

#: Relative to their mean, variances of codes under changes of f below this count as this: numbers
#: of a code that the encoder never changes stay as they are.
LEAST_VARIANCE = 1e-6


class FitState(NamedTuple):
    """Where the optimisation of one code stands.

    Attributes:
        z: (L,) the code, float32; objective: what is minimised; slope: (L,) half its gradient;
        curvature: (L, L) half its Hessian by Gauss and Newton, float64.
    """

    z: np.ndarray
    objective: float
    slope: np.ndarray
    curvature: np.ndarray


class FitTarget(NamedTuple):
    """What a code is to decode to, at P probe pairs and perhaps nodes, N in all.

    Attributes:
        features: (N, 8) of the pairs; logs: (N,) of ln(f + `DARK_OFFSET`); weights: (N,), their
            sum is 1.
        probes: P.
    """

    features: np.ndarray
    logs: np.ndarray
    weights: np.ndarray
    probes: int


def fit_target(
    networks: UrushiNetworks, f: np.ndarray, nodes: np.ndarray | None = None
) -> FitTarget:
    """From values f (P,) [1/sr] at `networks.pairs`, and (M,) at the nodes of `energy.rule`."""
    count, features = len(f), probe_features(networks)
    weights = np.full(count, 1.0 / count)
    rule = energy.albedo_rule()
    light = np.zeros(0) if nodes is None else nodes * rule.weights * rule.wi[:, 2]
    if nodes is None or not light.sum() > 0.0:
        return FitTarget(features, np.log(f + DARK_OFFSET), weights, count)
    shares = light**NODES_POWER
    return FitTarget(
        np.concatenate([features, direction_features(rule.wi, rule.wo)]),
        np.log(np.concatenate([f, nodes]) + DARK_OFFSET),
        np.concatenate([(1 - NODES_SHARE) * weights, NODES_SHARE * shares / shares.sum()]),
        count,
    )


def probe_features(networks: UrushiNetworks) -> np.ndarray:
    """What the decoder sees (P, 8) of `networks.pairs`."""
    return _cached_features(*(w.tobytes() for w in networks.pairs()))


@functools.lru_cache(4)
def _cached_features(wi: bytes, wo: bytes) -> np.ndarray:
    return direction_features(*(np.frombuffer(w, np.float32).reshape(-1, 3) for w in (wi, wo)))


def huber_loss(error: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Losses (...) of errors (...), and what the weights of their squares are divided by."""
    far = np.maximum(np.abs(error) / HUBER_KNEE, 1.0)
    return error**2 * (2.0 - 1.0 / far) / far, far


class RefinedCodes(NamedTuple):
    """Codes float32 (C, L): those that decode to what was asked for, and their anchors."""

    codes: np.ndarray
    anchors: np.ndarray


def refine_codes(
    networks: Networks, f: np.ndarray, nodes: np.ndarray | None = None
) -> RefinedCodes:
    """Return codes of BRDFs with values f (C, P) [1/sr] at `networks.pairs`.

    The encoder's, improved. Channel by channel, so that none depends on another even in its last
    digit, which an optimisation may blow up. The paper's networks, which optimise to begin with,
    do no more than encode.

    nodes: (C, M), the BRDFs' values at the nodes of `energy.rule`, if they are known.
    """
    if not isinstance(networks, UrushiNetworks):
        codes = networks.encode(f)
        return RefinedCodes(codes, codes)
    rows = np.ascontiguousarray(f)
    further = [None] * len(rows) if nodes is None else np.ascontiguousarray(nodes)
    codes, anchors = [], []
    with one_blas_thread():
        for row, at_nodes in zip(rows, further, strict=True):
            aim = fit_target(networks, row, at_nodes)
            anchors.append(
                fit_below_ceiling(networks, initial_code(networks, row), aim, ANCHOR_HOLD)
            )
            codes.append(fit_below_ceiling(networks, anchors[-1], aim, CODE_HOLD))
    return RefinedCodes(np.stack(codes), np.stack(anchors))


def fit_below_ceiling(
    networks: UrushiNetworks, z: np.ndarray, aim: FitTarget, hold: float
) -> np.ndarray:
    """`improved`, and then so that no angle is too bright, if the aim knows the nodes.

    Of all codes on the way, z included, the one that is closest once it is scaled down.
    """
    if len(aim.logs) == aim.probes:
        return levenberg_marquardt(networks, z, aim, hold)
    rule, nodes = energy.albedo_rule(), slice(aim.probes, None)
    own = np.maximum(rule.at_angles(np.exp(aim.logs[nodes]) - DARK_OFFSET), LEAST_ALBEDO)
    ceiling = energy.albedo_ceiling(own @ rule.interpolation.T)
    counts = np.diff(rule.first, append=len(rule.wi))
    lower = aim._replace(logs=aim.logs.copy())
    tried = []
    for steps in (REFINEMENT_STEPS, *[CEILING_STEPS] * CEILING_ROUNDS, 0):
        log_f, _ = networks.decode_log(z, aim.features)
        bright = rule.at_angles(np.exp(log_f[nodes]))
        excess = np.log(np.maximum(bright / own, 1.0))
        factor = min((ceiling / np.maximum(bright @ rule.interpolation.T, LEAST_ALBEDO)).min(), 1.0)
        errors = np.log(factor * np.exp(log_f) + DARK_OFFSET) - aim.logs
        tried.append((float(aim.weights @ np.abs(errors)), z))
        if not steps:
            break
        if len(tried) > 1:
            lower.logs[nodes] -= np.repeat(excess, counts)
        z = levenberg_marquardt(networks, z, lower, hold, steps)
    return min(tried, key=lambda pair: pair[0])[1]


def levenberg_marquardt(
    networks: UrushiNetworks,
    z: np.ndarray,
    aim: FitTarget,
    hold: float,
    steps: int = REFINEMENT_STEPS,
) -> np.ndarray:
    """Return a code float32 (L,) that is closer to its aim than z (L,), or as close.

    Every step is damped, and kept only where it lowers the objective.
    """
    state, damping = _state_at(networks, z, aim, hold), FIRST_DAMPING
    for _ in range(steps):
        step = damped_step(state.curvature, state.slope, damping)
        new = _state_at(networks, (state.z - step).astype(np.float32), aim, hold)
        better = new.objective < state.objective  # false for NaN
        state, damping = (
            (new, damping * DAMPING_DECREASE) if better else (state, damping * DAMPING_INCREASE)
        )
    return state.z


def objective(networks: UrushiNetworks, z: np.ndarray, aim: FitTarget, hold: float) -> float:
    """What `improved` minimises, of a code z (L,)."""
    return _state_at(networks, z, aim, hold).objective


def _state_at(networks: UrushiNetworks, z: np.ndarray, aim: FitTarget, hold: float) -> FitState:
    """The state at a code z (L,).

    The encoder's Jacobian J (L, P) makes of changes d of D(z) changes J d of its code. The least d
    that reaches the gap g = z - E(D(z)) has the square g' (J J')^-1 g, which is the second term;
    its derivatives leave out how J itself changes.
    """
    log_f, slopes = networks.decode_log(z, aim.features)
    f = np.exp(log_f)
    seen = (slopes * (f / (f + DARK_OFFSET))[:, None]).astype(np.float64)  # dl/dz, (N, L)
    probed, slopes = f[: aim.probes], slopes[: aim.probes]
    outward = (slopes * (probed / (probed + OFFSET))[:, None]).astype(np.float64)  # dD/dz, (P, L)
    code, inward = (x.astype(np.float64) for x in networks.encode_log(log_values(probed)))
    variance = inward @ inward.T
    variance += LEAST_VARIANCE * np.trace(variance) / len(z) * np.eye(len(z))
    gap, error = z - code, (np.log(f + DARK_OFFSET) - aim.logs).astype(np.float64)
    losses, far = huber_loss(error)
    loss = aim.weights @ losses
    weighted = seen.T * (aim.weights / far)
    gap_slope = np.eye(len(z)) - inward @ outward
    whitened = np.linalg.solve(variance, np.column_stack([gap, gap_slope]))
    hold /= aim.probes
    return FitState(
        z,
        float(loss + hold * gap @ whitened[:, 0]),
        weighted @ error + hold * gap_slope.T @ whitened[:, 0],
        weighted @ seen + hold * gap_slope.T @ whitened[:, 1:],
    )


#: Steps, and their damping relative to the mean curvature (Marquardt 1963).
CORRECTION_STEPS, CORRECTION_DAMPING = 2, 1e-3

#: The probe pairs that the steps look at, and the others; all of them judge the result.
FITTED_PAIRS, CHECKED_PAIRS = slice(0, None, 2), slice(1, None, 2)


def correct_codes(
    networks: Networks, z: np.ndarray, f: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return codes that decode to given values, and how much too bright the encoder's are.

    Args:
        networks: which encode and decode.
        z: (C, L) what the encoder makes of f.
        f: (C, P) values [1/sr] at `networks.pairs`.

    Returns:
        Codes float32 (C, L), closer than z or as close; and the factors (C,) by which what z
        decodes to exceeds f at most. Codes of networks that encode by an optimisation are left as
        they are, and the factors infinite.
    """
    if not isinstance(networks, UrushiNetworks):
        return z, np.full(len(z), np.inf)
    with one_blas_thread():
        return correct_codes_serial(networks, z, f, CORRECTION_DAMPING)


def correct_codes_serial(
    decoder: UrushiNetworks, z: np.ndarray, f: np.ndarray, damping: float
) -> tuple[np.ndarray, np.ndarray]:
    """`corrected` codes z (C, L), on this thread: damping as above."""
    features = probe_features(decoder)
    logs = np.log(f + DARK_OFFSET)

    def errors(codes: np.ndarray, rows: np.ndarray, pairs: slice = slice(None)) -> np.ndarray:
        f_hat = decoder.decode(codes[:, None], features[pairs])
        return np.log(f_hat + DARK_OFFSET) - logs[rows, pairs]

    rows = np.arange(len(z))
    steps, known = _correction_steps(
        decoder, z, features[FITTED_PAIRS], logs[:, FITTED_PAIRS], damping
    )
    before = np.concatenate([known, errors(z, rows, CHECKED_PAIRS)], axis=-1)
    best, least = np.array(z), huber_loss(before)[0].sum(axis=-1)
    for tried in reversed(steps):  # the last one is hardly ever worse than what was encoded
        loss = huber_loss(errors(tried[rows], rows))[0].sum(axis=-1)
        better = loss < least[rows]  # false for NaN
        best[rows[better]] = tried[rows[better]]
        rows = rows[~better]
        if not len(rows):
            break
    return best, np.exp(before.max(axis=-1))


def _correction_steps(
    decoder: UrushiNetworks, z: np.ndarray, features: np.ndarray, logs: np.ndarray, damping: float
) -> tuple[list[np.ndarray], np.ndarray]:
    """Codes (C, L) after each step towards logarithms (C, P), at pairs of features (P, 8).

    And the errors (C, P) before the first one.
    """
    codes, errors = [z], []
    for _ in range(CORRECTION_STEPS):
        log_f, slopes = decoder.decode_log(codes[-1][:, None], features)
        f_hat = np.exp(log_f)
        errors.append(np.log(f_hat + DARK_OFFSET) - logs)
        slopes *= (f_hat / (f_hat + DARK_OFFSET))[..., None]
        codes.append(_correction_step(codes[-1], errors[-1], slopes, damping))
    return codes[1:], errors[0]


def _correction_step(
    z: np.ndarray, error: np.ndarray, slopes: np.ndarray, damping: float
) -> np.ndarray:
    """Codes (C, L) one step from z, by errors (C, P) and their derivatives (C, P, L)."""
    _, far = huber_loss(error)
    weighted = np.swapaxes(slopes / far[..., None], -1, -2)
    curvature = (weighted @ slopes).astype(np.float64)
    slope = (weighted @ error[..., None]).astype(np.float64)[..., 0]
    return (z - damped_step(curvature, slope, damping)).astype(np.float32)
