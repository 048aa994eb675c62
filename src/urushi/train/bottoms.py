"""The bottoms of training stacks as the encoder sees them: one lobe, and the values of the rest."""

import numpy as np

from urushi.geometry.probe_pairs import probe_pairs
from urushi.nets import lobe as lobes
from urushi.nets.lobe_fit import fit_lobes
from urushi.reference import analytic

#: Kinds of bottoms that are one lobe and nothing else.
BARE_LOBES = ("conductor", "conductor_complex", "dielectric")


def bottom_lobes(kind: str, bottom: np.ndarray, probes: int) -> np.ndarray:
    """Lobes (S, 6) of bottoms with the parameters (S, K), in the order of their kind.

    Those of mixtures and of measured-like bottoms are fitted to their values, as `encode` does.
    """
    columns = dict(zip(analytic.BOTTOM_KINDS[kind][1], bottom.T, strict=True))
    result = np.tile(np.array(lobes.NO_LOBE, np.float32), (len(bottom), 1))
    if kind == "conductor":
        result[:, :3] = np.stack([columns["alpha"], columns["r0"], np.ones(len(bottom))], axis=-1)
    elif kind in BARE_LOBES:
        k = columns.get("k", np.zeros(len(bottom)))
        result[:, 0] = columns["alpha"]
        result[:, 3:] = np.stack([np.ones(len(bottom)), columns["eta"], k], axis=-1)
    elif kind != "diffuse":
        result = fit_lobes(_values(kind, bottom, probes))
    return result


def bottom_rest(kind: str, bottom: np.ndarray, own: np.ndarray, probes: int) -> np.ndarray:
    """Values (S, probes) [1/sr] of bottoms in air at the probe pairs, less those of their lobes."""
    if kind in BARE_LOBES:
        return np.zeros((len(bottom), probes), np.float32)
    top = lobes.f(own[:, None], *probe_pairs(probes))
    return np.maximum(_values(kind, bottom, probes) - top, 0.0)


def _values(kind: str, bottom: np.ndarray, probes: int) -> np.ndarray:
    """Values (S, probes) [1/sr] of bottoms in air at the probe pairs."""
    names = analytic.BOTTOM_KINDS[kind][1]
    count = len(bottom)
    wi, wo = (np.tile(w, (count, 1)) for w in probe_pairs(probes))
    row = np.repeat(np.arange(count, dtype=np.uint32), probes)
    columns = dict(zip(names, bottom.T, strict=True))
    return analytic.rows(kind, columns, row, wi, wo).reshape(count, probes)
