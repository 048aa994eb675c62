"""The Dr.Jit twins of a model's networks, by the kind of its architecture."""

from collections.abc import Sequence
from typing import Protocol, cast

import numpy as np

from urushi.nets.networks import UrushiNetworks
from urushi.nets.weights import Model
from urushi.render.networks import sampler
from urushi.render.networks.decoder import Decoder


class Mixture(Protocol):
    """A proposal for some wi: a normalised density over the upper hemisphere."""

    def pdf(self, wi, wo):
        """Density of `sample` at wo [1/sr]; zero where either direction is below the horizon."""

    def sample(self, wi, choice, u):
        """Draw wo above the horizon by the uniform numbers `choice` and `u` (two)."""


class Evaluation(Protocol):
    """A model's decoder: what of a constant material can be computed once, and the rest."""

    def first_layer(self, latents: np.ndarray) -> np.ndarray:
        """What evaluations need of latents (..., 32)."""

    def share(self, latent: Sequence) -> list:
        """The same from one latent, a list (32) of Dr.Jit floats."""

    def of_first_layer(self, shares: Sequence[Sequence], wi, wo) -> list:
        """f [1/sr] of each channel from what `first_layer` gave, as lists of Dr.Jit floats."""

    def of_latents(self, latents: Sequence[Sequence], wi, wo) -> list:
        """f [1/sr] of each channel from latents, lists (32) of Dr.Jit floats."""


class Sampling(Protocol):
    """A model's proposal network, divided in the same way."""

    def first_layer(self, latent: np.ndarray) -> np.ndarray:
        """What proposals need of a latent (32,)."""

    def of_first_layer(self, share: Sequence, cos_i) -> Mixture:
        """The proposal for wi of cosine cos_i from what `first_layer` gave."""

    def of_latent(self, latent: Sequence, cos_i) -> Mixture:
        """The proposal from a latent, a list (32) of Dr.Jit floats."""


class BringsKernels(Protocol):
    """Networks of another system, with a Dr.Jit form of their own."""

    def kernels(self, model: Model) -> tuple[Evaluation, Sampling]:
        """Decoder and proposal network in the current variant."""


def networks_of(model: Model) -> tuple[Evaluation, Sampling]:
    """A model's decoder and proposal network in Dr.Jit, in the current variant."""
    if isinstance(model.networks, UrushiNetworks):
        return Decoder(model), sampler.Proposal(model)
    return cast(BringsKernels, model.networks).kernels(model)
