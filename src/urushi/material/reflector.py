"""BRDFs of many channels, evaluated by one Dr.Jit kernel: tables beside lobes.

A table is `core.table`'s of one GGX width, or the sum of `core.stretched` of two. Its tables of
factors are contracted with the codes first, where `Networks.f` computes all functions of the basis.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import Widths
from urushi.core import lanes, microfacet
from urushi.core.lanes import Lane
from urushi.core.namespace import DRJIT
from urushi.core.stretched import stretched
from urushi.core.table import MAX_LOG, MIN_LOG, SHAPE, Knots
from urushi.material.material import Material
from urushi.nets import lobe as lobes
from urushi.nets.transmittance import has_edges, transmittance


class Reflector(NamedTuple):
    """BRDFs of C channels, the sums of a table and of M lobes.

    The table holds f without the lobes, divided by T(wi) T(wo) of the first one
    (`nets.transmittance`).
    """

    terms: np.ndarray  # float32 (C, T, U, V, W), logarithms: of `core.stretched` T is 1 + `FACTORS`
    lobe: np.ndarray  # float32 (C, M, N), see `nets.lobe`
    stretch2: np.ndarray | None = None  # (C,) of two widths, see `core.stretched`
    knots: Knots = ()  # of the tables
    darkened: bool = True  # whether T(wi) T(wo) is a factor of the table

    @classmethod
    def of(cls, material: Material) -> "Reflector":
        """The BRDFs of a material, without its rotation."""
        z, own = material.latents, material.model.arch.lobe
        lobe = z[:, :own] if material.table is None or material.beside_lobe else None
        stretch2 = np.exp(2 * z[:, -1]) if material.model.widths == 2 else None
        return cls.of_logs(material.logs(), lobe, stretch2)

    @classmethod
    def of_logs(
        cls,
        logs: np.ndarray,
        lobe: np.ndarray | None = None,
        stretch2: np.ndarray | None = None,
        knots: Knots = (),
    ) -> "Reflector":
        """From logarithms (U, V, W, C), or (U, V, W, C, T), and lobes (C, N), or (C, M, N)."""
        terms = logs.astype(np.float32).reshape(*SHAPE, logs.shape[3], -1)
        count = len(terms[0, 0, 0])
        lobe = np.empty((count, 0, 6)) if lobe is None else lobe.reshape(count, -1, lobe.shape[-1])
        return cls(np.moveaxis(terms, (3, 4), (0, 1)), lobe.astype(np.float32), stretch2, knots)

    @property
    def channels(self) -> int:
        """The number of channels, C."""
        return len(self.terms)

    def taken(self, chosen: Sequence[int] | np.ndarray) -> "Reflector":
        """Some of the channels."""
        rows = np.asarray(chosen)
        stretch2 = None if self.stretch2 is None else self.stretch2[rows]
        return self._replace(terms=self.terms[rows], lobe=self.lobe[rows], stretch2=stretch2)

    def contents(self) -> bytes:
        """What equal channels share."""
        arrays = self.terms, self.lobe, self.stretch2
        return b"".join(x.tobytes() for x in arrays if x is not None)

    def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """f float32 (N, C) [1/sr] at float32 pairs (N, 3) above the horizon."""

        def value(lane: Lane) -> Any:
            return self.in_lane(lane)(*lane.directions())[0]

        return lanes.sums(value, self.channels, (wi, wo), 1)

    def in_lane(self, lane: Lane) -> Callable[[Any, Any], tuple[Any, tuple[Any, ...]]]:
        """f of the lane's job, and the coordinates of the table, as a function of directions.

        The jobs are the channels.
        """
        stretch2 = 1.0 if self.stretch2 is None else lane.number(self.stretch2)
        first, *others = (lane.table(self.terms[:, k]) for k in range(self.terms.shape[1]))
        numbers = [[lane.number(x) for x in lobe.T] for lobe in self.lobe.swapaxes(0, 1)]
        edged = self.darkened and has_edges(self.lobe[:, :1]).any()

        def at(wi: Any, wo: Any) -> tuple[Any, tuple[Any, ...]]:
            both = wi + wo
            places, factors = stretched(both, wi - wo, stretch2, DRJIT, self.knots)
            log = first(places)
            if others:
                more = zip(others, factors, strict=True)
                log = sum((term(places) * factor for term, factor in more), log)
                log = DRJIT.clip(log, MIN_LOG, MAX_LOG)
            value, cosine = DRJIT.exp(log), microfacet.facet_cosine(both, DRJIT)
            for place, (along, *fresnel) in enumerate(numbers):
                across = fresnel.pop() if self.stretch2 is not None else None
                alpha = along if across is None else Widths(along, across)
                if not place and edged:
                    for w in (wi, wo):
                        value = value * transmittance(alpha, fresnel[2:], w, DRJIT)
                shape = microfacet.lobe_shape(alpha, wi, wo, both, DRJIT)
                value = value + shape * lobes.reflectance_of(fresnel, cosine, DRJIT)
            return value, places

        return at
