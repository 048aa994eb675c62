"""Blending materials linearly in the latent space."""

import numpy as np
import numpy.typing as npt

from urushi.errors import ParameterError
from urushi.material.material import Material


def lerp(a: Material, b: Material, t: npt.ArrayLike) -> Material:
    """Return the material of codes (1 - t) a + t b.

    t: in [0, 1], a scalar or one number per RGB channel. A material of one channel blends with one
    of three. t = 0 gives exactly a's codes, t = 1 exactly b's.

    Raises:
        ParameterError: a and b belong to different networks or numbers of channels, or t is out
            of range or of a wrong shape.
    """
    for name, material in (("a", a), ("b", b)):
        if not isinstance(material, Material):
            raise ParameterError(
                f"lerp's {name} is a {type(material).__name__}; encode it into a Material first"
            )
    if a.model.fingerprint != b.model.fingerprint:
        raise ParameterError(
            f"the materials belong to different weights, {a.model.fingerprint} and "
            f"{b.model.fingerprint}; encode both with the same model"
        )
    try:
        share = np.asarray(t, np.float32)
        channels = np.broadcast_shapes((a.channels,), (b.channels,), share.shape)
    except (TypeError, ValueError) as error:
        raise ParameterError(
            f"lerp's t ({np.shape(t)}) does not fit materials of {a.channels} and {b.channels} "
            "channels; give a number or one per channel"
        ) from error
    if share.ndim > 1 or not ((share >= 0.0) & (share <= 1.0)).all():
        raise ParameterError("lerp's t must be in [0, 1], a number or one per channel")
    share = np.broadcast_to(share, channels)[:, None]
    latents, anchors = (
        (1.0 - share) * first + share * second
        for first, second in ((a.latents, b.latents), (a.anchors, b.anchors))
    )
    return Material(latents, a.model, anchors)
