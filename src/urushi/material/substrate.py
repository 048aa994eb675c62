"""BRDFs below coats: all that light transport through any coat needs of them, computed once."""

import functools
from dataclasses import dataclass

import numpy as np

from urushi.checks import Widths
from urushi.core.probe_pairs import ANISOTROPIC_PROBES, probe_pairs
from urushi.core.table import HIGHEST, LOWEST, SHAPE, TAN2_OFFSET, node_pairs
from urushi.material import adding, adding_quadrant
from urushi.material.material import Material
from urushi.material.reflector import Reflector
from urushi.nets import lobe as lobes
from urushi.nets.lobe_fit import fit_lobes

#: A lobe's width is where it has this part of its peak, as GGX has at tan theta_h = alpha.
PART_OF_PEAK = 0.25

#: Tilt of half vectors by an interface, over the width of a lobe, above which the lobe is narrow.
LEAST_TILT = 0.04


@dataclass(frozen=True, eq=False)
class Substrate:
    """BRDFs of C channels below coats. Make it with `of`."""

    reflector: Reflector
    width: np.ndarray  # (C,), or (C, 2), of the brightest lobes; infinite without one
    modes: np.ndarray | None  # (C, H, N, N), see `adding`; None: of two widths
    mirrored: np.ndarray  # (M, C) shares of light at `adding.COSINES` that it mirrors
    edges: adding.Edges = ()  # of the medium above it

    @classmethod
    def of(
        cls,
        reflector: Reflector,
        modes: np.ndarray | None = None,
        mirrored: np.ndarray | None = None,
        edges: adding.Edges = (),
    ) -> "Substrate":
        """The substrate of BRDFs; of a slab with these edges, its modes and what it mirrors."""
        if reflector.stretch2 is not None:
            values = reflector.f(*probe_pairs(ANISOTROPIC_PROBES, 2))
            width = fit_lobes(values.T, 2)[:, lobes.WIDTH_PLACES[2]]
            return cls(reflector, width, None, np.zeros((1, reflector.channels)))
        if modes is None:
            modes = adding.bottom_modes(reflector.f, edges)
        if mirrored is None:
            own = adding.grid(edges)
            mirrored = own.at_cosines(np.stack([own.mirror_shares(m) for m in modes], axis=-1))
        return cls(reflector, _widths(reflector), modes, mirrored, edges)

    @property
    def channels(self) -> int:
        """The number of channels, C."""
        return self.reflector.channels

    @property
    def widths(self) -> int:
        """The number of GGX widths."""
        return 1 if self.modes is not None else 2

    def narrow(self, alpha: np.ndarray, eta: np.ndarray, channels: np.ndarray) -> np.ndarray:
        """Whether the lobes of channels (D,) are narrow below interfaces (D,), of widths alpha."""
        narrowest = self.width.reshape(self.channels, -1).min(axis=1)
        return np.abs(1 - 1 / eta) * alpha > LEAST_TILT * narrowest[channels]

    def turned_back(
        self, channel: int, alpha: float | Widths, eta: float, layers: np.ndarray
    ) -> tuple[np.ndarray, float]:
        """Light that media (k, 3) or an interface above turn back, and the optical depth.

        Returns:
            float32, ln f at the nodes of the table for one width, f of `adding_quadrant.table` for
            two; and the depth that attenuates light from the bottom.
        """
        if self.modes is None:
            (layer,) = layers
            medium = adding.resolved(*layer)
            back = adding_quadrant.interface_parts(alpha, eta)
            values = adding_quadrant.seen_inside(_parts_of(self, channel), back, medium)
            return adding_quadrant.table(values), medium[1]
        back = adding.interface_modes(alpha, eta, self.edges)
        values, depth = adding.seen_inside(self.modes[channel], back, layers, self.edges)
        places = self.edges, self.reflector.knots
        at_nodes = adding.at_nodes(values, *places) + adding.backward_peaks(layers, *places)
        return np.log(np.maximum(at_nodes, 1e-30)), depth


@functools.lru_cache(maxsize=4)
def of_material(material: Material) -> Substrate:
    """A material, without its rotation, as a substrate; it does not depend on the coat."""
    return Substrate.of(Reflector.of(material))


@functools.lru_cache(maxsize=16)
def _parts_of(below: Substrate, channel: int) -> np.ndarray:
    """The parts of a channel of two widths, see `adding_quadrant`."""
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
        u = (last - 1 + part) / (SHAPE[0] - 1)
        tan2 = np.exp(LOWEST + u * (HIGHEST - LOWEST)) - TAN2_OFFSET
        result.append(np.sqrt(max(tan2, TAN2_OFFSET)))
    return np.array(result)
