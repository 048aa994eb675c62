"""Latent codes as a plugin holds them: one per channel, or a texture of them.

Both answer the same two questions: what evaluating and sampling at a surface interaction share, a
`Vertex`, and f of every channel there.
"""

from typing import ClassVar, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.nets.weights import Model
from urushi.render import twins
from urushi.render.network import only_where
from urushi.render.twins import Mixture


class Vertex(NamedTuple):
    """What depends on the position and on wi alone.

    Attributes:
        shares: of every channel's latent code in the decoder, a list of Dr.Jit floats.
        mixture: the proposal, that of the mean latent code over the channels.
    """

    shares: list[list]
    mixture: Mixture


class ConstantLatents:
    """One latent code per channel: the first layers' share of them is computed once, here."""

    DRJIT_STRUCT: ClassVar = {"_shares": list, "_proposal_share": list}  # for frozen functions

    def __init__(self, model: Model, latents: np.ndarray):
        """latents: (C, 32) float32."""
        self._latents = latents
        self._decoder, self._proposal = twins.of(model)
        self._shares = [_opaque(share) for share in self._decoder.first_layer(latents)]
        self._proposal_share = _opaque(self._proposal.first_layer(latents.mean(axis=0)))

    def vertex(self, si, active) -> Vertex:
        """The vertex at a surface interaction."""
        propose = self._proposal.of_first_layer
        return Vertex(self._shares, only_where(active, propose, self._proposal_share, si.wi.z))

    def f(self, vertex: Vertex, si, wo, active) -> list:
        """The BRDF [1/sr] of each channel for si.wi and wo above the horizon."""
        return only_where(active, self._decoder.of_first_layer, vertex.shares, si.wi, wo)

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

    def vertex(self, si, active) -> Vertex:
        """The vertex at a surface interaction."""
        return only_where(active, self._vertex, si.uv, si.wi.z)

    def f(self, vertex: Vertex, si, wo, active) -> list:
        """The BRDF [1/sr] of each channel for si.wi and wo above the horizon."""
        return only_where(active, self._decoder.of_first_layer, vertex.shares, si.wi, wo)

    def _vertex(self, uv, cos_i) -> Vertex:
        latents = self._look_up(uv)
        mean = [sum(values) * (1 / self._channels) for values in zip(*latents, strict=True)]
        mixture = self._proposal.of_latent(mean, cos_i)
        return Vertex([self._decoder.share(z) for z in latents], mixture)

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
