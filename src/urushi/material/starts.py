"""Codes from which a refinement may start: the encoder's, and those of plain surfaces.

A BRDF unlike all that the encoder was trained on may get a code that is far off, from which no step
leads back; one of a rough conductor or a diffuse surface is then nearer.
"""

import functools

import numpy as np

from urushi.nets.networks import OnePass
from urushi.reference.stack import conductor, diffuse

#: Widths of the conductors, and what share of white is added to each.
ALPHAS, SHARES = (0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0), (0.0, 0.02, 0.2)

#: Added to f [1/sr] before logarithms are compared, as in the error P: values far below it are
#: black to the eye, and measured colours outside of sRGB have channels that are zero.
UNSEEN = 1e-3


def nearest(networks: OnePass, f: np.ndarray) -> np.ndarray:
    """The code float32 (L,) of these that decodes to what is closest to values f (P,) [1/sr].

    Codes of plain surfaces are brought to the values' brightness. Closest is the least mean
    difference of logarithms.
    """
    pairs = networks.pairs()
    plain = networks.encode(_plain(networks))
    logs = np.log(f + UNSEEN)
    gains = np.median(logs - np.log(networks.f(plain[:, None], *pairs) + UNSEEN), axis=-1)
    codes = np.concatenate([networks.encode(f[None]), networks.scaled(plain, np.exp(gains))])
    errors = np.abs(np.log(networks.f(codes[:, None], *pairs) + UNSEEN) - logs).mean(axis=-1)
    return codes[errors.argmin()].astype(np.float32)


def _plain(networks: OnePass) -> np.ndarray:
    """Values float32 (M, P) of plain surfaces at the networks' pairs."""
    wi, wo = networks.pairs()
    return _values(np.asarray(wi).tobytes(), np.asarray(wo).tobytes())


@functools.lru_cache(4)
def _values(wi: bytes, wo: bytes) -> np.ndarray:
    from urushi.reference import evaluate  # lazily: it starts Dr.Jit

    pairs = [np.frombuffer(w, np.float32).reshape(-1, 3) for w in (wi, wo)]
    white = evaluate.f(diffuse(1.0), *pairs)[:, 0]
    lobes = [evaluate.f(conductor(alpha, 0.9), *pairs)[:, 0] for alpha in ALPHAS]
    return np.stack([white] + [lobe + share * white for lobe in lobes for share in SHARES])
