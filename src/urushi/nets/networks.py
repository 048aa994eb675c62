"""What a model offers, whatever its architecture: the interface that all floors above use."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np

from urushi.checks import CoatParameters
from urushi.geometry.probe_pairs import probe_pairs
from urushi.nets import decoder, derivatives, encoder, layerer, sampler
from urushi.nets.architecture import Architecture
from urushi.nets.features import coat_features, direction_features
from urushi.nets.mlp import Params


class Proposal(Protocol):
    """A normalised density over the upper hemisphere, for sampling."""

    def pdf(self, wi: Any, wo: Any) -> Any:
        """Density (...) [1/sr] of `sample` at wo (..., 3); 0 where either is below the horizon."""

    def sample(self, wi: Any, u: Any) -> Any:
        """Directions wo (..., 3) from uniform numbers u (..., 3); wi above the horizon."""


class Networks(Protocol):
    """What any system of networks offers: operations on latent codes z (..., L).

    A code stands for one monochrome BRDF. Leading dimensions broadcast; arrays are NumPy's. Several
    threads may call every operation at once. `UrushiNetworks` offers more: every code has a gain,
    and derivatives are known. What depends on these is left out for other systems.
    """

    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """The direction pairs wi, wo (P, 3) at which `encode` needs a BRDF's values."""

    def encode(self, f: Any) -> Any:
        """Codes (..., L) of BRDFs with values f (..., P) [1/sr] at `pairs`."""

    def layer(self, z_bottom: Any, coat: CoatParameters) -> Any:
        """Codes (..., L) of bottoms under coats."""

    def f(self, z: Any, wi: Any, wo: Any) -> Any:
        """BRDF values (...) [1/sr, no cosine], never negative, for wi, wo above the horizon."""

    def proposal(self, z: Any, wi: Any) -> Proposal:
        """The sampling proposal of codes z (..., L) for wi (..., 3) above the horizon."""


class LobeProposal(NamedTuple):
    """The proposal of `lobes`: weights (..., K+1) and GGX widths (..., K)."""

    weights: Any
    alphas: Any

    def pdf(self, wi: Any, wo: Any) -> Any:
        """See `lobes.pdf`."""
        return sampler.mixture_pdf(self.weights, self.alphas, wi, wo)

    def sample(self, wi: Any, u: Any) -> Any:
        """See `lobes.sample`."""
        return sampler.sample_mixture(self.weights, self.alphas, wi, u)


class UrushiNetworks(NamedTuple):
    """Encoder, layerer, decoder and sampler of an `Architecture`."""

    params: Params
    arch: Architecture

    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """The probe pairs."""
        return probe_pairs(self.arch.probes)

    def encode(self, f: Any) -> Any:
        """One pass of the encoder."""
        return encoder.encode(self.params, self.arch, f)

    def layer(self, z_bottom: Any, coat: CoatParameters) -> Any:
        """One pass of the layerer."""
        return layerer.layer(self.params, self.arch, z_bottom, coat_features(*coat))

    def f(self, z: Any, wi: Any, wo: Any) -> Any:
        """Decode: positive, and the same bits with wi and wo exchanged."""
        return self.decode(z, direction_features(wi, wo))

    def scaled(self, z: Any, factor: Any) -> Any:
        """Exactly, for all pairs of directions alike."""
        return decoder.scaled(z, factor)

    def decode(self, z: Any, features: Any) -> Any:
        """See `f`."""
        return decoder.decode(self.params, self.arch, z, features)

    def decode_log(self, z: Any, features: Any) -> tuple[Any, Any]:
        """Logarithmic values and their derivatives with respect to the code."""
        return derivatives.decode_log(self.params, self.arch, z, features)

    def encode_log(self, logs: Any) -> tuple[Any, Any]:
        """Codes and their derivatives with respect to logarithmic values."""
        return derivatives.encode_log(self.params, self.arch, logs)

    def normalised(self, f: Any) -> Any:
        """The encoder's inputs."""
        return encoder.normalised(self.params, encoder.log_values(f))

    def of_fewer(self, kept: Any, matrix: Any, offset: Any) -> Callable[[Any], Any]:
        """Some of the probe pairs tell the others."""
        params = encoder.of_fewer(self.params, kept, matrix, offset)
        return lambda f: encoder.encode(params, self.arch, f)

    def proposal(self, z: Any, wi: Any) -> LobeProposal:
        """GGX reflection lobes and a cosine lobe."""
        return LobeProposal(*sampler.mixture(self.params, self.arch, z, wi[..., 2]))
