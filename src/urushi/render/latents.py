"""Latent codes as a plugin holds them: one per channel, or a texture of them.

Both answer the same two questions at a surface interaction: f of every channel, and the proposal's
mixture, which is that of the mean latent code over the channels.
"""

from typing import ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.nets.weights import Model
from urushi.render import twins
from urushi.render.twins import Mixture


class ConstantLatents:
    """One latent code per channel: the first layers' share of them is computed once, here."""

    DRJIT_STRUCT: ClassVar = {"_shares": list, "_proposal_share": list}  # for frozen functions

    def __init__(self, model: Model, latents: np.ndarray):
        """latents: (C, 32) float32."""
        self._latents = latents
        self._decoder, self._proposal = twins.of(model)
        self._shares = [_opaque(share) for share in self._decoder.first_layer(latents)]
        self._proposal_share = _opaque(self._proposal.first_layer(latents.mean(axis=0)))

    def f(self, si, wo) -> list:
        """The BRDF [1/sr] of each channel for si.wi and wo above the horizon."""
        return self._decoder.of_first_layer(self._shares, si.wi, wo)

    def mixture(self, si) -> Mixture:
        """The proposal for si.wi."""
        return self._proposal.of_first_layer(self._proposal_share, si.wi.z)

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Latent codes (M, C, 32) at points uv (M, 2)."""
        return np.broadcast_to(self._latents, (len(uv), *self._latents.shape))

    @property
    def resolution(self) -> tuple[int, int] | None:
        """Width and height of the texture; None: the same everywhere."""
        return None

    def __str__(self) -> str:
        return f"{len(self._latents)} x {self._latents.shape[1]}"


class TexturedLatents:
    """A bilinear, repeating texture of latent codes in half precision.

    Half precision costs 5e-4 of a code's size and makes look-ups twice as fast as single.
    """

    DRJIT_STRUCT: ClassVar = {"_texture": object}  # for frozen functions

    def __init__(self, model: Model, latents: np.ndarray):
        """latents: (height, width, C, 32); the texel (y, x) lies at uv = (x, y) + 1/2."""
        height, width, self._channels, self._size = latents.shape
        self._decoder, self._proposal = twins.of(model)
        self._shape = (width, height)
        self._texture = mi.Texture2f16(
            mi.TensorXf16(latents.reshape(height, width, -1).astype(np.float16)),
            use_accel=False,
            filter_mode=dr.FilterMode.Linear,
            wrap_mode=dr.WrapMode.Repeat,
        )

    def f(self, si, wo) -> list:
        """The BRDF [1/sr] of each channel for si.wi and wo above the horizon."""
        latents = self._look_up(si.uv)
        return self._decoder.of_latents(latents, si.wi, wo)

    def mixture(self, si) -> Mixture:
        """The proposal for si.wi."""
        latents = self._look_up(si.uv)
        mean = [sum(values) * (1 / self._channels) for values in zip(*latents, strict=True)]
        return self._proposal.of_latent(mean, si.wi.z)

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Latent codes (M, C, 32) at points uv (M, 2)."""
        latents = self._look_up(mi.Point2f(np.ascontiguousarray(uv.T)))
        dr.eval(latents)
        channels = [np.stack([value.numpy() for value in z], axis=-1) for z in latents]
        return np.stack(channels, axis=1)

    @property
    def resolution(self) -> tuple[int, int]:
        """Width and height of the texture."""
        return self._shape

    def _look_up(self, uv) -> list[list]:
        # No mask beyond that of the caller's caller: equal look-ups, of f and of the mixture, of
        # one direction and of another, then become one.
        values = [mi.Float(value) for value in self._texture.eval(uv)]
        return [values[i : i + self._size] for i in range(0, len(values), self._size)]

    def __str__(self) -> str:
        width, height = self._shape
        return f"{width} x {height} texels of {self._channels} x {self._size}"


def _opaque(values: np.ndarray) -> list:
    """Dr.Jit scalars that kernels read from memory, so that all materials share their code."""
    scalars = [mi.Float(float(value)) for value in values]
    dr.make_opaque(scalars)
    return scalars
