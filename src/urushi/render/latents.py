"""Latent codes as a plugin holds them: one per channel, or a texture of them.

Both answer the same two questions at a surface interaction: f of every channel, and the proposal's
mixture, which is that of the mean latent code over the channels.
"""

import os
from typing import ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.material import texture_files
from urushi.material.material import Material
from urushi.material.store import Store
from urushi.material.texture_files import Place
from urushi.nets.weights import Model
from urushi.render import twins
from urushi.render.grid import Grid
from urushi.render.latent_texture import LatentTexture
from urushi.render.twins import Mixture


class ConstantLatents:
    """One latent code per channel: the first layers' share of them is computed once, here."""

    DRJIT_STRUCT: ClassVar = {"_shares": list, "_proposal_share": list}  # for frozen functions

    def __init__(self, model: Model, latents: np.ndarray):
        """latents: (C, 32) float32."""
        self._model, self._latents = model, latents
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
    def channels(self) -> int:
        """Codes that it has."""
        return len(self._latents)

    @property
    def resolution(self) -> tuple[int, int] | None:
        """Width and height of the texture; None: the same everywhere."""
        return None

    @property
    def grid(self) -> Grid | None:
        """The texture's grid; None: the same everywhere."""
        return None

    def save(self, path: str | os.PathLike) -> None:
        """Write a file that `neural_brdf` and `urushi.load` read.

        Raises:
            FileError: it cannot be written.
        """
        Material(self._latents, self._model).save(path)

    def __str__(self) -> str:
        return f"{len(self._latents)} x {self._latents.shape[1]}"


class TexturedLatents:
    """A texture of latent codes in few bytes, see `material.packing`."""

    DRJIT_STRUCT: ClassVar = {"_texture": object}  # for frozen functions

    def __init__(self, model: Model, store: Store, grid: Grid):
        self._store, self._fingerprint = store, model.fingerprint
        self.grid, self.channels = grid, store.layout.channels
        self._size, self._bytes = store.layout.size, store.layout.texel_bytes
        self._decoder, self._proposal = twins.of(model)
        self._texture = LatentTexture(store, grid)

    def f(self, si, wo) -> list:
        """The BRDF [1/sr] of each channel for si.wi and wo above the horizon."""
        latents = self._look_up(si)
        return self._decoder.of_latents(latents, si.wi, wo)

    def mixture(self, si) -> Mixture:
        """The proposal for si.wi."""
        latents = self._look_up(si)
        mean = [sum(values) * (1 / self.channels) for values in zip(*latents, strict=True)]
        return self._proposal.of_latent(mean, si.wi.z)

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Latent codes (M, C, 32) at points uv (M, 2)."""
        latents = self._texture.look_up(mi.Point2f(np.ascontiguousarray(uv.T, np.float32)))
        dr.eval(latents)
        channels = [np.stack([value.numpy() for value in z], axis=-1) for z in latents]
        return np.stack(channels, axis=1)

    @property
    def resolution(self) -> tuple[int, int]:
        """Width and height of the texture."""
        return self.grid.width, self.grid.height

    def save(self, path: str | os.PathLike) -> None:
        """Write a file that `neural_brdf` reads.

        Raises:
            FileError: it cannot be written.
        """
        place = Place(self.grid.to_texture, self.grid.wrap, self.grid.nearest)
        texture_files.write(path, self._store, place, self._fingerprint)

    def _look_up(self, si) -> list[list]:
        # No mask beyond that of the caller's caller: equal look-ups, of f and of the mixture, of
        # one direction and of another, then become one.
        return self._texture.look_up(si.uv, si.duv_dx, si.duv_dy)

    def __str__(self) -> str:
        width, height = self.resolution
        return (
            f"{width} x {height} texels of {self.channels} x {self._size} numbers "
            f"in {self._bytes} bytes"
        )


def _opaque(values: np.ndarray) -> list:
    """Dr.Jit scalars that kernels read from memory, so that all materials share their code."""
    scalars = [mi.Float(float(value)) for value in values]
    dr.make_opaque(scalars)
    return scalars
