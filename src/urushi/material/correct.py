"""Correction: two steps of Gauss and Newton that follow the encoder's pass.

They take off a third to a half of what the encoder misses. A code that is corrected is beside
those that the encoder makes, so that coats lie over the encoder's own, the anchor (`refine` says
why, and does all of this with more patience).
"""

import numpy as np

from urushi.material.cores import one_thread
from urushi.material.refine import huber, probe_features
from urushi.material.starts import UNSEEN
from urushi.nets.networks import Networks, OnePass

#: Steps, and their damping relative to the mean curvature (Marquardt 1963).
STEPS, DAMPING = 2, 1e-3

#: The probe pairs that the steps look at, and the others; all of them judge the result.
SEEN, OTHERS = slice(0, None, 2), slice(1, None, 2)


def corrected(networks: Networks, z: np.ndarray, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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
    decoder = networks.one_pass
    if decoder is None:
        return z, np.full(len(z), np.inf)
    with one_thread():
        return closer(decoder, z, f, DAMPING)


def closer(
    decoder: OnePass, z: np.ndarray, f: np.ndarray, damping: float
) -> tuple[np.ndarray, np.ndarray]:
    """`corrected` codes z (C, L), on this thread: damping as above."""
    features = probe_features(decoder)
    logs = np.log(f + UNSEEN)

    def errors(codes: np.ndarray, rows: np.ndarray, pairs: slice = slice(None)) -> np.ndarray:
        f_hat = decoder.decode(codes[:, None], features[pairs])
        return np.log(f_hat + UNSEEN) - logs[rows, pairs]

    rows = np.arange(len(z))
    steps, known = _steps(decoder, z, features[SEEN], logs[:, SEEN], damping)
    before = np.concatenate([known, errors(z, rows, OTHERS)], axis=-1)
    best, least = np.array(z), huber(before)[0].sum(axis=-1)
    for tried in reversed(steps):  # the last one is hardly ever worse than what was encoded
        loss = huber(errors(tried[rows], rows))[0].sum(axis=-1)
        better = loss < least[rows]  # false for NaN
        best[rows[better]] = tried[rows[better]]
        rows = rows[~better]
        if not len(rows):
            break
    return best, np.exp(before.max(axis=-1))


def _steps(
    decoder: OnePass, z: np.ndarray, features: np.ndarray, logs: np.ndarray, damping: float
) -> tuple[list[np.ndarray], np.ndarray]:
    """Codes (C, L) after each step towards logarithms (C, P), at pairs of features (P, 8).

    And the errors (C, P) before the first one.
    """
    codes, errors = [z], []
    for _ in range(STEPS):
        log_f, slopes = decoder.decode_log(codes[-1][:, None], features)
        f_hat = np.exp(log_f)
        errors.append(np.log(f_hat + UNSEEN) - logs)
        slopes *= (f_hat / (f_hat + UNSEEN))[..., None]
        codes.append(_step(codes[-1], errors[-1], slopes, damping))
    return codes[1:], errors[0]


def _step(z: np.ndarray, error: np.ndarray, slopes: np.ndarray, damping: float) -> np.ndarray:
    """Codes (C, L) one step from z, by errors (C, P) and their derivatives (C, P, L)."""
    _, far = huber(error)
    weighted = np.swapaxes(slopes / far[..., None], -1, -2)
    curvature = (weighted @ slopes).astype(np.float64)
    mean = np.trace(curvature, axis1=-2, axis2=-1) / z.shape[-1]
    curvature += (damping * mean + 1e-12)[:, None, None] * np.eye(z.shape[-1])
    step = np.linalg.solve(curvature, (weighted @ error[..., None]).astype(np.float64))
    return (z - step[..., 0]).astype(np.float32)
