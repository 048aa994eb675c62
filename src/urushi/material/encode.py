"""Encoding: from any BRDF that can be evaluated at the probe pairs to a material.

One pass of the encoder, and two steps of correction (`correct`) or many of refinement (`refine`).
"""

import warnings
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from urushi.errors import ParameterError, UrushiWarning
from urushi.material import energy
from urushi.material.energy import limit
from urushi.material.fit import corrected, refined
from urushi.material.material import Material
from urushi.material.symmetry import Findings, Source, symmetrised
from urushi.measured import Merl
from urushi.nets import weights
from urushi.nets.networks import UrushiNetworks
from urushi.nets.weights import Model, Weights
from urushi.parallel import fill_blocks
from urushi.reference.stack import Conductor, Dielectric, Diffuse, Stack

#: Random walks per probe and channel for a Stack: about 0.5 % noise where f is not tiny.
STACK_WALKS = 16384

_adapters: list[tuple[Callable[[Any], bool], Callable[[Any], Source]]] = []


class Reading(NamedTuple):
    """What `encode` wants to know of a source.

    Attributes:
        values: float32 (N, C) [1/sr] at `seen_pairs`.
        findings: how the source differs from what a material can be.
    """

    values: np.ndarray
    findings: Findings


def register_adapter(matches: Callable[[Any], bool], adapt: Callable[[Any], Source]) -> None:
    """Teach `encode` another type of source; floors above this one know types that it does not.

    matches: whether this adapter takes a source; adapt: opens the source.
    """
    _adapters.append((matches, adapt))


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
    reading = read(source, *seen_pairs(source, model))
    for sentence in reading.findings.warnings():
        warnings.warn(f"encode {name_of(source)}: {sentence}", UrushiWarning, stacklevel=2)
    return material_from_values(reading.values, model, refine=refine)


def seen_pairs(source: Any, model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of directions (N, 3) at which `encode_values` wants to know a source.

    The networks' own, and those that tell the source's albedo, which its code's shall not exceed. A
    Stack is not simulated at these: its albedo is at most 1.
    """
    wi, wo = model.networks.pairs()
    if isinstance(source, Stack) or not isinstance(model.networks, UrushiNetworks):
        return wi, wo
    nodes = energy.rule()
    return np.concatenate([wi, nodes.wi]), np.concatenate([wo, nodes.wo])


def read(source: Any, wi: np.ndarray, wo: np.ndarray) -> Reading:
    """Values of a source of `encode` for float32 unit vectors (N, 3), and what was found."""
    return Reading(
        *symmetrised(opened(source), wi, wo, lambda values, count: _checked(values, source, count))
    )


def material_from_values(values: np.ndarray, model: Model, *, refine: bool = False) -> Material:
    """The material of values (N, C) at `seen_pairs`, or at `model.networks.pairs()` alone.

    Its directional albedo is at most that of the values, or at most 1 if the pairs that tell it are
    missing (see `urushi.material.energy`).
    """
    seen = len(model.networks.pairs()[0])
    probed, rest = values[:seen].T, values[seen:].T
    nodes = rest if rest.size else None
    own, ceiling = np.ones((len(probed), 1)), np.full((len(probed), 1), 1 - energy.MARGIN)
    if nodes is not None:
        own = energy.rule().albedo(rest)
        ceiling = energy.ceiling(own)
    if refine:
        both = np.stack(refined(model.networks, probed, nodes))
        codes, anchors = energy.limit(model, both, ceiling)
        return Material(codes, model, anchors)
    anchors = encoder_codes(model, probed)
    codes, excess = corrected(model.networks, anchors, probed)
    # Anchors are not looked at. They only must not bring light into a coat, which few come near to.
    bright = own.max(axis=-1) * excess > 1 - energy.MARGIN
    if bright.any():
        anchors[bright] = energy.limit(model, anchors[bright], ceiling[bright])
    return Material(energy.limit(model, codes, ceiling), model, anchors)


def opened(source: Any) -> Source:
    """A source of `encode`, unless it is one already, as something to evaluate.

    Raises:
        ParameterError: it cannot be encoded.
    """
    if isinstance(source, Source):
        return source
    for matches, adapt in reversed(_adapters):
        if matches(source):
            return adapt(source)
    if isinstance(source, Conductor | Dielectric | Diffuse):
        from urushi.reference import analytic  # lazily: it starts Dr.Jit

        return Source(lambda wi, wo: analytic.f(source, wi, wo), symmetric=True)
    if isinstance(source, Stack):
        from urushi.reference.simulate import simulate

        return Source(
            lambda wi, wo: simulate(source, wi, wo, walks=STACK_WALKS, seed=0)[0], symmetric=True
        )
    if callable(getattr(source, "f", None)):
        return Source(source.f, symmetric=isinstance(source, Material | Merl))
    if callable(source) and not isinstance(source, type):
        return Source(source)
    raise ParameterError(
        f"cannot encode {type(source).__name__}; give a conductor, dielectric, diffuse, Stack, "
        "Material, measured or Mitsuba BRDF, or a function f(wi, wo) -> (N, 3)"
    )


def name_of(source: Any) -> str:
    """What messages call a source."""
    return getattr(source, "__name__", type(source).__name__)


def _checked(values: Any, source: Any, count: int) -> np.ndarray:
    """Return the values as float32 (N, C)."""
    name = name_of(source)
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
    return limit(model, encoder_codes(model, f))


def encoder_codes(model: Model, f: np.ndarray) -> np.ndarray:
    """What the networks make of values f (..., P) [1/sr]: codes (..., 32) of any albedo."""
    values = np.asarray(f, np.float32)
    pairs = len(model.networks.pairs()[0])
    if not values.ndim or values.shape[-1] != pairs:
        raise ParameterError(f"f has shape {values.shape}; these networks need (..., {pairs})")
    codes = np.empty((*values.shape[:-1], model.arch.latent), np.float32)
    fill_blocks(codes, model.networks.encode, values)
    return codes
