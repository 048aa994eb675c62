"""Encoding: from any BRDF that can be evaluated at the probe pairs to a material.

The topmost interface of a description is known exactly and becomes the lobe of the code
(`urushi.nets.lobe`). The lobes of other sources are fitted to their values. The rest of the BRDF is
a least-squares solution in the basis (`urushi.nets.code_fit`).
"""

from typing import Any

import numpy as np

from urushi import checks
from urushi.core.table import node_pairs, table_of_values
from urushi.errors import ParameterError
from urushi.material import energy
from urushi.material.albedo_rule import albedo_rule
from urushi.material.material import Material
from urushi.material.source import Source, as_source, source_name
from urushi.material.symmetry import Deviations, deviations_of, is_anisotropic, symmetrise
from urushi.nets import lobe as lobes
from urushi.nets.lobe_fit import fit_lobes
from urushi.nets.transmittance import table_beside
from urushi.nets.weights import Model, Weights, anisotropic_model, find
from urushi.walk import Stack


def model_for(source: Any, weights: Weights | None = None) -> Model:
    """The weights by which `encode` encodes a source."""
    if weights is not None:
        return find(weights)
    if isinstance(source, Material):
        return anisotropic_model() if source.model.widths == 2 else find(None)
    anisotropic = is_anisotropic(_opened(source, source_name(source)))
    return anisotropic_model() if anisotropic else find(None)


def encode_source(
    source: Any, model: Model, *, table: bool | None = None, name: str | None = None
) -> tuple[Material, Deviations]:
    """`encode` without its warnings.

    name: begins errors; by default the name of the source's type.

    Returns:
        The material, and the source's deviations.
    """
    opened = _with_widths(as_source(source), model.widths)
    if opened.bare and opened.lobe is not None:
        lobe = np.atleast_2d(opened.lobe)
        channels = 3 if len(lobe) == 1 else len(lobe)
        material = material_of_lobes(opened.lobe, model, channels)
        return material, deviations_of(opened, widths=model.widths)
    pairs = required_pairs(source, model, table)
    values, deviations = evaluate_source(source, *pairs, name, widths=model.widths)
    count = len(required_pairs(None, model, table=False)[0])
    codes, at_table = codes_of_values(values[:count].T, model, opened.lobe), values[count:]
    if not len(at_table):
        return Material(codes, model), deviations
    beside = opened.lobe is not None  # a known lobe is finer than any table
    own = (
        table_beside(at_table, codes[:, : model.arch.lobe]) if beside else table_of_values(at_table)
    )
    return Material(codes, model, own, beside_lobe=beside), deviations


def material_of_lobes(lobe: np.ndarray, model: Model, channels: int = 3) -> Material:
    """The material of a surface that is its lobes (N,) or (channels, N) alone."""
    rest, size = model.networks.empty_rest(), lobe.shape[-1]
    parts = np.broadcast_to(lobe, (channels, size)), np.tile(rest, (channels, 1))
    return Material(np.concatenate(parts, axis=1), model)


def required_pairs(
    source: Any, model: Model, table: bool | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of directions (N, 3) at which a source has to be known to be encoded.

    These are the probe pairs, and the nodes of `albedo_rule`, for the albedo of the source, which
    the material shall have. A Stack is not simulated at the nodes: its albedo is
    at most 1. For a table, `table.node_pairs` follow, and a Stack has the nodes too.

    source: as of `encode`.
    """
    parts = [model.networks.pairs()]
    if table is None:
        table = model.widths == 1 and as_source(source).tabulated
    if table and model.widths != 1:
        raise ParameterError(
            "materials of these weights cannot have tables; give table=False or other weights"
        )
    if table or not isinstance(source, Stack):
        parts.append(albedo_rule(model.widths)[:2])
    if table:
        parts.append(node_pairs())
    wi, wo = (np.concatenate(sides) for sides in zip(*parts, strict=True))
    return wi, wo


def evaluate_source(
    source: Any, wi: np.ndarray, wo: np.ndarray, name: str | None = None, *, widths: int = 1
) -> tuple[np.ndarray, Deviations]:
    """Values of a source of `encode` for float32 unit vectors (N, 3) above the horizon.

    name: begins errors; by default the name of the source's type.
    widths: of the material's codes.

    Returns:
        float32 (N, C) [1/sr], made isotropic and reciprocal; and the deviations of the source from
        what a material can represent.
    """
    name = name or source_name(source)
    opened = _with_widths(_opened(source, name), widths)
    if isinstance(source, Stack) and not opened.symmetric:
        raise ParameterError(  # an average over the azimuth would take a hundred simulations
            f"encode {name}: its alpha_u and alpha_v differ, but these weights are for isotropic "
            "materials; give one alpha, or the weights 'anisotropic'"
        )
    return symmetrise(opened, wi, wo, widths)


def _opened(source: Any, name: str) -> Source:
    """The source, whose values are checked; name: begins errors."""
    opened = as_source(source)
    return opened._replace(f=lambda wi, wo: _checked(opened.f(wi, wo), name, len(wi)))


def _with_widths(source: Source, widths: int) -> Source:
    """The source with a lobe of this number of widths; without one if it has too many."""
    if source.widths > widths:
        return source._replace(symmetric=False, lobe=None, bare=False)
    if source.lobe is not None and source.lobe.shape[-1] < len(lobes.NUMBERS[widths]):
        return source._replace(lobe=lobes.with_two_widths(source.lobe))
    return source


def codes_of_values(values: np.ndarray, model: Model, lobe: np.ndarray | None = None) -> np.ndarray:
    """Codes float32 (..., C, L) of values at `required_pairs`, or at `networks.pairs()` alone.

    Their directional albedos are about those of the values, and at most 1, also if the values at
    the nodes are missing (see `urushi.material.energy`).

    Args:
        values: (..., C, N) [1/sr], of channels that share the stretch of two widths.
        model: the basis.
        lobe: (L',) or (..., C, L') the lobes; None: they are fitted to the values.
    """
    pairs = len(model.networks.pairs()[0])
    probed, at_nodes = values[..., :pairs], values[..., pairs:]
    lobe = fit_lobes(probed, model.widths) if lobe is None else np.asarray(lobe, np.float32)
    lobe = np.broadcast_to(lobe, (*probed.shape[:-1], lobe.shape[-1]))
    codes = model.networks.encode(probed, lobe)
    bounds: tuple[np.ndarray, ...] = ()
    if at_nodes.size:
        rule = albedo_rule(model.widths)
        rest = np.maximum(at_nodes - lobes.f(lobe[..., None, :], rule.wi, rule.wo), 0.0)
        # The nodes are too few for the sharpest lobes, whose albedos are computed separately.
        bounds = energy.albedo_bounds(rule.albedo(rest) + energy.lobe_albedos(lobe), rule)
    return energy.nearest_within(model, codes, *bounds)


def _checked(values: Any, name: str, count: int) -> np.ndarray:
    """Return the values at `count` pairs as float32 (N, C); name: begins errors."""
    try:
        array = checks.real(values, np.float32)
    except checks.NO_NUMBERS as error:
        raise ParameterError(
            f"{name} does not return an array of numbers; return f of shape (N, 3)"
        ) from error
    if array.ndim == 1:
        array = array[:, None]
    if array.ndim != 2 or array.shape[0] != count or array.shape[1] == 0:
        raise ParameterError(
            f"{name} returns shape {np.shape(values)} for {count} pairs of directions; "
            f"return ({count}, 3), or ({count},) for one channel"
        )
    if not (np.isfinite(array) & (array >= 0.0)).all():
        raise ParameterError(
            f"{name} returns a negative or non-finite value; a BRDF must be finite and at least 0"
        )
    return array
