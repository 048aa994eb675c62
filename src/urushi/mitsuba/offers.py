"""What a plugin tells the coat above it, besides its values."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import mitsuba as mi
import numpy as np

from urushi.material.material import Material
from urushi.measured.tabulated import MeasuredSurface
from urushi.nets.weights import Model
from urushi.textures.grid import TexelGrid


class Latents(Protocol):
    """The codes of a plugin, one per channel or a texture of them; see `latents.holders`."""

    @property
    def model(self) -> Model:
        """The networks that they belong to."""

    @property
    def channels(self) -> int:
        """Number of codes, one per channel."""

    @property
    def grid(self) -> TexelGrid | None:
        """The texture's grid; None: the same everywhere."""

    @property
    def material(self) -> Material | None:
        """The material of codes that are the same everywhere; None: they are a texture."""

    @property
    def anchors(self) -> "Latents":
        """The codes that coats are layered over."""

    def at(self, uv: np.ndarray) -> np.ndarray:
        """Codes (M, C, size) at points uv (M, 2)."""


@dataclass(frozen=True)
class Offer:
    """What a BSDF offers to a coat; by default nothing.

    Attributes:
        latents: its codes.
        measured: the measurement that it renders.
        lobes: from a surface interaction to the analytic lobes: six Dr.Jit floats for each channel,
            seven of an anisotropic BSDF (see `urushi.nets.lobe`); None if they are not known. Its
            values contain more than the lobe, unless it is `bare`.
        exact: the BSDF whose values a table holds, if they are others than the codes'; None: none.
        rotated: whether its tangent is turned about the normal.
    """

    latents: Latents | None = None
    measured: MeasuredSurface | None = None
    lobes: Callable[[Any], list[list] | None] = lambda si: None
    bare: bool = False
    exact: Callable[[], "mi.BSDF | None"] = lambda: None
    rotated: bool = False


@runtime_checkable
class Offering(Protocol):
    """A BSDF of this package."""

    def offer(self) -> Offer:
        """What it offers now; parameters may change it."""


def offer_of(bsdf: "mi.BSDF") -> Offer:
    """What a BSDF offers; Mitsuba's own offer nothing."""
    return bsdf.offer() if isinstance(bsdf, Offering) else Offer()


def tabulated(latents: Latents | None) -> Material | None:
    """The material of latents that are evaluated by a table, not by their codes; else None."""
    material = None if latents is None else latents.material
    return None if material is None or material.table is None else material
