"""Blends of two materials."""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from urushi.errors import ParameterError
from urushi.material import energy
from urushi.material.blend import blend_codes
from urushi.material.encode import encode
from urushi.material.material import Material
from urushi.material.table import SHAPE, node_pairs, table_of_values
from urushi.nets.weights import Model, anisotropic_model, default_model


def lerp(a: Material, b: Material, t: npt.ArrayLike) -> Material:
    """Return the material between a and b.

    The albedo is about linear in t, see `urushi.material.blend`; energy is conserved.

    t: in [0, 1], a scalar or one number per RGB channel. A material of one channel blends with one
    of three. t = 0 gives exactly a's codes, t = 1 exactly b's. If a or b has a table, the result
    has one too, of (1 - t) a's f + t b's.

    An isotropic material of the shipped networks is encoded again to blend with an anisotropic one.

    Raises:
        ParameterError: a and b belong to different networks, have different numbers of channels, or
            are rotated by different angles, or t is out of range or of a wrong shape.
    """
    for name, material in (("a", a), ("b", b)):
        if not isinstance(material, Material):
            raise ParameterError(
                f"lerp's {name} is a {type(material).__name__}; encode it into a Material first"
            )
    if {a.model.fingerprint, b.model.fingerprint} == {
        default_model().fingerprint,
        anisotropic_model().fingerprint,
    }:
        a, b = (encode(material, anisotropic_model()) for material in (a, b))
        a, b = (replace(x, rotation=a.rotation or b.rotation) for x in (a, b))
    if a.model.fingerprint != b.model.fingerprint:
        raise ParameterError(
            f"the materials belong to different weights, {a.model.fingerprint} and "
            f"{b.model.fingerprint}; encode both with the same weights"
        )
    if a.rotation != b.rotation:
        raise ParameterError(
            f"the materials are rotated by {a.rotation:g} and {b.rotation:g} degrees, but a blend "
            "has one tangent; blend them before they are rotated"
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
    share = np.broadcast_to(share, channels)
    latents = _blend(a.model, a.latents, b.latents, share)
    anchors = latents
    if a.anchors is not a.latents or b.anchors is not b.latents:
        anchors = _blend(a.model, a.anchors, b.anchors, share)
    table, beside_lobe = _blended_table(a, b, share)
    return Material(latents, a.model, anchors, table, a.rotation, beside_lobe)


def _blended_table(a: Material, b: Material, share: np.ndarray) -> tuple[np.ndarray | None, bool]:
    """The table of the blend with shares (C,) of b, and whether it leaves the lobe out.

    There is none if a and b have none where they count. Two lobes are no lobe: they are in the
    table.
    """
    if (share == 0).all() or (share == 1).all():
        end = b if share.any() else a
        if end.table is None:
            return None, False
        return np.broadcast_to(end.table, (*SHAPE, len(share))), end.beside_lobe
    if a.table is None and b.table is None:
        return None, False
    of_a, of_b = (material.f(*node_pairs()) for material in (a, b))
    return table_of_values((1 - share) * of_a + share * of_b), False


def _blend(model: Model, a: np.ndarray, b: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Codes (C, L) between a and b, exactly these for shares (C,) of 0 and 1.

    Their directional albedo is at most 1, or that of the brighter one if it gains energy.
    """
    shape = (len(share), a.shape[1])
    a, b = np.broadcast_to(a, shape), np.broadcast_to(b, shape)
    codes = blend_codes(model, a, b, share)
    peaks = [energy.directional_albedos(model, z).max(axis=-1) for z in (a, b)]
    ceiling = np.maximum(np.maximum(*peaks), 1 - energy.MARGIN)
    codes = energy.limit_albedo(model, codes, ceiling[:, None])
    return np.where((share == 0)[:, None], a, np.where((share == 1)[:, None], b, codes))
