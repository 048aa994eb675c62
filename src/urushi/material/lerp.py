"""Blends of two materials: f of a blend is the weighted mean of both f.

One lobe of each channel remains analytic, the one with the brighter peak. All else, the other lobe
too, is the rest of the blend: a table, or a code for two widths.
"""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.core.microfacet import product
from urushi.core.table import node_pairs
from urushi.errors import ParameterError
from urushi.material.albedo_rule import albedo_rule
from urushi.material.encode import encode
from urushi.material.energy import albedo_bounds, code_albedos, nearest_within
from urushi.material.material import Material
from urushi.nets import lobe as lobes
from urushi.nets.transmittance import table_beside
from urushi.nets.weights import anisotropic_model, default_model


def lerp(a: Material, b: Material, t: npt.ArrayLike) -> Material:
    """Return the material between a and b.

    f is linear in t, up to the error of a table or of a code.

    t: in [0, 1], a scalar or one number per RGB channel. A material of one channel blends with one
    of three. t = 0 gives exactly a's codes, t = 1 exactly b's. If a or b has a table, the result
    has one too, of (1 - t) a's f + t b's.

    An isotropic material of the shipped weights is encoded again to blend with an anisotropic one.

    Raises:
        ParameterError: a and b belong to different weights, have different numbers of channels, or
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
    share = checks.share(t, "lerp's t", any_shape=True).astype(np.float32)
    try:
        (channels,) = np.broadcast_shapes((a.channels,), (b.channels,), share.shape)
    except ValueError as error:
        raise ParameterError(
            f"lerp's t does not fit materials of {a.channels} and {b.channels} "
            "channels; give a number or one per channel"
        ) from error
    share = np.broadcast_to(share, channels)
    a, b = (_grown(material, channels) for material in (a, b))
    if (share == 0).all() or (share == 1).all():
        return b if share.any() else a
    blend = _blend(replace(a, rotation=0.0), replace(b, rotation=0.0), share)
    return replace(blend, rotation=a.rotation)


def _blend(a: Material, b: Material, share: np.ndarray) -> Material:
    """The blend with shares (C,) of b."""
    model, size = a.model, a.model.arch.lobe
    none = np.tile(lobes.no_lobe(model.widths), (len(share), 1))
    first, second = (
        m.latents[:, :size] if m.table is None or m.beside_lobe else none for m in (a, b)
    )
    lobe = brighter_lobes(first, second, share)

    def f(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return (1 - share) * a.f(wi, wo) + share * b.f(wi, wo)

    at = share[:, None]
    own = (1 - at) * code_albedos(model, a.latents) + at * code_albedos(model, b.latents)
    codes = model.networks.encode(f(*model.networks.pairs()).T, lobe)
    codes = nearest_within(model, codes, *albedo_bounds(own, albedo_rule(model.widths)))
    codes = np.where(at == 0, a.latents, np.where(at == 1, b.latents, codes))
    if model.widths == 2:
        return Material(codes, model)
    table = table_beside(f(*node_pairs()), codes[:, :size])
    return Material(codes, model, table, beside_lobe=True)


def _grown(material: Material, channels: int) -> Material:
    """A material of one channel as one of several."""
    if material.channels == channels:
        return material
    latents, table = np.repeat(material.latents, channels, axis=0), material.table
    table = None if table is None else np.repeat(table, channels, axis=-1)
    return replace(material, latents=latents, table=table, coating=None)


def brighter_lobes(a: np.ndarray, b: np.ndarray, share: np.ndarray) -> np.ndarray:
    """The parts of blends that remain analytic: lobes (C, N) of a or b (C, N), scaled.

    share: (C,) of b. Where both have the same shape and index, their sum remains.
    """
    columns = share[:, None].astype(np.float32)
    scaled = np.array([a, b])
    scaled[..., 1:4] *= np.stack([1 - columns, columns])
    peaks = [lobes.reflectance(x, 1.0) / product(lobes.width(x)) for x in scaled]
    shape = np.delete(np.arange(a.shape[1]), [1, 2, 3])
    same = (a[:, shape] == b[:, shape]).all(axis=1)
    total = np.array(a)
    total[:, 1:4] = scaled[0][:, 1:4] + scaled[1][:, 1:4]
    brighter = np.where((peaks[0] >= peaks[1])[:, None], *scaled)
    return np.where(same[:, None], total, brighter)
