"""Urushi's networks as one value."""

from typing import Any, NamedTuple

import numpy as np

from urushi.checks import CoatParameters
from urushi.core.probe_pairs import probe_pairs
from urushi.core.table import SHAPES, node_pairs
from urushi.nets import decoder, encoder, layerer, sampler
from urushi.nets import lobe as lobes
from urushi.nets.architecture import Architecture
from urushi.nets.features import direction_features
from urushi.nets.lobe_fit import fit_lobes
from urushi.nets.mlp import Params

#: Pairs that are decoded at once.
BLOCK = 4096


class UrushiNetworks(NamedTuple):
    """Encoder, layerer, decoder and sampler of an `Architecture`.

    A code z (..., L) represents one monochrome BRDF. Leading dimensions broadcast; arrays are
    NumPy's. The operations are thread-safe.
    """

    params: Params
    arch: Architecture

    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """The probe pairs wi, wo: float32 (P, 3)."""
        return probe_pairs(self.arch.probes, self.arch.widths)

    def features(self, wi: Any, wo: Any) -> Any:
        """What `rest` needs of pairs (..., 3) above the horizon."""
        return direction_features(wi, wo, self.arch.widths)

    def encode(self, f: Any, lobe: Any = None) -> Any:
        """Codes (..., L) of values f (..., P) [1/sr] at the probe pairs.

        lobe: (..., N) the lobes of these BRDFs, if known; None: `fit_lobes` fits them.
        """
        lobe = fit_lobes(f, self.arch.widths) if lobe is None else lobe
        rest = np.maximum(f - lobes.f(lobe[..., None, :], *self.pairs()), 0.0)
        codes = encoder.encode(self.params, self.arch, rest)
        lobe = np.broadcast_to(lobe, (*codes.shape[:-1], self.arch.lobe))
        return np.concatenate([lobe, codes], axis=-1)

    def layer(self, z_bottom: Any, coat: CoatParameters) -> Any:
        """Codes (..., L) of bottoms under coats."""
        return layerer.layer(self.params, self.arch, z_bottom, coat)

    def f(self, z: Any, wi: Any, wo: Any) -> Any:
        """Values (...) [1/sr]: positive, and the same bits with wi and wo exchanged.

        z (..., L) and the unit vectors wi, wo (..., 3) above the horizon broadcast.
        """
        rest = self.rest(z, direction_features(wi, wo, self.arch.widths))
        return self.top(z, wi, wo) + rest

    def top(self, z: Any, wi: Any, wo: Any) -> Any:
        """The part of f (...) [1/sr] that the codes' lobes reflect."""
        return lobes.f(z[..., : self.arch.lobe], wi, wo)

    def rest(self, z: Any, features: Any) -> Any:
        """The rest of f (...) [1/sr], from `direction_features`."""
        return decoder.decode(self.params, self.arch, z[..., self.arch.lobe :], features)

    def rest_at_all(self, z: np.ndarray, features: np.ndarray) -> np.ndarray:
        """`rest` (S, P) of all codes z (S, L) at all of the same directions' features (P, D)."""
        return decoder.decode_all(self.params, self.arch, z[:, self.arch.lobe :], features)

    def gains(self, z: np.ndarray) -> np.ndarray:
        """The logarithmic gains (...) of the rests of codes z (..., L), a view."""
        return z[..., self.arch.lobe]

    def rest_scaled(self, z: Any, factor: Any) -> Any:
        """Codes (..., L) with `factor` (...) > 0 times the rest, and the same lobe."""
        lobe = self.arch.lobe
        rest = decoder.scaled(z[..., lobe:], factor)
        return np.concatenate([z[..., :lobe], rest], axis=-1)

    def without_rest(self, z: Any) -> Any:
        """Codes (..., L) of the lobes alone: the rest has the least value of the decoder."""
        codes = np.array(z)
        self.gains(codes)[...] = decoder.EMPTY_GAIN
        return codes

    def empty_rest(self) -> Any:
        """The encoder's code (R,) of a rest that is zero."""
        nothing = np.zeros((1, self.arch.probes), np.float32)
        return encoder.encode(self.params, self.arch, nothing)[0]

    def decode_log(self, z: Any, features: Any) -> tuple[Any, Any]:
        """The logarithm (...) of `rest`, and its derivatives (..., R).

        The derivatives are with respect to the R numbers of the code after the lobe's numbers.
        """
        return decoder.decode_log(self.params, self.arch, z[..., self.arch.lobe :], features)

    def encode_log(self, logs: Any) -> tuple[Any, Any]:
        """The codes' R last numbers (..., R) and their derivatives (..., R, P).

        logs (..., P): `encoder.log_values` of the rest at the probe pairs, to which the derivatives
        refer.
        """
        return encoder.encode_log(self.params, self.arch, logs)

    def proposal(self, z: Any, wi: Any) -> tuple[Any, Any]:
        """`sampler.mixture` of codes z (..., L) for wi (..., 3) above the horizon."""
        return sampler.mixture(self.params, self.arch, z, wi)

    def table(self, z: np.ndarray) -> np.ndarray | None:
        """ln f of the rests of codes (C, L): float32 (*`SHAPES[widths]`, C); None without rests."""
        if (self.gains(z) <= decoder.EMPTY_GAIN).all():
            return None
        features = self.features(*node_pairs(self.arch.widths))
        logs = [
            np.log(self.rest(z, features[start : start + BLOCK, None]))
            for start in range(0, len(features), BLOCK)
        ]
        return np.concatenate(logs).reshape(*SHAPES[self.arch.widths], len(z))
