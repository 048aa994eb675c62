"""The layerer: maps the latent code of a bottom and a coat to the code of the coated BRDF."""

import functools
from typing import Any

import numpy as np

from urushi.nets.architecture import Architecture
from urushi.nets.features import coat_features
from urushi.nets.lobe import lobe_features, of_coat
from urushi.nets.mlp import Params, hidden_to_output, split_linear

#: Greatest number of bottoms whose features are remembered, enough for one material.
REMEMBERED_BOTTOMS = 16


def layer(params: Params, arch: Architecture, z_bottom: Any, coat: tuple[Any, ...]) -> Any:
    """Return the latent codes (..., L) of bottoms z_bottom (..., L) under coats.

    coat: alpha, eta, albedo, sigma_t, g, arrays that broadcast against each other and against the
    bottoms; alpha is two `Widths` if the networks are anisotropic. The coat's interface becomes the
    lobe of the result. The network computes the change of the other numbers, from these, the
    bottom's lobe and the coat.
    """
    xp = z_bottom.__array_namespace__()
    rest = z_bottom[..., arch.lobe :]
    own = xp.concat([rest, _bottom_features(z_bottom[..., : arch.lobe])], axis=-1)
    first = split_linear(params, "layerer.0", own, coat_features(*coat))
    rest = rest + hidden_to_output(params, "layerer", first, arch.activation)
    top = of_coat(*coat[:2])
    return xp.concat([xp.broadcast_to(top, (*rest.shape[:-1], arch.lobe)), rest], axis=-1)


def _bottom_features(lobe: Any) -> Any:
    """`lobe_features` of lobes (..., N). Features of few lobes are kept, for coats that change."""
    if not isinstance(lobe, np.ndarray) or lobe.size > REMEMBERED_BOTTOMS * lobe.shape[-1]:
        return lobe_features(lobe)
    return _remembered(lobe.tobytes(), lobe.dtype.char, lobe.shape)


@functools.lru_cache(64)
def _remembered(numbers: bytes, kind: str, shape: tuple[int, ...]) -> np.ndarray:
    """`lobe_features` of the numbers of lobes."""
    features = lobe_features(np.frombuffer(numbers, kind).reshape(shape))
    features.flags.writeable = False
    return features
