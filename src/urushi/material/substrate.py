"""BRDFs below coats: all that light transport through any coat needs of them, computed once."""

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from urushi.core.probe_pairs import ANISOTROPIC_PROBES, probe_pairs
from urushi.core.table import SHAPE, TAN2_OFFSET, node_pairs, squared_tangent
from urushi.material import adding, adding_quadrant
from urushi.material.material import Material
from urushi.material.reflector import Reflector
from urushi.nets import lobe as lobes
from urushi.nets.lobe_fit import fit_lobes

#: A lobe's width is where it has this part of its peak, as GGX has at tan theta_h = alpha.
PART_OF_PEAK = 0.25

#: Angles of total reflection are rounded to this step [rad]: coats of similar index share a grid.
EDGE_STEP = 1 / 32

#: Largest angle of total reflection at which a grid is divided: behind it is no room for nodes.
LAST_EDGE = 1.5


class OnGrid(NamedTuple):
    """BRDFs of one width and C channels on a grid of directions, see `adding`."""

    edges: adding.Edges  # of the medium above
    modes: np.ndarray  # (C, H, N, N)
    mirrored: np.ndarray  # (M, C) shares of light at `adding.MIRROR_COSINES` that is mirrored

    @classmethod
    def of(cls, reflector: Reflector, edges: adding.Edges) -> "OnGrid":
        """BRDFs on the grid with these edges."""
        own, modes = adding.grid(edges), adding.bottom_modes(reflector.f, edges)
        shares = np.stack([own.mirror_shares(m) for m in modes], axis=-1)
        return cls(edges, modes, own.at_cosines(shares))


@dataclass(frozen=True, eq=False)
class Substrate:
    """BRDFs of C channels below coats. Make it with `of`."""

    reflector: Reflector
    width: np.ndarray  # (C, 1), or (C, 2), of the brightest lobes; infinite without one
    of_slab: OnGrid | None = None  # on the grid of the medium of a slab

    @classmethod
    def of(cls, reflector: Reflector, of_slab: OnGrid | None = None) -> "Substrate":
        """The substrate of BRDFs."""
        if reflector.stretch2 is None:
            return cls(reflector, _widths(reflector)[:, None], of_slab)
        values = reflector.f(*probe_pairs(ANISOTROPIC_PROBES, 2))
        return cls(reflector, fit_lobes(values.T, 2)[:, lobes.WIDTH_PLACES[2]])

    @property
    def channels(self) -> int:
        """The number of channels, C."""
        return self.reflector.channels

    @functools.cached_property
    def ceiling(self) -> np.ndarray:
        """See `adding.ceilings`."""
        return adding.ceilings(self.reflector.f)

    @property
    def widths(self) -> int:
        """The number of GGX widths."""
        return 1 if self.reflector.stretch2 is None else 2

    def edges(self, eta: float) -> adding.Edges:
        """Of the medium below an interface of relative index eta: where it reflects totally.

        Those of coats are rounded to `EDGE_STEP`.
        """
        if self.of_slab is not None:
            return self.of_slab.edges
        angle = math.asin(1 / max(eta, 1.0))
        return (EDGE_STEP * round(angle / EDGE_STEP),) if angle < LAST_EDGE else ()

    def on_grid(self, channels: np.ndarray, edges: adding.Edges) -> OnGrid:
        """Channels (D,) of one width on the grid with these edges."""
        if self.of_slab is None:
            return _on_grid(self, tuple(channels), edges)
        return OnGrid(edges, self.of_slab.modes[channels], self.of_slab.mirrored[:, channels])


@functools.lru_cache(maxsize=4)
def of_material(material: Material) -> Substrate:
    """A material, without its rotation, as a substrate; it does not depend on the coat."""
    return Substrate.of(Reflector.of(material))


@functools.lru_cache(maxsize=16)
def _on_grid(below: Substrate, channels: tuple[int, ...], edges: adding.Edges) -> OnGrid:
    """See `Substrate.on_grid`."""
    return OnGrid.of(below.reflector.taken(channels), edges)


@functools.lru_cache(maxsize=64)
def parts_of(below: Substrate, channel: int) -> np.ndarray:
    """The parts (4, Q, Q) of a channel of two widths, see `adding_quadrant`."""
    return adding_quadrant.bottom_parts(below.reflector.taken([channel]).f)[0]


def _widths(reflector: Reflector) -> np.ndarray:
    """The widths (C,) of the brightest lobes."""
    some = np.ix_(np.arange(SHAPE[0]), np.arange(0, SHAPE[1] // 2, 4), np.arange(0, SHAPE[2], 3))
    pairs = (w.reshape(*SHAPE, 3)[some].reshape(-1, 3) for w in node_pairs(reflector.knots))
    values = reflector.f(*pairs).reshape(SHAPE[0], -1, reflector.channels)
    result = []
    for profile in np.log(values.mean(axis=1)).T:
        peak = int(profile.argmax())
        level = profile[peak] + np.log(PART_OF_PEAK)
        lower = peak + np.flatnonzero(profile[peak:] < level)
        if not len(lower):
            result.append(np.inf)
            continue
        last = lower[0]
        part = (profile[last - 1] - level) / (profile[last - 1] - profile[last])
        tan2 = squared_tangent((last - 1 + part) / (SHAPE[0] - 1))
        result.append(np.sqrt(max(tan2, TAN2_OFFSET)))
    return np.array(result)
