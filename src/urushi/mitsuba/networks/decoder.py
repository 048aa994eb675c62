"""The decoder in Dr.Jit: the counterpart of `nets.decoder`, for channels that share directions."""

from collections.abc import Sequence
from functools import partial

import drjit as dr
import numpy as np

from urushi.core.namespace import DRJIT
from urushi.core.table import MAX_LOG, MIN_LOG
from urushi.mitsuba.networks import lobe, mlp
from urushi.mitsuba.networks.basis import BasisDecoder
from urushi.mitsuba.networks.lobe import LobeKind
from urushi.nets.architecture import SCALE
from urushi.nets.features import DIRECTIONS, direction_columns
from urushi.nets.linear import LinearArchitecture
from urushi.nets.weights import Model


class UrushiDecoder:
    """f [1/sr] of latent codes: the lobe plus the decoded rest.

    The terms of a channel's code are the numbers of its lobe that `LobeKind.numbers` names, its
    gain, and the scales and the offsets of the units of the first hidden layer.
    """

    def __init__(self, model: Model, kind: LobeKind):
        """kind: common properties of the codes' lobes."""
        params = model.params
        self._hidden = partial(
            mlp.hidden_to_output, params, "decoder", activation=model.arch.activation
        )
        weight = params["decoder.0.weight"]
        self._lobe = model.arch.lobe
        self._kind = kind
        numbers = model.arch.latent - self._lobe - 1  # the gain bypasses the network
        self._response, self._width = weight[numbers:], model.arch.decoder[0]
        self._of_code = np.concatenate([params[SCALE], weight[:numbers]], axis=-1)
        self._bias = np.concatenate([np.ones(self._width, np.float32), params["decoder.0.bias"]])

    def code_terms(self, latents: np.ndarray) -> list[np.ndarray]:
        """Terms (K,) of the code of each channel, from codes (C, size)."""
        gain, z = latents[:, self._lobe, None], latents[:, self._lobe + 1 :]
        rest = np.concatenate([gain, z @ self._of_code + self._bias], axis=-1)
        return [
            np.concatenate([code[self._kind.numbers(c)], terms])
            for c, (code, terms) in enumerate(zip(latents, rest, strict=True))
        ]

    def code_terms_drjit(self, latents: Sequence[Sequence]) -> list[list]:
        """`code_terms` of codes given as lists (size) of Dr.Jit floats, one for each channel."""
        codes = [z[self._lobe + 1 :] for z in latents]
        rests = mlp.dense_each(codes, self._of_code, self._bias.tolist())
        return [
            [*(z[i] for i in self._kind.numbers(c)), z[self._lobe], *rest]
            for c, (z, rest) in enumerate(zip(latents, rests, strict=True))
        ]

    def f_of_terms(self, terms: Sequence[Sequence], wi, wo) -> list:
        """f of each channel, from a list of Dr.Jit floats, its terms, for each."""
        # The response to the directions is the same for all channels.
        widths = self._kind.widths
        features = DIRECTIONS[widths].each(direction_columns(wi, wo, widths, DRJIT))
        response = mlp.dense(features, self._response, [0.0] * self._width)
        count, rests = 1 + len(self._bias), []
        for channel in terms:
            gain, *units = channel[-count:]
            scales, offsets = units[: self._width], units[self._width :]
            first = [dr.fma(*values) for values in zip(scales, response, offsets, strict=True)]
            rests.append(dr.exp(dr.clip(gain + self._hidden(first)[0], MIN_LOG, MAX_LOG)))
        if not self._kind.present:
            return rests
        lobes = self._kind.complete([channel[:-count] for channel in terms])
        values = lobe.f(lobes, wi, wo, self._kind)
        return [a + b for a, b in zip(values, rests, strict=True)]

    def f(self, latents: Sequence[Sequence], wi, wo) -> list:
        """f of each channel, from a list (size) of Dr.Jit floats for each."""
        return self.f_of_terms(self.code_terms_drjit(latents), wi, wo)


def decoder_of(model: Model, kind: LobeKind) -> BasisDecoder | UrushiDecoder:
    """The decoder of codes of a model; kind: common properties of their lobes."""
    linear = isinstance(model.arch, LinearArchitecture)
    return BasisDecoder(model, kind) if linear else UrushiDecoder(model, kind)
