"""What a data store's parts are to a training: how many coats are layered, and on which values."""

import numpy as np

from urushi.data.spec import Part
from urushi.nets.architecture import Architecture
from urushi.nets.features import coat_features
from urushi.nets.probes import PROBES, probe_pairs
from urushi.reference import evaluate

#: The direction sets of parts to train on.
TRAINING = ("training", "probed")


def depth(part: Part) -> int:
    """How many coats are layered to make the stacks of a training part.

    Stacks whose own values at the probe pairs are known are encoded as they are.
    """
    return 0 if part.directions == "probed" else part.distribution.coats


def trained_pairs(part: Part) -> slice:
    """Which of its direction pairs a training part is trained on."""
    return slice(PROBES if part.directions == "probed" else 0, part.pairs)


def no_coats(stacks: int) -> np.ndarray:
    """The coat features (S, 0, COAT_FEATURES) of stacks that are only encoded."""
    nothing = np.zeros((stacks, 0), np.float32)
    return coat_features(*(nothing,) * 5)


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


def coat_inputs(part: Part, arrays: dict[str, np.ndarray]) -> np.ndarray:
    """Coat features (S, N, COAT_FEATURES) of a part's arrays."""
    if part.distribution.coats == 0:
        return no_coats(len(arrays["bottom"]))
    return coat_features(*np.moveaxis(arrays["coats"], -1, 0)).astype(np.float32)
