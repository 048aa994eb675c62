"""Gradients through layering: latent codes that remember what they come from.

Where a parameter of a coat or of its bottom carries a gradient, `bake` does the work of
`baking.Baker` and attaches the codes to the parameters. The bottom's values at the probe pairs are
differentiated by Dr.Jit, encoder and layerer by `operations`.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.material import gradients
from urushi.nets.weights import Model
from urushi.render import spectrum
from urushi.render.codes import operations
from urushi.render.codes.attached import AttachedLatents, AttachedTexture
from urushi.render.codes.baking import choose_grid
from urushi.render.codes.bottom_codes import PROBED, BottomCodes
from urushi.render.codes.operations import Columns
from urushi.render.reading import probing
from urushi.render.reading.grid import IDENTITY, Grid, varying_textures
from urushi.render.reading.parameters import CoatParameters

#: Rotations of an anisotropic bottom, at most: all are traced together.
AZIMUTHS = 15

#: The grid of a bottom that is the same everywhere.
MIDDLE = Grid(1, 1, IDENTITY, "repeat", False)


def wanted(bsdf: "mi.BSDF") -> bool:
    """Whether a parameter anywhere in a BSDF carries a gradient; codes are none."""
    parameters = mi.traverse(bsdf)
    flags, read_only = parameters.flags, mi.ParamFlags.ReadOnly
    return any(dr.grad_enabled(value) for key, value in parameters if not flags(key) & read_only)


def bake(
    model: Model, coat: CoatParameters, bottom: "mi.BSDF", resolution: int
) -> AttachedLatents | AttachedTexture:
    """`baking.Baker.update`, with codes attached to the parameters.

    Raises:
        ParameterError: as there, or the networks are the paper's.
    """
    gradients.check(model, coat.where)
    grid = choose_grid(coat, bottom, model, resolution)
    uv = grid.uv() if grid else np.full((1, 2), 0.5)
    table = coat.table(uv)
    si = probing.interaction(np.tile([0.0, 0.0, 1.0], (len(uv), 1)), uv)
    alpha, eta, *others = coat.evaluate(si, mi.Bool(True))
    parameters = [[alpha], [eta], *map(spectrum.to_channels, others)]
    z_bottom = _bottom_codes(model, coat.where, bottom, uv, grid)
    codes = operations.layer(model, table, z_bottom, parameters)
    if grid is None:
        return AttachedLatents(model, codes)
    shape = grid.height, grid.width, *codes.shape[1:]
    return AttachedTexture(model, mi.TensorXf(codes.array, shape), grid)


def _bottom_codes(
    model: Model, where: str, bottom: "mi.BSDF", uv: np.ndarray, grid: Grid | None
) -> Columns:
    """The bottom's codes at points uv (M, 2), or one code if it is the same everywhere."""
    nested = getattr(bottom, "latents", None)
    known = nested is not None and bottom.model.fingerprint == model.fingerprint
    if known and isinstance(nested, AttachedLatents | AttachedTexture):
        return nested.codes(mi.Point2f(np.ascontiguousarray(uv.T, np.float32)))
    wi, wo = model.networks.pairs()
    if not wanted(bottom) or probing.repeats(bottom, wi, wo, len(uv)) > 1:
        with dr.suspend_grad():  # a random walk's loop cannot be differentiated
            known = BottomCodes(model, bottom, where)
            known.update(grid)
            return operations.columns(known.read(0, len(uv))[1])
    if grid is None or not varying_textures(bottom):
        grid, uv = MIDDLE, MIDDLE.uv()
    with dr.suspend_grad():
        average = probing.needed_average(bottom, wi, wo, grid, where)
    starts = range(0, len(uv), PROBED)
    parts = [_probed(bottom, wi, wo, uv[i : i + PROBED], average) for i in starts]
    return operations.encode(model, where, parts)


def _probed(
    bottom: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, uv: np.ndarray, average: probing.Average
) -> list:
    """`probing.over_points`, attached: of each channel f (M * P) [1/sr] at points uv (M, 2)."""
    azimuths = min(average.azimuths, AZIMUTHS)
    everywhere = np.repeat(uv, len(wi), axis=0)
    total = [dr.zeros(mi.Float, len(everywhere))] * spectrum.channel_count()
    for index in range(azimuths):
        a, b = (np.tile(probing.rotated(w, index / azimuths), (len(uv), 1)) for w in (wi, wo))
        for one, other in ((a, b), (b, a))[: 1 + average.exchanged]:
            out = mi.Vector3f(np.ascontiguousarray(other.T))
            value = bottom.eval(mi.BSDFContext(), probing.interaction(one, everywhere), out)
            channels = spectrum.to_channels(value / out.z)
            total = [a + b for a, b in zip(total, channels, strict=True)]
    return [value / (azimuths * (1 + average.exchanged)) for value in total]
