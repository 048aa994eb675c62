"""The interface of a system of networks for evaluation and sampling in Dr.Jit kernels.

A decoder and a sampler, each in two steps: the terms that depend on the latent code alone, which
constant materials compute once on the host, and the rest, which depends on directions. Urushi's own
are in `decoder` and `sampler`; networks of another system have the method `drjit`.
"""

from collections.abc import Sequence
from typing import Protocol, cast

import numpy as np

from urushi.mitsuba.networks.decoder import UrushiDecoder
from urushi.mitsuba.networks.lobe import ANY_LOBE, LobeKind
from urushi.mitsuba.networks.sampler import UrushiSampler
from urushi.nets.networks import UrushiNetworks
from urushi.nets.weights import Model


class Proposal(Protocol):
    """The density that directions are drawn from at some wi, normalised over the hemisphere."""

    def pdf(self, wi, wo):
        """Density of `sample` at wo [1/sr]; zero where either direction is below the horizon."""

    def sample(self, wi, choice, u):
        """Draw wo above the horizon by the uniform numbers `choice` and `u` (two)."""


class Decoder(Protocol):
    """f [1/sr] from latent codes."""

    def code_terms(self, latents: np.ndarray) -> Sequence[np.ndarray]:
        """Terms (K,) of the latent code of each channel (C, size), by NumPy."""

    def f_of_terms(self, terms: Sequence[Sequence], wi, wo) -> list:
        """f [1/sr] of each channel, from a list of Dr.Jit floats, its terms, for each."""

    def code_terms_drjit(self, latents: Sequence[Sequence]) -> list[list]:
        """`code_terms` of codes given as lists (size) of Dr.Jit floats, one for each channel."""

    def f(self, latents: Sequence[Sequence], wi, wo) -> list:
        """f [1/sr] of each channel, from a list (size) of Dr.Jit floats for each."""


class Sampler(Protocol):
    """Proposals from latent codes."""

    def tabulated(self, latent: np.ndarray) -> Sequence[np.ndarray]:
        """Arrays that `proposal_of_table` needs of a latent code (size,), of any shapes."""

    def proposal_of_table(self, table: Sequence, wi) -> Proposal:
        """The proposal for wi, about that of the code.

        table: the arrays of `tabulated`, flattened, as Dr.Jit floats.
        """

    def proposal(self, latent: Sequence, wi) -> Proposal:
        """The proposal for wi, from a list (size) of Dr.Jit floats."""


class DrJitNetworks(Protocol):
    """Networks of another system that can be rendered."""

    def drjit(self, model: Model) -> tuple[Decoder, Sampler]:
        """Decoder and sampler in the current variant."""


def decoder_and_sampler(model: Model, kind: LobeKind = ANY_LOBE) -> tuple[Decoder, Sampler]:
    """A model's decoder and sampler in the current variant.

    kind: what is known of the lobes of the codes that they are given.
    """
    if isinstance(model.networks, UrushiNetworks):
        return UrushiDecoder(model, kind), UrushiSampler(model, kind)
    return cast(DrJitNetworks, model.networks).drjit(model)
