"""What a system of networks brings to be evaluated and sampled inside Dr.Jit's kernels.

A decoder and a sampler, each in two steps: the terms that depend on the latent code alone, which
constant materials compute once on the host, and the rest, which depends on directions. Urushi's own
are in `decoder` and `sampler`; networks of another system have the method `drjit`.
"""

from collections.abc import Sequence
from typing import Protocol, cast

import numpy as np

from urushi.nets.networks import UrushiNetworks
from urushi.nets.weights import Model
from urushi.render.networks.decoder import UrushiDecoder
from urushi.render.networks.sampler import UrushiSampler


class Proposal(Protocol):
    """The density that directions are drawn from at some wi, normalised over the hemisphere."""

    def pdf(self, wi, wo):
        """Density of `sample` at wo [1/sr]; zero where either direction is below the horizon."""

    def sample(self, wi, choice, u):
        """Draw wo above the horizon by the uniform numbers `choice` and `u` (two)."""


class Decoder(Protocol):
    """f [1/sr] from latent codes."""

    def code_terms(self, latents: np.ndarray) -> np.ndarray:
        """Terms (..., K) of latent codes (..., 32), by NumPy."""

    def code_terms_drjit(self, latent: Sequence) -> list:
        """The same of one latent code: a list (K) from a list (32) of Dr.Jit floats."""

    def f_of_terms(self, terms: Sequence[Sequence], wi, wo) -> list:
        """f [1/sr] of each channel, from a list (K) of Dr.Jit floats for each."""

    def f(self, latents: Sequence[Sequence], wi, wo) -> list:
        """f [1/sr] of each channel, from a list (32) of Dr.Jit floats for each."""


class Sampler(Protocol):
    """Proposals from latent codes."""

    def code_terms(self, latent: np.ndarray) -> np.ndarray:
        """Terms (K,) of a latent code (32,), by NumPy."""

    def proposal_of_terms(self, terms: Sequence, cos_i) -> Proposal:
        """The proposal for wi of cosine cos_i, from a list (K) of Dr.Jit floats."""

    def proposal(self, latent: Sequence, cos_i) -> Proposal:
        """The proposal for wi of cosine cos_i, from a list (32) of Dr.Jit floats."""


class DrJitNetworks(Protocol):
    """Networks of another system that can be rendered."""

    def drjit(self, model: Model) -> tuple[Decoder, Sampler]:
        """Decoder and sampler in the current variant."""


def decoder_and_sampler(model: Model) -> tuple[Decoder, Sampler]:
    """A model's decoder and sampler in the current variant."""
    if isinstance(model.networks, UrushiNetworks):
        return UrushiDecoder(model), UrushiSampler(model)
    return cast(DrJitNetworks, model.networks).drjit(model)
