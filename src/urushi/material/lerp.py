"""Blends of two materials, whose reflected light is linear in the blend weight.

f of a blend is the weighted mean of both f: a table of it, or a code of its values at the probe
pairs. The Fresnel factors of the lobes (`urushi.nets.lobe`) are blended linearly. Their widths are
weighted by the light that each lobe reflects, because the width of a lobe that reflects nothing is
meaningless. Indices are weighted by the light of the exact Fresnel term; its factor is then set so
that its light is the linear blend of the two.
"""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from urushi.core.table import SHAPE, node_pairs, table_of_values
from urushi.errors import ParameterError
from urushi.material import energy
from urushi.material.encode import encode
from urushi.material.material import Material
from urushi.nets import lobe as lobes
from urushi.nets.weights import Model, anisotropic_model, default_model

#: Cosines over which the reflectance of a lobe is averaged.
COSINES = np.array([1.0, 0.8, 0.6, 0.4, 0.2])


def lerp(a: Material, b: Material, t: npt.ArrayLike) -> Material:
    """Return the material between a and b.

    The albedo is about linear in t, see the module; energy is conserved.

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
    table, beside_lobe = _blended_table(a, b, share)
    return Material(latents, a.model, table, a.rotation, beside_lobe)


def _blended_table(a: Material, b: Material, share: np.ndarray) -> tuple[np.ndarray | None, bool]:
    """The table of the blend with shares (C,) of b, and whether it leaves the lobe out.

    None for two widths. A sum of two lobes is not one lobe, so that the table contains both.
    """
    if (share == 0).all() or (share == 1).all():
        end = b if share.any() else a
        if end.table is None:
            return None, False
        return np.broadcast_to(end.table, (*SHAPE, len(share))), end.beside_lobe
    if a.model.widths == 2:
        return None, False
    of_a, of_b = (material.f(*node_pairs()) for material in (a, b))
    return table_of_values((1 - share) * of_a + share * of_b), False


def _blend(model: Model, a: np.ndarray, b: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Codes (C, L) between a and b, exactly these for shares (C,) of 0 and 1.

    Their directional albedo is at most 1, or the brighter one's albedo if this gains energy.
    """
    shape = (len(share), a.shape[1])
    a, b = np.broadcast_to(a, shape), np.broadcast_to(b, shape)
    codes = blend_codes(model, a, b, share)
    peaks = [energy.directional_albedos(model, z).max(axis=-1) for z in (a, b)]
    ceiling = np.maximum(np.maximum(*peaks), 1 - energy.MARGIN)
    codes = energy.limit_albedo(model, codes, ceiling[:, None])
    return np.where((share == 0)[:, None], a, np.where((share == 1)[:, None], b, codes))


def blend_codes(model: Model, a: np.ndarray, b: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Codes (C, L) between a and b (C, L); share: (C,) of b, in [0, 1]."""
    networks, count = model.networks, model.arch.lobe
    pairs, weight = networks.pairs(), share[:, None]
    f = (1 - weight) * networks.f(a[:, None], *pairs) + weight * networks.f(b[:, None], *pairs)
    return networks.encode(f, blend_lobes(a[:, :count], b[:, :count], share))


def blend_lobes(a: np.ndarray, b: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Lobes (C, N) between a and b (C, N); share: (C,) of b, in [0, 1]."""
    light = [lobes.reflectance(lobe[:, None], COSINES).mean(axis=-1) for lobe in (a, b)]
    exact = [_exact_reflectance(lobe) for lobe in (a, b)]
    of_width = _share_of_b(light[0], light[1], share)
    of_index = _share_of_b(a[:, 3] * exact[0], b[:, 3] * exact[1], share)
    others = [of_width] * (a.shape[-1] - len(lobes.LOBE_NUMBERS))
    shares = np.stack([of_width, *[share] * 3, of_index, of_index, *others], axis=-1)
    blend = (1.0 - shares) * a + shares * b
    own = np.maximum(_exact_reflectance(blend), 1e-30)
    factor = (1.0 - share) * a[:, 3] * (exact[0] / own) + share * b[:, 3] * (exact[1] / own)
    # Never more than the linear blend, so that no light is gained at grazing angles.
    blend[:, 3] = np.minimum(blend[:, 3], factor)
    return blend


def _exact_reflectance(lobe: np.ndarray) -> np.ndarray:
    """Mean (C,) over the cosines of the exact Fresnel term of lobes (C, N), for a factor of one."""
    return lobes.fresnel(COSINES, lobe[:, None, 4], lobe[:, None, 5]).mean(axis=-1)


def _share_of_b(size_a: np.ndarray, size_b: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Shares (C,) of b in proportion to sizes (C,); `share` itself where both sizes are zero."""
    total = (1.0 - share) * size_a + share * size_b
    return np.where(total > 0, share * size_b / np.maximum(total, 1e-30), share)
