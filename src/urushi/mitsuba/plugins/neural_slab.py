"""The plugin `neural_layered` over what transmits light: a slab by tables, without noise."""

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core.namespace import DRJIT
from urushi.errors import ParameterError
from urushi.material.slab_table import PASSED_SHAPE, passed_coordinates, slab_tables
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents import gradients
from urushi.mitsuba.latents.holders import ConstantLatents
from urushi.mitsuba.networks.table import interpolated, padded
from urushi.mitsuba.plugins.base import ignore
from urushi.mitsuba.plugins.coated import define_coated
from urushi.mitsuba.plugins.coats import CoatStack, raised
from urushi.mitsuba.recording import only_where, owned
from urushi.nets.weights import default_model


def define(base: type) -> type:
    """Make the plugin's class in the current variant; base: of `define_proposal_bsdf`."""

    coated: type = define_coated(base, "NeuralLayered")

    class NeuralSlab(coated):
        """A slab of constant parameters; see ``layered``."""

        def __init__(self, props):
            super().__init__(props)
            ignore(props, "resolution", "weights", "mipmaps")
            self._tabulate()

        def _update(self, keys):
            if gradients.wanted(self):
                raise ParameterError(
                    f"{self._where}: a parameter carries gradients, but the tables of a slab have "
                    "no derivatives; disable them, and take differences of two pictures"
                )
            super()._update(keys)
            self._tabulate()

        def _tabulate(self):
            """Compute the tables."""
            reason = None
            coats, lowest = self.coats, self.lowest
            if any(x.is_anisotropic for x in (*coats, lowest) if x) or any(
                x.coloured for x in coats
            ):
                reason = "a slab has a table for one width of each interface"
            for layer in (*coats, lowest):
                for name, texture in () if layer is None else layer.textures.items():
                    if texture.is_spatially_varying():
                        reason = f"{name} is a texture, but the tables of a slab are of constants"
            if reason is not None:
                raise ParameterError(
                    f"{self._where}: {reason}; use the plugin 'layered', which walks through any"
                )
            rows = [coat.layering(np.full((1, 2), 0.5)) for coat in coats]
            si = dr.zeros(mi.SurfaceInteraction3f)
            far = self._lowest_at(CoatStack(coats, si, True), si, True)
            interfaces = [(*row.alpha.flat, *row.eta.flat) for row in rows]
            interfaces.append((float(far.alpha[0]), float(far.eta[0])))
            media = [np.broadcast_arrays(*row[2:]) for row in rows]
            channels = max(medium[0].size for medium in media)
            columns = [[np.broadcast_to(x.ravel(), channels) for x in medium] for medium in media]
            tables = slab_tables(default_model(), np.array(interfaces), np.array(columns))
            above, below = tables.reflected
            sides = (above,) if above is below else (above, below)
            self._reflected = [ConstantLatents(side) for side in sides]
            self._passed, self._ratio = owned(mi.Float, padded(tables.passed)), tables.eta

        def _f(self, vertex, ctx, si, wo, active):
            inside, up = mi.SurfaceInteraction3f(si), raised(wo)
            inside.wi = raised(si.wi)
            upper = si.wi.z > 0
            sides = [side.f(side.bare_vertex(si), inside, up, active) for side in self._reflected]
            channels = [dr.select(upper, x[0], x[-1]) for x in zip(*sides, strict=True)]

            def passed(a, b):
                places = passed_coordinates(a, b, self._ratio, DRJIT)
                logs = interpolated(self._passed, PASSED_SHAPE, [dr.clip(x, 0, 1) for x in places])
                return [dr.exp(log) for log in logs[: len(channels)]]

            pair = dr.select(upper, inside.wi, up), dr.select(upper, up, inside.wi)
            through = only_where(active, passed, *pair)
            side = wo if ctx.mode == mi.TransportMode.Importance else si.wi
            scale = dr.select(side.z < 0, dr.square(self._index), 1)
            crosses = si.wi.z * wo.z < 0
            found = [
                dr.select(crosses, t * scale, r) for t, r in zip(through, channels, strict=True)
            ]
            return spectrum.from_channels(found, si.wavelengths, None)

    return NeuralSlab
