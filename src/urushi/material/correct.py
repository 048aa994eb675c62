"""Correction: two steps of Gauss and Newton that follow the encoder's pass.

They take off a third to a half of what the encoder misses. A code that is corrected is beside
those that the encoder makes, so that coats lie over the encoder's own, the anchor (`refine` says
why, and does all of this with more patience).
"""

import numpy as np

from urushi.material.cores import one_thread
from urushi.material.refine import huber, probe_features
from urushi.material.starts import UNSEEN
from urushi.nets.networks import Networks

#: Steps, and their damping relative to the mean curvature (Marquardt 1963).
STEPS, DAMPING = 2, 1e-3


def corrected(networks: Networks, z: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Return codes float32 (C, L) that decode to values f (C, P) [1/sr] at `networks.pairs`.

    Closer than z (C, L), what the encoder makes of them, or as close. Codes of networks that
    encode by an optimisation are left as they are.
    """
    decoder = networks.one_pass
    if decoder is None:
        return z
    features = probe_features(decoder)
    logs = np.log(f + UNSEEN)
    least = np.full(len(z), np.inf)
    tried, best = z, z
    with one_thread():
        for _ in range(STEPS):
            log_f, slopes = decoder.decode_log(tried[:, None], features)
            f_hat = np.exp(log_f)
            error = np.log(f_hat + UNSEEN) - logs
            best, least = _better(best, least, tried, error)
            tried = _step(tried, error, slopes * (f_hat / (f_hat + UNSEEN))[..., None])
        error = np.log(decoder.decode(tried[:, None], features) + UNSEEN) - logs
    return _better(best, least, tried, error)[0]


def _step(z: np.ndarray, error: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Codes (C, L) one step from z, by errors (C, P) and their derivatives (C, P, L)."""
    _, far = huber(error)
    weighted = np.swapaxes(slopes / far[..., None], -1, -2)
    curvature = (weighted @ slopes).astype(np.float64)
    mean = np.trace(curvature, axis1=-2, axis2=-1) / z.shape[-1]
    curvature += (DAMPING * mean + 1e-12)[:, None, None] * np.eye(z.shape[-1])
    step = np.linalg.solve(curvature, (weighted @ error[..., None]).astype(np.float64))
    return (z - step[..., 0]).astype(np.float32)


def _better(
    best: np.ndarray, least: np.ndarray, tried: np.ndarray, error: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The better of two sets of codes (C, L), one by one, and their losses (C,)."""
    loss = huber(error)[0].sum(axis=-1)
    better = loss < least  # false for NaN
    return np.where(better[:, None], tried, best), np.where(better, loss, least)
