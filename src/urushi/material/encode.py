"""Encoding: from any BRDF that can be evaluated at the probe pairs to a material.

One pass of the encoder, and two steps of correction (`correct`) or many of refinement (`refine`).
"""

import functools
import warnings
from typing import Any, NamedTuple

import numpy as np

from urushi.errors import ParameterError, UrushiWarning
from urushi.material import energy
from urushi.material.energy import limit_albedo
from urushi.material.fit import correct_codes, refine_codes
from urushi.material.material import Material
from urushi.material.symmetry import Deviations, Source, symmetrise
from urushi.measured import Merl
from urushi.nets import weights
from urushi.nets.networks import UrushiNetworks
from urushi.nets.weights import Model, Weights
from urushi.parallel import fill_blocks
from urushi.reference.stack import Conductor, Dielectric, Diffuse, Stack

#: Random walks per probe and channel for a Stack: about 0.5 % noise where f is not tiny.
STACK_WALKS = 16384


class SourceValues(NamedTuple):
    """What `encode` wants to know of a source.

    Attributes:
        values: float32 (N, C) [1/sr] at `required_pairs`.
        deviations: how the source differs from what a material can be.
    """

    values: np.ndarray
    deviations: Deviations


def encode(source: Any, model: Weights | None = None, *, refine: bool = False) -> Material:
    """Encode a BRDF into latent codes, one per channel.

    Args:
        source: a description (conductor, dielectric, diffuse), a Stack (simulated with a fixed
            seed), a Material, any callable or any object with a method f that gives
            f(wi, wo) -> (N, 3), (N, C), or (N,) for one channel [1/sr, no cosine], a measured
            BRDF, or a Mitsuba BSDF. It is only asked about pairs above the horizon. What is not
            isotropic or not reciprocal is averaged until it is (see `urushi.material.symmetry`);
            of a BSDF that transmits, what it reflects is encoded.
        model: the networks: a Model, "base" (the default) or "small", or a weights file.
        refine: whether to follow the encoder's one pass by more than two quick steps that bring
            the decoded values closer to the given ones: for measured or unusual BRDFs, some 80 ms a
            channel (see `urushi.material.fit`). The paper's networks encode by optimisation
            anyway; they do nothing more.

    Raises:
        ParameterError: the source is none of these, or what it gives has a wrong shape, is
            negative or is not finite; or it is a BSDF that reflects nothing but mirror images, or
            nothing at all.
        FileError: the shipped networks are missing.

    Warns:
        UrushiWarning: averaging changes the source by more than 10 %, or a share of the light is
            left out.
    """
    model = weights.find(model)
    if isinstance(source, Material) and source.model.fingerprint == model.fingerprint:
        return source
    result = evaluate_source(source, *required_pairs(source, model))
    for sentence in result.deviations.warnings():
        warnings.warn(f"encode {source_name(source)}: {sentence}", UrushiWarning, stacklevel=2)
    return material_from_values(result.values, model, refine=refine)


def required_pairs(source: Any, model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of directions (N, 3) at which `material_from_values` wants to know a source.

    The networks' own, and those that tell the source's albedo, which its code's shall not exceed. A
    Stack is not simulated at these: its albedo is at most 1.
    """
    wi, wo = model.networks.pairs()
    if isinstance(source, Stack) or not isinstance(model.networks, UrushiNetworks):
        return wi, wo
    nodes = energy.albedo_rule()
    return np.concatenate([wi, nodes.wi]), np.concatenate([wo, nodes.wo])


def evaluate_source(source: Any, wi: np.ndarray, wo: np.ndarray) -> SourceValues:
    """Values of a source of `encode` for float32 unit vectors (N, 3), and what was found."""
    return SourceValues(
        *symmetrise(
            as_source(source), wi, wo, lambda values, count: _checked(values, source, count)
        )
    )


def material_from_values(values: np.ndarray, model: Model, *, refine: bool = False) -> Material:
    """The material of values (N, C) at `required_pairs`, or at `model.networks.pairs()` alone.

    Its directional albedo is at most that of the values, or at most 1 if the pairs that tell it are
    missing (see `urushi.material.energy`).
    """
    seen = len(model.networks.pairs()[0])
    probed, rest = values[:seen].T, values[seen:].T
    nodes = rest if rest.size else None
    own, ceiling = np.ones((len(probed), 1)), np.full((len(probed), 1), 1 - energy.MARGIN)
    if nodes is not None:
        own = energy.albedo_rule().albedo(rest)
        ceiling = energy.albedo_ceiling(own)
    if refine:
        both = np.stack(refine_codes(model.networks, probed, nodes))
        codes, anchors = energy.limit_albedo(model, both, ceiling)
        return Material(codes, model, anchors)
    anchors = encoder_codes(model, probed)
    codes, excess = correct_codes(model.networks, anchors, probed)
    # Anchors are not looked at. They only must not bring light into a coat, which few come near to.
    bright = own.max(axis=-1) * excess > 1 - energy.MARGIN
    if bright.any():
        anchors[bright] = energy.limit_albedo(model, anchors[bright], ceiling[bright])
    return Material(energy.limit_albedo(model, codes, ceiling), model, anchors)


@functools.singledispatch
def as_source(source: Any) -> Source:
    """A source of `encode` as a function that can be evaluated.

    Other types of sources are added by `as_source.register(type, function)`; the render floor adds
    Mitsuba's BSDFs.

    Raises:
        ParameterError: the source cannot be encoded.
    """
    if callable(getattr(source, "f", None)):
        return Source(source.f, symmetric=isinstance(source, Material | Merl))
    if callable(source) and not isinstance(source, type):
        return Source(source)
    raise ParameterError(
        f"cannot encode {type(source).__name__}; give a conductor, dielectric, diffuse, Stack, "
        "Material, measured or Mitsuba BRDF, or a function f(wi, wo) -> (N, 3)"
    )


@as_source.register
def _(source: Source) -> Source:
    return source


@as_source.register(Conductor)
@as_source.register(Dielectric)
@as_source.register(Diffuse)
def _(source: Conductor | Dielectric | Diffuse) -> Source:
    from urushi.reference import analytic  # lazily: it starts Dr.Jit

    return Source(lambda wi, wo: analytic.f(source, wi, wo), symmetric=True)


@as_source.register
def _(source: Stack) -> Source:
    from urushi.reference.simulate import simulate

    return Source(
        lambda wi, wo: simulate(source, wi, wo, walks=STACK_WALKS, seed=0)[0], symmetric=True
    )


def source_name(source: Any) -> str:
    """What messages call a source."""
    return getattr(source, "__name__", type(source).__name__)


def _checked(values: Any, source: Any, count: int) -> np.ndarray:
    """Return the values as float32 (N, C)."""
    name = source_name(source)
    try:
        array = np.asarray(values, dtype=np.float32)
    except (TypeError, ValueError) as error:
        raise ParameterError(
            f"{name} gives no array of numbers; return f of shape (N, 3)"
        ) from error
    if array.ndim == 1:
        array = array[:, None]
    if array.ndim != 2 or array.shape[0] != count or array.shape[1] == 0:
        raise ParameterError(
            f"{name} gives shape {np.shape(values)} for {count} pairs of directions; "
            f"return ({count}, 3), or ({count},) for one channel"
        )
    if not (np.isfinite(array) & (array >= 0.0)).all():
        raise ParameterError(
            f"{name} gives a negative or not finite value; a BRDF must be finite and at least 0"
        )
    return array


def limited_codes(model: Model, f: np.ndarray) -> np.ndarray:
    """Return codes float32 (..., 32) from f (..., P) [1/sr] at the pairs of `model.networks`.

    Their directional albedo is at most 1 (see `urushi.material.energy`).
    """
    return limit_albedo(model, encoder_codes(model, f))


def encoder_codes(model: Model, f: np.ndarray) -> np.ndarray:
    """What the networks make of values f (..., P) [1/sr]: codes (..., 32) of any albedo."""
    values = np.asarray(f, np.float32)
    pairs = len(model.networks.pairs()[0])
    if not values.ndim or values.shape[-1] != pairs:
        raise ParameterError(f"f has shape {values.shape}; these networks need (..., {pairs})")
    codes = np.empty((*values.shape[:-1], model.arch.latent), np.float32)
    fill_blocks(codes, model.networks.encode, values)
    return codes
