"""Refinement: a fit of latent codes to BRDF values, one channel at a time.

It keeps the lobe of a code (`urushi.nets.lobe`) and changes the rest. Errors are those of the whole
f, lobe included. The best fit to a BRDF's values cannot be layered, because many codes decode to
nearly the same values. So the objective includes the distance from the encoder's codes. Let l be
the logarithmic values ln(f + `DARK_OFFSET`) at the probe pairs, l(z) those that a code z decodes
to, and D(z) the decoded values without the lobe, as the encoder E sees them (`encoder.log_values`).
The objective of every channel is

    mean rho(l(z) - l)  +  hold mean d^2,

where rho is the square, linear beyond `HUBER_KNEE` (Huber 1964), and d is the smallest change of
D(z) after which the encoder gives z again, E(D(z) + d) = z to first order. Training asks for codes
with d = 0 (`train.losses`, the cycle). Both terms are relative errors of f, so that their balance
depends neither on the size of the networks nor on the scale of codes. The minimum is found by
damped steps (Marquardt 1963).

A code that is too bright at one angle would be scaled down as a whole (`urushi.material.energy`).
So where a code reflects more light than the BRDF, the target values at that angle are lowered by
the excess, and a few more steps follow.

Two codes are fitted: with the hold `ANCHOR_HOLD`, the anchor; from there with the much smaller
`CODE_HOLD`, the code that is evaluated.

Initial guesses. For a BRDF far from all training data, the encoder's code may be so bad that the
fit does not converge; the code of a rough conductor or of a diffuse surface is then a better start.
"""

import functools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from urushi.core.error_metrics import DARK_OFFSET, huber_loss
from urushi.core.probe_pairs import probe_pairs
from urushi.material import energy
from urushi.material.albedo_rule import albedo_rule
from urushi.material.energy import LEAST_ALBEDO
from urushi.material.lobe_albedo import lobe_albedos
from urushi.nets import lobe as lobes
from urushi.nets.encoder import OFFSET, log_values
from urushi.nets.features import direction_features
from urushi.nets.least_squares import Damping, FitState, damped_steps
from urushi.nets.lobe import no_lobe
from urushi.nets.lobe_fit import fit_lobes
from urushi.nets.networks import UrushiNetworks
from urushi.parallel import one_blas_thread
from urushi.walk import analytic, conductor, diffuse

#: Roughness of the conductors among the initial guesses, and shares of a white diffuse lobe that
#: are added to each.
INITIAL_ALPHAS, INITIAL_WHITE_SHARES = (0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0), (0.0, 0.02, 0.2)


def initial_code(networks: UrushiNetworks, f: np.ndarray, lobe: np.ndarray) -> np.ndarray:
    """The initial guess float32 (L,) with the least mean error of ln f for values f (P,) [1/sr].

    The candidates are the encoder's code, and codes of conductors and a diffuse surface, scaled to
    the brightness of f. All have the lobe (6,) of f; the surfaces stand for its rest.
    """
    arch = networks.arch
    features, surfaces = probe_features(networks), _surface_values(arch.probes, arch.widths)
    own, top = networks.encode(f[None], lobe[None]), lobes.f(lobe, *networks.pairs())
    plain = networks.encode(surfaces, np.array([no_lobe(networks.arch.widths)], np.float32))
    logs, rest = np.log(f + DARK_OFFSET), np.log(np.maximum(f - top, 0.0) + DARK_OFFSET)
    gains = np.median(rest - np.log(networks.rest(plain[:, None], features) + DARK_OFFSET), axis=-1)
    codes = np.concatenate([own, networks.rest_scaled(plain, np.exp(gains))])
    codes[:, : networks.arch.lobe] = own[0, : networks.arch.lobe]
    decoded = top + networks.rest(codes[:, None], features)
    errors = np.abs(np.log(decoded + DARK_OFFSET) - logs).mean(axis=-1)
    return codes[errors.argmin()].astype(np.float32)


@functools.cache
def _surface_values(probes: int, widths: int) -> np.ndarray:
    """Values float32 (M, P) [1/sr] of conductors and a diffuse surface at the probe pairs."""
    pairs = probe_pairs(probes, widths)
    white = analytic.f(diffuse(1.0), *pairs)[:, 0]
    lobes = [analytic.f(conductor(alpha, 0.9), *pairs)[:, 0] for alpha in INITIAL_ALPHAS]
    return np.stack(
        [white] + [lobe + share * white for lobe in lobes for share in INITIAL_WHITE_SHARES]
    )


#: Number of trial steps; each costs one forward and backward pass of decoder and encoder.
REFINEMENT_STEPS = 20

#: Weight of the distance from the encoder's codes, for anchors. With less, layering over unusual
#: BRDFs gets worse; without it, layering fails (`python -m benchmarks.quality.refinement`).
ANCHOR_HOLD = 4.0

#: The same weight for codes that are only evaluated. It is not zero, because the probe pairs do not
#: determine f everywhere.
CODE_HOLD = 0.0005

#: Share of the albedo nodes in the error, where their values are known, and the exponent applied to
#: each node's reflected energy to get its weight.
NODES_SHARE, NODES_POWER = 0.5, 0.5

#: Number of times that target values are lowered where a code is too bright, and steps after each.
CEILING_ROUNDS, CEILING_STEPS = 2, 6

#: Errors of ln f above this count linearly (Huber 1964), so that values that the decoder cannot
#: reach do not spoil the others.
HUBER_KNEE = 0.5

#: Damping of the steps.
DAMPING = Damping(1e-3, 0.25, 8.0)

#: Least variance of a code's numbers under changes of f, relative to their mean: numbers that the
#: encoder never changes keep their value.
LEAST_VARIANCE = 1e-6


class FitTarget(NamedTuple):
    """Target values of a fit at N pairs: the P probe pairs, and the albedo nodes if known."""

    features: np.ndarray  # (N, D) of the pairs
    logs: np.ndarray  # (N,) of ln(f + `DARK_OFFSET`)
    weights: np.ndarray  # (N,), their sum is 1
    top: np.ndarray  # (N,) [1/sr] the part of f that the code's lobe reflects
    probes: int  # P


def fit_target(
    networks: UrushiNetworks,
    f: np.ndarray,
    nodes: np.ndarray | None,
    lobe: np.ndarray,
) -> FitTarget:
    """The target of values f (P,) [1/sr] at `networks.pairs` and nodes (M,) at the albedo nodes.

    The albedo nodes are the nodes of `albedo_rule`; None: their values are not known. lobe: (K,)
    the code's lobe.
    """
    count, features = len(f), probe_features(networks)
    top = lobes.f(lobe, *networks.pairs())
    weights = np.full(count, 1.0 / count)
    rule = albedo_rule(networks.arch.widths)
    light = np.zeros(0) if nodes is None else nodes * rule.weights * rule.wi[:, 2]
    if nodes is None or not light.sum() > 0.0:
        return FitTarget(features, np.log(f + DARK_OFFSET), weights, top, count)
    shares = light**NODES_POWER
    at_nodes = lobes.f(lobe, rule.wi, rule.wo)
    return FitTarget(
        np.concatenate([features, rule.features]),
        np.log(np.concatenate([f, nodes]) + DARK_OFFSET),
        np.concatenate([(1 - NODES_SHARE) * weights, NODES_SHARE * shares / shares.sum()]),
        np.concatenate([top, at_nodes]),
        count,
    )


def probe_features(networks: UrushiNetworks) -> np.ndarray:
    """The decoder's input features (P, D) of `networks.pairs`."""
    return _probe_features(networks.arch.probes, networks.arch.widths)


@functools.cache
def _probe_features(probes: int, widths: int) -> np.ndarray:
    return direction_features(*probe_pairs(probes, widths), widths)


class RefinedCodes(NamedTuple):
    """Codes float32 (C, L) that fit the target values, and their anchors."""

    codes: np.ndarray
    anchors: np.ndarray


def refine_codes(
    networks: UrushiNetworks,
    f: np.ndarray,
    nodes: np.ndarray | None = None,
    lobe: np.ndarray | None = None,
) -> RefinedCodes:
    """Return refined codes of BRDFs with values f (C, P) [1/sr] at `networks.pairs`.

    Each channel is optimised by itself, so that no rounding error of one affects another.

    nodes: (C, M) [1/sr], the BRDFs' values at the nodes of `albedo_rule`, if known. lobe:
    (C, 6), which the codes keep; None: `fit_lobes` gives them.
    """
    rows = np.ascontiguousarray(f)
    own = fit_lobes(rows, networks.arch.widths) if lobe is None else lobe
    further = [None] * len(rows) if nodes is None else np.ascontiguousarray(nodes)
    codes, anchors = [], []
    with one_blas_thread():
        for row, at_nodes, top in zip(rows, further, own, strict=True):
            aim = fit_target(networks, row, at_nodes, top)
            start = initial_code(networks, row, top)
            anchors.append(fit_below_ceiling(networks, start, aim, ANCHOR_HOLD))
            codes.append(fit_below_ceiling(networks, anchors[-1], aim, CODE_HOLD))
    return RefinedCodes(np.stack(codes), np.stack(anchors))


def fit_below_ceiling(
    networks: UrushiNetworks, z: np.ndarray, aim: FitTarget, hold: float
) -> np.ndarray:
    """`levenberg_marquardt`, repeated with lower targets at angles where the code is too bright.

    The rounds follow only if the target has albedo nodes. Returns the code, of z and the result of
    each round, that is closest to the target once it is scaled down to its ceiling.
    """
    if len(aim.logs) == aim.probes:
        return levenberg_marquardt(networks, z, aim, hold)
    rule, nodes = albedo_rule(networks.arch.widths), slice(aim.probes, None)
    target = np.maximum(np.exp(aim.logs) - DARK_OFFSET - aim.top, 0.0)  # of the rest
    own = np.maximum(rule.at_angles(target[nodes]), LEAST_ALBEDO)
    ceiling = _rest_ceiling(networks, z, rule.interpolated(own))
    counts = np.diff(rule.first, append=len(rule.wi))
    lower = aim._replace(logs=aim.logs.copy())
    tried = []
    for steps in (REFINEMENT_STEPS, *[CEILING_STEPS] * CEILING_ROUNDS, 0):
        rest = networks.rest(z, aim.features)
        bright = rule.at_angles(rest[nodes])
        excess = np.maximum(bright / own, 1.0)
        factor = min((ceiling / np.maximum(rule.interpolated(bright), LEAST_ALBEDO)).min(), 1.0)
        errors = np.log(aim.top + factor * rest + DARK_OFFSET) - aim.logs
        tried.append((float(aim.weights @ np.abs(errors)), z))
        if not steps:
            break
        if len(tried) > 1:
            target[nodes] /= np.repeat(excess, counts)
            lower.logs[nodes] = np.log(aim.top[nodes] + target[nodes] + DARK_OFFSET)
        z = levenberg_marquardt(networks, z, lower, hold, steps)
    return min(tried, key=lambda pair: pair[0])[1]


def _rest_ceiling(networks: UrushiNetworks, z: np.ndarray, own: np.ndarray) -> np.ndarray:
    """The ceiling (D,) of the rest of a code (L,), from the albedos own (D,) of its target."""
    lobe, rule = z[: networks.arch.lobe], albedo_rule(networks.arch.widths)
    if not energy.is_limited(lobe):
        return np.full_like(own, np.inf)
    top = lobe_albedos(lobe, rule)
    return np.maximum(energy.albedo_ceiling(own + top, rule) - top, energy.LEAST_REST)


def levenberg_marquardt(
    networks: UrushiNetworks,
    z: np.ndarray,
    aim: FitTarget,
    hold: float,
    steps: int = REFINEMENT_STEPS,
) -> np.ndarray:
    """Return a code float32 (L,) whose objective is at most that of z (L,)."""
    return code_steps(lambda z: state_at(networks, z, aim, hold), z, steps)


def code_steps(state_at: Callable[[np.ndarray], FitState], z: np.ndarray, steps: int) -> np.ndarray:
    """`damped_steps` of a code z (L,). The unknowns are the numbers after the lobe's."""
    return damped_steps(state_at, z, steps, DAMPING, stepped)


def stepped(z: np.ndarray, step: np.ndarray) -> np.ndarray:
    """Codes float32 (..., L) after a step (..., R) of the R numbers that follow the lobe's."""
    lobe = z.shape[-1] - step.shape[-1]
    return np.concatenate([z[..., :lobe], z[..., lobe:] - step], axis=-1).astype(np.float32)


def state_at(networks: UrushiNetworks, z: np.ndarray, aim: FitTarget, hold: float) -> FitState:
    """The state at a code z (L,). The unknowns are the R numbers after the lobe's.

    The encoder's Jacobian J (R, P) maps a change d of D(z) to the change J d of its code. The
    smallest d that closes the gap g = z - E(D(z)) has the square g' (J J')^-1 g, which is the
    second term of the objective. Its derivatives neglect the change of J.
    """
    log_rest, slopes = networks.decode_log(z, aim.features)
    rest, numbers = np.exp(log_rest), z[networks.arch.lobe :]
    f, size = aim.top + rest, len(numbers)
    log_slopes = (slopes * (rest / (f + DARK_OFFSET))[:, None]).astype(np.float64)  # dl/dz, (N, R)
    probed, slopes = rest[: aim.probes], slopes[: aim.probes]
    outward = (slopes * (probed / (probed + OFFSET))[:, None]).astype(np.float64)  # dD/dz, (P, R)
    code, inward = (x.astype(np.float64) for x in networks.encode_log(log_values(probed)))
    variance = inward @ inward.T
    mean = max(np.trace(variance) / size, 1e-12)  # 0 of an encoder that gives the same code always
    variance += LEAST_VARIANCE * mean * np.eye(size)
    gap, error = numbers - code, (np.log(f + DARK_OFFSET) - aim.logs).astype(np.float64)
    losses, far = huber_loss(error, HUBER_KNEE)
    loss = aim.weights @ losses
    weighted = log_slopes.T * (aim.weights / far)
    gap_slope = np.eye(size) - inward @ outward
    whitened = np.linalg.solve(variance, np.column_stack([gap, gap_slope]))
    hold /= aim.probes
    return FitState(
        z,
        float(loss + hold * gap @ whitened[:, 0]),
        weighted @ error + hold * gap_slope.T @ whitened[:, 0],
        weighted @ log_slopes + hold * gap_slope.T @ whitened[:, 1:],
    )


def refined_slopes(networks: UrushiNetworks, f: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return the derivatives (R, P) of a refined anchor z (L,) by the values f (P,) [1/sr].

    The R numbers follow the lobe's numbers. The theorem of implicit functions gives their
    derivatives by the rest of f: the slope of the objective remains zero.
    """
    aim = fit_target(networks, f, None, z[: networks.arch.lobe])
    log_rest, slopes = networks.decode_log(z, aim.features)
    rest = np.exp(log_rest)
    decoded = aim.top + rest + DARK_OFFSET
    _, far = huber_loss(np.log(decoded) - aim.logs, HUBER_KNEE)
    pull = slopes.T * (rest / decoded * aim.weights / far / (f + DARK_OFFSET))
    return np.linalg.solve(state_at(networks, z, aim, ANCHOR_HOLD).curvature, pull)
