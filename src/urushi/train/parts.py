"""What a data store's parts are to a training: how many coats are layered, and on which values."""

import numpy as np

from urushi.data.distribution import COAT_PARAMETERS
from urushi.data.spec import Part
from urushi.nets.architecture import Architecture
from urushi.nets.probes import PROBES, probe_pairs
from urushi.reference import evaluate

#: The direction sets of parts to train on.
TRAINING = ("training", "grazing", "probed")

#: Those to validate on, and the metric that is taken there.
METRICS = {"cosine": "E mean", "half_angle": "P median"}


def depth(part: Part) -> int:
    """How many coats are layered to make the stacks of a training part.

    Stacks whose own values at the probe pairs are known are encoded as they are.
    """
    return 0 if part.directions == "probed" else part.distribution.coats


def trained_pairs(part: Part) -> slice:
    """Which of its direction pairs a training part is trained on."""
    return slice(PROBES if part.directions == "probed" else 0, part.pairs)


def bottom_values(part: Part, bottom: np.ndarray, arch: Architecture) -> np.ndarray:
    """Values (S, probes) [1/sr] of a part's bottoms (S, K), in air, at the probe pairs: exact."""
    names = evaluate.BOTTOM_KINDS[part.distribution.bottom][1]
    wi, wo = probe_pairs(arch.probes)
    count = len(bottom)
    values = evaluate.rows(
        part.distribution.bottom,
        dict(zip(names, bottom.T, strict=True)),
        np.repeat(np.arange(count, dtype=np.uint32), arch.probes),
        np.tile(wi, (count, 1)),
        np.tile(wo, (count, 1)),
    )
    return values.reshape(count, arch.probes)


def coats_to_layer(part: Part, arrays: dict[str, np.ndarray]) -> np.ndarray:
    """The coats (S, N, 5) of a part's stacks that are layered, top to bottom; see `depth`."""
    if depth(part) == 0:
        return np.zeros((len(arrays["bottom"]), 0, len(COAT_PARAMETERS)), np.float32)
    return arrays["coats"]
