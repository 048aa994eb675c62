"""The plugin `neural_layered` over what transmits light: a slab by tables, without noise."""

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.core.mixture import Mixture
from urushi.core.namespace import DRJIT
from urushi.core.table import MIN_COSINE
from urushi.errors import ParameterError
from urushi.material.slab_coordinates import (
    PASSED_SHAPE,
    grazing_factor,
    mirrored_inside,
    passed_coordinates,
)
from urushi.material.slab_table import SlabTables, slab_tables
from urushi.mitsuba import spectrum
from urushi.mitsuba.frames import SlabMixture, above_surface, raised
from urushi.mitsuba.plugins.coated import CoatedSurface
from urushi.mitsuba.plugins.stack import CoatStack, width
from urushi.mitsuba.reading.grid import varying_textures
from urushi.mitsuba.recording import only_where, opaque, owned
from urushi.mitsuba.snapshot import has_gradients
from urushi.mitsuba.tables import Interpolated, interpolated, padded, stored, tabulated
from urushi.walk import interface

#: Quantiles of the half angles at which lobes are sampled, and the weights of these lobes and of a
#: cosine lobe. The first is for a narrow lobe that has a small part of the light.
QUANTILES, WEIGHTS = (0.03, 0.25, 0.5, 0.8), (0.12, 0.3, 0.28, 0.2, 0.1)

#: Rows of media that can be differentiated, and their largest value.
LARGEST = {"albedo": 1, "sigma_t": np.inf}

#: Half of the step of a difference, relative to 1 + the number.
STEP = 0.02

#: Cosines for which proposals are computed, and the least and largest share of reflected samples.
ELEVATIONS, SHARES = 33, (0.03, 0.97)


def _lobes(tables: SlabTables) -> np.ndarray:
    """Proposals (2, `ELEVATIONS`, 9), of each side and the root of the cosine of wi.

    The share that is reflected, within `SHARES`; and widths at `QUANTILES` of the half angles, of
    reflected light and of transmitted light, as `stack.BottomLobes`.
    """
    found = np.empty((2, ELEVATIONS, 1 + 2 * len(QUANTILES)), np.float32)
    sides = 1 if tables.reflected[0] is tables.reflected[1] else 2
    for side, row in np.ndindex(sides, ELEVATIONS):
        cosine = max((row / (ELEVATIONS - 1)) ** 2, MIN_COSINE)
        wi = np.array([(1 - cosine**2) ** 0.5, 0, cosine * (1 - 2 * side)])
        both = [(tangents, power.mean(axis=1)) for tangents, power in tables.powers(wi)]
        widths = [width(*x, q, ((1 - q) / q) ** 0.5) for x in both for q in QUANTILES]
        found[side, row] = both[0][1].sum() / sum(power.sum() for _, power in both), *widths
    found[sides:] = found[0]
    found[..., 0] = found[..., 0].clip(*SHARES)
    found[..., 1:] = found[..., 1:].clip(MIN_ALPHA / 4, 1)
    return found


class NeuralSlab(CoatedSurface):
    """A slab of constant parameters; see ``layered``."""

    def _prepare(self):
        """Compute the tables."""
        super()._prepare()
        reason, coats = None, self.coats
        layers: list[Any] = [*coats] if self.lowest is None else [*coats, self.lowest]
        if any(x.is_anisotropic for x in layers) or any(x.coloured for x in coats):
            reason = "a slab has a table for one width of each interface"
        for name, texture in (item for layer in layers for item in layer.textures.items()):
            if varying_textures(texture):
                reason = f"{name} is a texture, but the tables of a slab are of constants"
        if reason is not None:
            raise ParameterError(
                f"{self._where}: {reason}; use the plugin 'layered', which walks through any"
            )
        rows = [coat.layering(spectrum.MIDDLE) for coat in coats]
        si = dr.zeros(mi.SurfaceInteraction3f)
        far = self._lowest_at(CoatStack(coats, si, True), si, True)
        interfaces = [(*row.alpha.flat, *row.eta.flat) for row in rows]
        interfaces.append((float(far.alpha[0]), float(far.eta[0])))
        channels = max(x.size for row in rows for x in row[2:])
        media = np.array([[np.broadcast_to(x.ravel(), channels) for x in row[2:]] for row in rows])
        tables = slab_tables(np.array(interfaces), media)
        above, below = tables.reflected
        wanted = has_gradients(self)
        sides = (above, below) if wanted or above is not below else (above,)
        self._reflected = [stored(np.asarray(side.table), not wanted) for side in sides]
        self._knots, self._channels = [side.knots for side in sides], channels
        self._passed = stored(tables.passed, not wanted)
        self._indices, self._surfaces = tables.indices, tables.faces
        self._depths = [[opaque(x) for x in side] for side in tables.depths.tolist()]
        self._interreflection = tables.inner
        self._lobes = Interpolated(_lobes(tables))
        self._attach(np.array(interfaces), media)

    def _attach(self, interfaces: np.ndarray, media: np.ndarray):
        """Add derivatives by albedo and sigma_t to the tables: differences of two slabs.

        Channels do not mix: those of a colour change together.
        """
        si, found = dr.zeros(mi.SurfaceInteraction3f), []
        for level, coat in enumerate(self.coats):
            for name, numbers in coat.at(si).items():
                if dr.grad_enabled(numbers):
                    found.append((level, name, numbers))
        wrong = has_gradients(self) and not found
        if wrong or (mi.is_spectral and found) or any(x[1] not in LARGEST for x in found):
            raise ParameterError(
                f"{self._where}: a parameter carries gradients, but tables of slabs have "
                "derivatives by albedo and sigma_t only, and none of spectra; disable others"
            )
        for level, name, numbers in found:
            row, ends = list(LARGEST).index(name), np.stack([media, media])
            moved = media[level, row] + np.array([[-STEP], [STEP]]) * (1 + media[level, row])
            ends[:, level, row] = moved.clip(0, LARGEST[name])
            low, high = (slab_tables(interfaces, end) for end in ends)
            step = (ends[1] - ends[0])[level, row]

            changes = [number - dr.detach(number) for number in numbers]
            changes *= len(step) // len(numbers)

            def change(a, b, step=step, changes=changes):
                slopes = padded((b.astype(np.float32) - a) / step)
                channel = dr.arange(mi.UInt32, slopes.size) % slopes.shape[-1]
                total = mi.Float(0)
                for c, number in enumerate(changes):
                    total += dr.select(channel == c, number, 0)
                return total * owned(mi.Float, slopes)

            reflected = zip(self._reflected, low.reflected, high.reflected, strict=False)
            self._reflected = [x + change(a.table, b.table) for x, a, b in reflected]
            self._passed = self._passed + change(low.passed, high.passed)
            slopes = (high.depths - low.depths) / step
            self._depths = [
                [x + slope * y for x, slope, y in zip(*side, changes, strict=True)]
                for side in zip(self._depths, slopes.tolist(), strict=True)
            ]

    def _f(self, vertex, ctx, si, wo, active):
        inside, up = above_surface(si), raised(wo)
        upper = si.wi.z > 0

        def of_side(pairs):
            return [dr.select(upper, *pair) for pair in zip(*pairs, strict=True)]

        def reflected(a, b, upper, face, inner, depths):
            sides = zip(self._reflected, self._knots, strict=True)
            rests = [tabulated(x, self._channels, a, b, knots) for x, knots in sides]
            rests = [dr.select(upper, x[0], x[-1]) for x in zip(*rests, strict=True)]
            factor, inverse = mirrored_inside(a, b, inner, DRJIT), dr.rcp(a.z) + dr.rcp(b.z)
            lobe = interface.reflection(a, b, *face)
            return [
                rest * factor + lobe * dr.exp(-depth * inverse)
                for rest, depth in zip(rests, depths, strict=True)
            ]

        numbers = (
            upper,
            of_side(self._surfaces),
            [of_side(pairs) for pairs in zip(*self._interreflection, strict=True)],
            of_side(self._depths),
        )
        channels = only_where(active, reflected, inside.wi, up, *numbers)

        def passed(a, b):
            places = passed_coordinates(a, b, self._indices, DRJIT)
            logs = interpolated(self._passed, PASSED_SHAPE, [dr.clip(x, 0, 1) for x in places])
            scale = grazing_factor(a, b, self._surfaces, DRJIT)
            return [dr.exp(log) * scale for log in logs[: self._channels]]

        pair = dr.select(upper, inside.wi, up), dr.select(upper, up, inside.wi)
        through = only_where(active, passed, *pair)
        side = wo if ctx.mode == mi.TransportMode.Importance else si.wi
        scale = dr.select(side.z < 0, dr.square(self._index), 1)
        crosses = si.wi.z * wo.z < 0
        found = [dr.select(crosses, t * scale, r) for t, r in zip(through, channels, strict=True)]
        return spectrum.from_channels(found, si.wavelengths)

    def _proposal(self, vertex, si, active):
        sides = [self._lobes([dr.sqrt(dr.abs(si.wi.z)), side]) for side in (0.0, 1.0)]
        reflected, *widths = (dr.select(si.wi.z > 0, *pair) for pair in zip(*sides, strict=True))
        count = len(QUANTILES)
        near, far = (Mixture(WEIGHTS, part) for part in (widths[:count], widths[count:]))
        return SlabMixture(near, far, reflected, self._index_across(si.wi))
