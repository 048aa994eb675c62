"""Gradients through layering: latent codes that remember what they come from.

Where a parameter of a coat or of its bottom carries a gradient, `bake` does what `baking.bake` does
and attaches the codes to the parameters. The bottom's values at the probe pairs are differentiated
by Dr.Jit, encoder and layerer by `operations`.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.material import gradients
from urushi.nets.weights import Model
from urushi.render import baking, operations, probing, spectrum
from urushi.render.attached import AttachedLatents, AttachedTexture
from urushi.render.operations import Columns
from urushi.render.parameters import CoatParameters


def wanted(bsdf: "mi.BSDF") -> bool:
    """Whether a parameter anywhere in a BSDF carries a gradient; codes are none."""
    parameters = mi.traverse(bsdf)
    flags, read_only = parameters.flags, mi.ParamFlags.ReadOnly
    return any(dr.grad_enabled(value) for key, value in parameters if not flags(key) & read_only)


def bake(
    model: Model, coat: CoatParameters, bottom: "mi.BSDF", resolution: int
) -> AttachedLatents | AttachedTexture:
    """`baking.bake`, with codes attached to the parameters.

    Raises:
        ParameterError: as there, or the networks are the paper's.
    """
    gradients.check(model, coat.where)
    textures = [*coat.varying, *baking.varying_textures(bottom)]
    shape = baking.texture_shape(textures, bottom, resolution)
    width, height = shape or (1, 1)
    uv = baking.texel_centres(width, height)
    table = coat.table(uv) | {"eta": np.full((1, 1), coat.eta)}
    si = probing.interaction(np.tile([0.0, 0.0, 1.0], (len(uv), 1)), uv)
    alpha, *others = coat.evaluate(si, mi.Bool(True))
    parameters = [[alpha], [coat.opaque_eta], *map(spectrum.to_channels, others)]
    z_bottom = _bottom_codes(model, coat.where, bottom, uv, shape)
    codes = operations.layer(model, table, z_bottom, parameters)
    if shape is None:
        return AttachedLatents(model, codes)
    return AttachedTexture(model, mi.TensorXf(codes.array, (height, width, *codes.shape[1:])))


def _bottom_codes(
    model: Model, where: str, bottom: "mi.BSDF", uv: np.ndarray, shape: tuple[int, int] | None
) -> Columns:
    """The bottom's codes at points uv (M, 2), or one code if it is the same everywhere."""
    nested = getattr(bottom, "latents", None)
    known = nested is not None and bottom.model.fingerprint == model.fingerprint
    if known and isinstance(nested, AttachedLatents | AttachedTexture):
        return nested.codes(mi.Point2f(np.ascontiguousarray(uv.T, np.float32)))
    wi, wo = model.networks.pairs()
    if not wanted(bottom) or probing.repeats(bottom, wi, wo, len(uv)) > 1:
        with dr.suspend_grad():  # a random walk's loop cannot be differentiated
            return operations.columns(baking._encoder(model, where, bottom, shape)(uv))
    if shape is None or not baking.varying_textures(bottom):
        parts = [_probed(bottom, wi, wo, np.full((1, 2), 0.5), probing.AZIMUTHS)]
    else:
        starts = range(0, len(uv), baking.PROBED)
        parts = [_probed(bottom, wi, wo, uv[i : i + baking.PROBED], 2) for i in starts]
    return operations.encode(model, where, parts)


def _probed(
    bottom: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, uv: np.ndarray, azimuths: int
) -> list:
    """`probing.symmetric`, attached: of each channel f (M * P) [1/sr] at points uv (M, 2)."""
    everywhere = np.repeat(uv, len(wi), axis=0)
    total = [dr.zeros(mi.Float, len(everywhere))] * spectrum.channel_count()
    for index in range(azimuths):
        a, b = (np.tile(probing.rotated(w, index / azimuths), (len(uv), 1)) for w in (wi, wo))
        for one, other in ((a, b), (b, a)):
            out = mi.Vector3f(np.ascontiguousarray(other.T))
            value = bottom.eval(mi.BSDFContext(), probing.interaction(one, everywhere), out)
            channels = spectrum.to_channels(value / out.z)
            total = [a + b for a, b in zip(total, channels, strict=True)]
    return [value / (2 * azimuths) for value in total]
