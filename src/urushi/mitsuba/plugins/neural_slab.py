"""The plugin `neural_layered` without a nested BSDF: a thin slab by tables, without noise."""

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import CoatParameters
from urushi.errors import ParameterError
from urushi.material.slab_table import slab_materials
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents import gradients
from urushi.mitsuba.latents.holders import ConstantLatents
from urushi.mitsuba.plugins.base import ignore
from urushi.mitsuba.plugins.coated import define_coated
from urushi.mitsuba.plugins.coats import raised
from urushi.nets.weights import default_model


def define(base: type) -> type:
    """Make the plugin's class in the current variant; base: of `define_proposal_bsdf`."""

    coated: type = define_coated(base, "NeuralLayered", widened=True, slabs=True)

    class NeuralSlab(coated):
        """A thin slab of constant parameters, the same from both sides; see ``layered``."""

        def __init__(self, props):
            super().__init__(props)
            ignore(props, "resolution", "weights", "mipmaps")

        def _prepare(self):
            super()._prepare()
            materials = slab_materials(default_model(), self._parameters())
            self._reflected, self._transmitted = map(ConstantLatents, materials)

        def _update(self, keys):
            if gradients.wanted(self):
                raise ParameterError(
                    f"{self._where}: a parameter carries gradients, but the tables of a slab have "
                    "no derivatives; disable them, and take differences of two pictures"
                )
            super()._update(keys)

        def _parameters(self) -> CoatParameters:
            """The slab's parameters, (C,) or (1,).

            Raises:
                ParameterError: one is out of range, or no table has them.
            """
            textures = self._coat.textures
            reason = None
            if self._coat.is_anisotropic or self._coat.coloured:
                reason = "a slab has a table for one width alone"
            for name, texture in textures.items():
                if texture.is_spatially_varying():
                    reason = f"{name} is a texture, but the tables of a slab are of constants"
            if reason is not None:
                raise ParameterError(
                    f"{self._where}: {reason}; use the plugin 'layered', which walks through any"
                )
            values = self._coat.layering(np.full((1, 2), 0.5))
            return CoatParameters(**{name: value[0] for name, value in values.items()})

        def _f(self, vertex, ctx, si, wo, active):
            inside, up = mi.SurfaceInteraction3f(si), raised(wo)
            inside.wi = raised(si.wi)
            through = si.wi.z * wo.z < 0
            channels = [
                dr.select(through, passed, reflected)
                for reflected, passed in zip(
                    self._reflected.f(self._reflected.bare_vertex(si), inside, up, active),
                    self._transmitted.f(self._transmitted.bare_vertex(si), inside, up, active),
                    strict=True,
                )
            ]
            return spectrum.from_channels(channels, si.wavelengths, None)

    return NeuralSlab
