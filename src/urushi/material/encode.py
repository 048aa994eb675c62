"""Encoding: from any BRDF that can be evaluated at the probe pairs to a material.

The topmost interface of a description is known exactly and becomes the lobe of the code
(`urushi.nets.lobe`). The lobes of other sources are fitted to their values. For the rest of the
BRDF, the code that is evaluated is fitted to the values (`urushi.material.fit`). The anchor, over
which coats are layered, is the encoder's own code, or a code near those for unusual sources.
"""

import functools
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from urushi.core.error_metrics import DARK_OFFSET, energy_weight
from urushi.core.table import node_pairs, table_of_values
from urushi.errors import ParameterError, UrushiError, UrushiWarning
from urushi.material import energy
from urushi.material.albedo_rule import AlbedoRule, albedo_rule
from urushi.material.fit import probe_features, refine_codes
from urushi.material.lobe_albedo import lobe_albedos
from urushi.material.material import Material
from urushi.material.simulated import FIT_WALKS, fit_to_walks
from urushi.material.source import Source, as_source, source_name
from urushi.material.symmetry import Deviations, deviations_of, is_anisotropic, symmetrise
from urushi.measured import load_measured
from urushi.nets import lobe as lobes
from urushi.nets.interface_fit import find_lobes
from urushi.nets.weights import Model, Weights, anisotropic_model, find
from urushi.parallel import fill_blocks
from urushi.walk import Stack, simulate

#: Root mean square of the residual in ln(f + `DARK_OFFSET`) of a fitted code above which the anchor
#: is fitted too. Measured: descriptions, coats and stacks of the training distribution stay below
#: 0.12, and Mitsuba's BSDFs below 0.2; retro-reflectors and most measured BRDFs exceed it.
UNUSUAL_RESIDUAL = 0.3


#: Ratios of the error of an anchor to the error of its lobe alone: up to the first the rest is kept
#: whole, from the second it is left out. Lobes with a larger error than `NEAR_LOBE` keep the rest.
HELPFUL_REST, NEAR_LOBE = (1.0, 1.1), 0.3

#: Reflectance at normal incidence of an index of 2: fitted lobes of dielectrics are below it. And
#: the quantile of f over the probe pairs, less the lobe, that is the light of a surface below a
#: dielectric: it is near 0 for rough metals that a lobe does not fit.
DIELECTRIC, DIFFUSE_QUANTILE = 1 / 9, 0.2


class SourceValues(NamedTuple):
    """Values of a source of `encode`."""

    values: np.ndarray  # float32 (N, C) [1/sr], made isotropic and reciprocal
    deviations: Deviations  # of the source from what a material can represent
    measured: bool  # whether the source is a measured BRDF
    lobe: np.ndarray | None = None  # as in `Source`


def encode(
    source: Any,
    weights: Weights | None = None,
    *,
    refine: bool | None = None,
    table: bool | None = None,
) -> Material:
    """Encode a BRDF into latent codes, one per channel.

    Args:
        source: a description (conductor, dielectric, diffuse), a Stack (simulated with a fixed
            seed), a Material, a measured BRDF, a Mitsuba BSDF, or a callable or an object with a
            method f: f(wi, wo) -> (N, 3), (N, C), or (N,) for one channel [1/sr, no cosine]. It is
            evaluated at pairs above the horizon only. An anisotropic source keeps its anisotropy
            about the tangent, the x axis. A source that is not reciprocal, or not symmetric about
            the tangent, is averaged to have these symmetries (see `urushi.material.symmetry`). Of a
            BSDF that transmits, only the reflection is encoded.
        weights: the networks, a Model or a weights file. None: the shipped ones, "anisotropic" for
            anisotropic sources. Networks for isotropic materials encode the average of an
            anisotropic source over the azimuth.
        refine: None: the code is fitted to the values, about 50 ms per channel, but coats are
            layered over the encoder's own code, unless the source is measured or the residual
            exceeds `UNUSUAL_RESIDUAL` (see `urushi.material.fit`). True: coats are layered over a
            fitted code too. False: one pass of the encoder. The code of a Stack is fitted to walks,
            2.6 M for each channel (see `urushi.material.simulated`); in the mean it is closer than
            the code of `layer`.
        table: whether the material also gets a table of f over directions (see
            `urushi.core.table`), which is used to evaluate and render it. It costs as much as
            the codes and is far more accurate for unusual BRDFs. Textures use the codes. The source
            is evaluated at 25,000 more pairs, which takes minutes for a Stack; a file is 150 kB
            larger. None: for measured BRDFs, and for Mitsuba BSDFs but conductors, Lambertians and
            those that draw random numbers. A bare conductor or dielectric, whose lobe is exact, and
            a Material of the same networks get none.

    Raises:
        ParameterError: the source is none of these; it is an anisotropic Stack, but the networks
            are isotropic; its values have a wrong shape, are negative or not finite; or it is a
            BSDF without rough reflection.
        FileError: the shipped networks are missing.

    Warns:
        UrushiWarning: averaging changes the source by more than 10 %, or transmitted or specular
            light is left out.
    """
    model = model_for(source, weights)
    if isinstance(source, Material) and source.model.fingerprint == model.fingerprint:
        return source
    material, deviations = encode_source(source, model, refine=refine, table=table)
    for sentence in deviations.warnings():
        warnings.warn(f"encode {source_name(source)}: {sentence}", UrushiWarning, stacklevel=2)
    return material


def model_for(source: Any, weights: Weights | None = None) -> Model:
    """The networks by which `encode` encodes a source."""
    if weights is not None:
        return find(weights)
    if isinstance(source, Material):
        return anisotropic_model() if source.model.widths == 2 else find(None)
    name = source_name(source)
    anisotropic = is_anisotropic(as_source(source), lambda f, count: _checked(f, name, count))
    return anisotropic_model() if anisotropic else find(None)


def encode_source(
    source: Any,
    model: Model,
    *,
    refine: bool | None = None,
    table: bool | None = None,
    name: str | None = None,
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
    found = evaluate_source(source, *pairs, name, widths=model.widths)
    count = len(required_pairs(None, model, table=False)[0])
    values, at_table = found.values[:count], found.values[count:]
    fitted = True if refine is None and found.measured else refine
    material = material_from_values(values, model, refine=fitted, lobe=found.lobe)
    if len(at_table):
        material = replace(material, table=table_of_values(at_table))
    if refine is not False and isinstance(source, Stack):
        # The random numbers differ from those of the values.
        walks = functools.partial(simulate, source, walks=FIT_WALKS, seed=1)
        material = fit_to_walks(material, walks)
    return material, found.deviations


def encode_all(
    sources: Sequence[Any],
    *,
    weights: Weights | None = None,
    refine: bool | None = None,
    table: bool | None = None,
) -> Iterator[tuple[int, tuple[Material, Deviations] | UrushiError]]:
    """Encode many BRDFs, one after the other.

    sources: each a Path of a measured BRDF, or else what `encode` takes, as the other arguments.

    Yields:
        (index, result) of each source: the material and the source's deviations, or the source's
        error, which stops none of the others.
    """
    weights = None if weights is None else find(weights)
    for index, source in enumerate(sources):
        try:
            opened = load_measured(source) if isinstance(source, Path) else source
            model = model_for(opened, weights)
            yield index, encode_source(opened, model, refine=refine, table=table)
        except UrushiError as error:
            yield index, error


def material_of_lobes(lobe: np.ndarray, model: Model, channels: int = 3) -> Material:
    """The material of a surface that is its lobes (N,) or (channels, N) alone.

    The anchor is the encoder's output for them.
    """
    anchors = bare_anchors(model, np.broadcast_to(lobe, (channels, lobe.shape[-1])))
    return Material(model.networks.without_rest(anchors), model, anchors)


def bare_anchors(model: Model, lobe: np.ndarray) -> np.ndarray:
    """The anchors float32 (..., L) of surfaces that are their lobes (..., N) alone.

    All have the same rest, the encoder's code of a zero rest. The energy limit does not scale it,
    because the layerer was trained on it unscaled.
    """
    rest = model.networks.empty_rest()
    shape = *lobe.shape[:-1], len(rest)
    return np.concatenate([lobe, np.broadcast_to(rest, shape)], axis=-1, dtype=np.float32)


def required_pairs(
    source: Any, model: Model, table: bool | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of directions (N, 3) at which a source has to be known to be encoded.

    These are the networks' own pairs, and the nodes of `albedo_rule`, for the albedo of the
    source, which limits the material's albedo. A Stack is not simulated at the nodes: its albedo is
    at most 1. For a table, `table.node_pairs` follow, and a Stack has the nodes too.

    source: as of `encode`.
    """
    parts = [model.networks.pairs()]
    if table is None:
        table = model.widths == 1 and as_source(source).tabulated
    if table and model.widths != 1:
        raise ParameterError(
            "materials of these networks cannot have tables; give table=False or other networks"
        )
    if table or not isinstance(source, Stack):
        parts.append(albedo_rule(model.widths)[:2])
    if table:
        parts.append(node_pairs())
    wi, wo = (np.concatenate(sides) for sides in zip(*parts, strict=True))
    return wi, wo


def evaluate_source(
    source: Any, wi: np.ndarray, wo: np.ndarray, name: str | None = None, *, widths: int = 1
) -> SourceValues:
    """Values of a source of `encode` for float32 unit vectors (N, 3) above the horizon.

    name: begins errors; by default the name of the source's type.
    widths: of the material's networks.
    """
    opened, name = _with_widths(as_source(source), widths), name or source_name(source)
    if isinstance(source, Stack) and not opened.symmetric:
        raise ParameterError(  # an average over the azimuth would take a hundred simulations
            f"encode {name}: its alpha_u and alpha_v differ, but these networks are for isotropic "
            "materials; give one alpha, or the weights 'anisotropic'"
        )
    values, deviations = symmetrise(
        opened, wi, wo, lambda values, count: _checked(values, name, count), widths
    )
    return SourceValues(values, deviations, opened.measured, opened.lobe)


def _with_widths(source: Source, widths: int) -> Source:
    """The source with a lobe of this number of widths; without one if it has too many."""
    if source.widths > widths:
        return source._replace(symmetric=False, lobe=None, bare=False)
    if source.lobe is not None and source.lobe.shape[-1] < len(lobes.NUMBERS[widths]):
        return source._replace(lobe=lobes.with_two_widths(source.lobe))
    return source


def material_from_values(
    values: np.ndarray,
    model: Model,
    *,
    refine: bool | None = None,
    lobe: np.ndarray | None = None,
) -> Material:
    """The material of values (N, C) at `required_pairs`, or at `model.networks.pairs()` alone.

    Its directional albedo is at most the values' albedo, or at most 1 if the values at the nodes
    are missing (see `urushi.material.energy`).

    Args:
        values: (N, C) [1/sr].
        model: the networks.
        refine: as of `encode`.
        lobe: (N,) or (C, N) the channels' lobes; None: they are fitted to the values.
    """
    pairs = len(model.networks.pairs()[0])
    probed, at_nodes = values[:pairs].T, values[pairs:].T
    nodes = at_nodes if at_nodes.size else None
    fitted = lobe is None
    lobe = find_lobes(probed, model.widths) if lobe is None else np.asarray(lobe, np.float32)
    lobe = np.broadcast_to(lobe, (len(probed), lobe.shape[-1]))
    ceiling = np.full((len(probed), 1), 1 - energy.MARGIN)
    if nodes is not None:
        rule = albedo_rule(model.widths)
        ceiling = energy.albedo_ceiling(_source_albedos(nodes, lobe, rule), rule)
    codes = anchors = encoder_codes(model, probed, lobe)
    if refine is not False:
        codes, refined = refine_codes(model.networks, probed, nodes, lobe)
        if refine or (residual(model, codes, probed) > UNUSUAL_RESIDUAL).any():
            anchors = energy.limit_albedo(model, refined, ceiling)
    if fitted:
        anchors = with_dielectrics_in_rests(model, anchors, probed)
    anchors = without_useless_rests(model, anchors, probed)
    return Material(energy.limit_albedo(model, codes, ceiling), model, anchors)


def with_dielectrics_in_rests(model: Model, anchors: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Anchors (N, L) of f (N, P) whose fitted lobes of dielectrics become part of the rests.

    The layerer has seen exact lobes of dielectrics only, and coats over fitted ones lose up to nine
    tenths of their light. A lobe remains if the surface below it reflects less than half as much as
    the lobe does at normal incidence.

    f: [1/sr] at the probe pairs.
    """
    networks = model.networks
    normal, grazing, exact = anchors[:, 1:4].T
    rest = f - networks.top(anchors[:, None], *networks.pairs())
    diffuse = np.pi * np.quantile(rest, DIFFUSE_QUANTILE, axis=-1)
    mixed = (normal < DIELECTRIC) & (exact == 0) & (normal + grazing > lobes.VISIBLE)
    mixed &= diffuse > 0.5 * normal
    if not mixed.any():
        return anchors
    result, none = np.array(anchors), np.array(lobes.no_lobe(model.widths), np.float32)
    result[mixed] = encoder_codes(model, f[mixed], none)
    return result


def without_useless_rests(model: Model, anchors: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Anchors (N, L) without their rests where the lobe alone is closer to f (N, P).

    f: [1/sr] at the probe pairs. A rest whose decoded values are worse than zero is far from all
        training data, and coats over it may have unbounded errors. This occurs if the lobe is
        nearly the whole source.
    """
    networks = model.networks
    wi, wo = networks.pairs()
    weight = energy_weight(wi[:, 2], wo[:, 2])
    rest = f - networks.top(anchors[:, None], wi, wo)
    alone = np.abs(rest) @ weight
    near = alone < NEAR_LOBE * (f @ weight)
    if not near.any():
        return anchors
    decoded = networks.rest(anchors[near, None], probe_features(networks))
    errors = np.abs(rest[near] - decoded) @ weight / np.maximum(alone[near], energy.LEAST_ALBEDO)
    low, high = HELPFUL_REST
    kept = np.clip((high - errors) / (high - low), 0, 1)[:, None].astype(np.float32)
    result = np.array(anchors)
    bare = bare_anchors(model, anchors[near, : model.arch.lobe])
    result[near] = np.where(kept == 1, anchors[near], kept * anchors[near] + (1 - kept) * bare)
    return result


def _source_albedos(f: np.ndarray, lobe: np.ndarray, rule: AlbedoRule) -> np.ndarray:
    """Directional albedos (C, D) of values f (C, M) at the nodes of a rule.

    The nodes are too few for the sharpest lobes (N,), whose albedos are computed separately.
    """
    rest = np.maximum(f - lobes.f(lobe[:, None], rule.wi, rule.wo), 0.0)
    return rule.albedo(rest) + lobe_albedos(lobe, rule)


def residual(model: Model, z: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Root mean squares (C,) of ln(f + `DARK_OFFSET`) between codes (C, L) and values f (C, P)."""
    decoded = model.networks.f(z[:, None], *model.networks.pairs())
    return np.sqrt(np.square(np.log((decoded + DARK_OFFSET) / (f + DARK_OFFSET))).mean(axis=-1))


def _checked(values: Any, name: str, count: int) -> np.ndarray:
    """Return the values at `count` pairs as float32 (N, C); name: begins errors."""
    try:
        array = np.asarray(values, dtype=np.float32)
    except (TypeError, ValueError) as error:
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


def encoder_codes(model: Model, f: np.ndarray, lobe: np.ndarray | None = None) -> np.ndarray:
    """Codes float32 (..., L) that the encoder makes of f (..., P) [1/sr] at its pairs.

    lobe: (N,) or (..., N) the lobes of f; None: they are fitted to the values.
    """
    values = np.asarray(f, np.float32)
    pairs = len(model.networks.pairs()[0])
    if not values.ndim or values.shape[-1] != pairs:
        raise ParameterError(f"f has shape {values.shape}; these networks need (..., {pairs})")
    codes = np.empty((*values.shape[:-1], model.arch.latent), np.float32)
    own = [] if lobe is None else [np.broadcast_to(lobe, (*values.shape[:-1], lobe.shape[-1]))]
    fill_blocks(codes, model.networks.encode, values, *own)
    return codes
