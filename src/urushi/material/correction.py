"""Correction of the encoder's codes: two damped steps of Gauss and Newton.

They remove a third to a half of the encoder's error. They keep the lobe of a code
(`urushi.nets.lobe`) and change the other numbers; errors are those of the whole f. A corrected code
is not one that the encoder makes, and the layering network knows only those. So a material keeps
the encoder's code as its anchor, over which coats are layered.
"""

import numpy as np

from urushi.core.error_metrics import DARK_OFFSET, huber_loss
from urushi.material.fit import HUBER_KNEE, probe_features, stepped
from urushi.nets.least_squares import damped_step
from urushi.nets.networks import UrushiNetworks
from urushi.parallel import one_blas_thread

#: Number of correction steps, and their damping relative to the mean curvature (Marquardt 1963).
CORRECTION_STEPS, CORRECTION_DAMPING = 2, 1e-3

#: Probe pairs that the correction fits, and the others; a result is accepted by its error at both.
FITTED_PAIRS, CHECKED_PAIRS = slice(0, None, 2), slice(1, None, 2)


def correct_codes(networks: UrushiNetworks, z: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Return corrected codes.

    Args:
        networks: the networks.
        z: (C, L) the encoder's codes of f.
        f: (C, P) values [1/sr] at `networks.pairs`.

    Returns:
        Codes float32 (C, L) whose error is at most that of z.
    """
    with one_blas_thread():
        return _corrected(networks, z, f)


def _corrected(decoder: UrushiNetworks, z: np.ndarray, f: np.ndarray) -> np.ndarray:
    features = probe_features(decoder)
    logs = np.log(f + DARK_OFFSET)
    top = np.broadcast_to(decoder.top(z[:, None], *decoder.pairs()), f.shape)

    def errors(codes: np.ndarray, rows: np.ndarray, pairs: slice = slice(None)) -> np.ndarray:
        f_hat = top[rows, pairs] + decoder.rest(codes[:, None], features[pairs])
        return np.log(f_hat + DARK_OFFSET) - logs[rows, pairs]

    rows = np.arange(len(z))
    steps, fitted_errors = _correction_steps(
        decoder,
        z,
        features[FITTED_PAIRS],
        top[:, FITTED_PAIRS],
        logs[:, FITTED_PAIRS],
    )
    before = np.concatenate([fitted_errors, errors(z, rows, CHECKED_PAIRS)], axis=-1)
    best, least = np.array(z), huber_loss(before, HUBER_KNEE)[0].sum(axis=-1)
    for tried in reversed(steps):  # the last step is rarely worse than the encoder
        loss = huber_loss(errors(tried[rows], rows), HUBER_KNEE)[0].sum(axis=-1)
        better = loss < least[rows]  # false for NaN
        best[rows[better]] = tried[rows[better]]
        rows = rows[~better]
        if not len(rows):
            break
    return best


def _correction_steps(
    decoder: UrushiNetworks,
    z: np.ndarray,
    features: np.ndarray,
    top: np.ndarray,
    logs: np.ndarray,
) -> tuple[list[np.ndarray], np.ndarray]:
    """Codes (C, L) after each step, and the errors (C, P) before the first one.

    features: (P, 8) of the pairs; top: (C, P) the lobes' values; logs: (C, P) the target values of
    ln(f + `DARK_OFFSET`).
    """
    codes, errors = [z], []
    for _ in range(CORRECTION_STEPS):
        log_rest, slopes = decoder.decode_log(codes[-1][:, None], features)
        rest = np.exp(log_rest)
        f_hat = top + rest
        errors.append(np.log(f_hat + DARK_OFFSET) - logs)
        slopes *= (rest / (f_hat + DARK_OFFSET))[..., None]
        step = _correction_step(errors[-1], slopes)
        codes.append(stepped(codes[-1], step))
    return codes[1:], errors[0]


def _correction_step(error: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """The step (C, R) that is subtracted, from errors (C, P) and their derivatives (C, P, R)."""
    _, far = huber_loss(error, HUBER_KNEE)
    weighted = np.swapaxes(slopes / far[..., None], -1, -2)
    curvature = (weighted @ slopes).astype(np.float64)
    slope = (weighted @ error[..., None]).astype(np.float64)[..., 0]
    return damped_step(curvature, slope, CORRECTION_DAMPING)
