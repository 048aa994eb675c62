"""What every measured BRDF is: something to evaluate, and the bottom of a coat's random walk."""

from abc import ABC, abstractmethod
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from urushi.reference.tabulated import Tabulated


class MeasuredSurface(ABC):
    """A measured BRDF; `f` evaluates it, `table` is what lies under a coat.

    It can be coated, `urushi.coat(urushi.load_measured(path), alpha, eta)`, as it has what the walk
    asks of a bottom.
    """

    @abstractmethod
    def f(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """Linear RGB, float32 (N, 3) [1/sr] without cosine, for unit vectors (N, 3)."""

    @abstractmethod
    def table(self) -> np.ndarray:
        """The reciprocal BRDF over half and difference angles, float32 (H, D, P, 3) [1/sr].

        See `urushi.measured.table`.
        """

    @cached_property
    def tabulated(self) -> "Tabulated":
        """The table in Dr.Jit, with lobes to draw directions from."""
        from urushi.reference.tabulated import Tabulated  # lazily: it starts Dr.Jit

        return Tabulated(self.table())

    def f_pdf(self, wi: Any, wo: Any) -> tuple[Any, Any]:
        """As of `urushi.reference.bottoms.Bottom`, on Dr.Jit arrays."""
        return self.tabulated.f_pdf(wi, wo)

    def sample(self, wi: Any, u0: Any, u1: Any, u2: Any) -> tuple[Any, Any, Any]:
        """As of `urushi.reference.bottoms.Bottom`, on Dr.Jit arrays."""
        return self.tabulated.sample(wi, u0, u1, u2)
