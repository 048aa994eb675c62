"""The bottoms of training stacks as the encoder sees them: one lobe, and the values of the rest."""

import numpy as np

from urushi.geometry.probe_pairs import probe_pairs
from urushi.nets import lobe as lobes
from urushi.reference import analytic

#: Kinds of bottoms that are one lobe and nothing else.
BARE_LOBES = ("conductor", "conductor_complex", "dielectric")


def bottom_lobes(kind: str, bottom: np.ndarray, probes: int) -> np.ndarray:
    """Lobes (S, 6) of bottoms with the parameters (S, K), in the order of their kind."""
    columns = dict(zip(analytic.BOTTOM_KINDS[kind][1], bottom.T, strict=True))
    result = np.tile(np.float32(lobes.NO_LOBE), (len(bottom), 1))
    if kind == "conductor":
        result[:, :3] = np.stack([columns["alpha"], columns["r0"], np.ones(len(bottom))], axis=-1)
    elif kind in BARE_LOBES:
        k = columns.get("k", np.zeros(len(bottom)))
        result[:, 0] = columns["alpha"]
        result[:, 3:] = np.stack([np.ones(len(bottom)), columns["eta"], k], axis=-1)
    elif kind == "mixture":
        weight, r0 = columns["ggx_weight"], columns["ggx_r0"]
        result[:, :3] = np.stack([columns["ggx_alpha"], weight * r0, weight], axis=-1)
    return result


def bottom_rest(kind: str, bottom: np.ndarray, own: np.ndarray, probes: int) -> np.ndarray:
    """Values (S, probes) [1/sr] of bottoms in air at the probe pairs, less those of their lobes."""
    if kind in BARE_LOBES:
        return np.zeros((len(bottom), probes), np.float32)
    names = analytic.BOTTOM_KINDS[kind][1]
    wi, wo = probe_pairs(probes)
    count = len(bottom)
    values = analytic.rows(
        kind,
        dict(zip(names, bottom.T, strict=True)),
        np.repeat(np.arange(count, dtype=np.uint32), probes),
        np.tile(wi, (count, 1)),
        np.tile(wo, (count, 1)),
    )
    return np.maximum(values.reshape(count, probes) - lobes.f(own[:, None], wi, wo), 0.0)
