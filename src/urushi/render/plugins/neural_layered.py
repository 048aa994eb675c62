"""The plugin `neural_layered`: a coat over any BSDF, layered in the latent space."""

import mitsuba as mi

from urushi.errors import ParameterError
from urushi.render.latents import gradients
from urushi.render.latents.baking import Baker
from urushi.render.latents.holders import ConstantLatents, DifferentiableTexture, TexturedLatents
from urushi.render.plugins.base import read_weights
from urushi.render.reading.parameters import CoatTextures, check_bottom, nested_bsdf


def define(base: type) -> type:
    """Make the plugin's class in the current variant; base: of `define_neural_bsdf`."""

    class NeuralLayered(base):
        """A coated BSDF by neural networks, evaluated without noise (``neural_layered``).

        ============== ===================== ====================================================
        alpha          float, texture        GGX width of the coat's surface, 0.01 to 1.
                                             (Default: 0.1)
        int_ior        float, string,        Index of refraction inside the coat, a number, a
                       texture               material such as "water", or a texture of numbers.
                                             (Default: "bk7", 1.5046)
        ext_ior        float, string         Index outside; the ratio of both must be within 1.001
                                             to 3; ``layered`` takes ratios from 0.5 to 0.999 as
                                             well. (Default: "air", 1.000277)
        albedo         spectrum, texture     Single-scattering albedo of the coat's medium, 0 to 1.
                                             (Default: 0)
        sigma_t        spectrum, texture     Its optical depth, 0 or more: the coat has unit
                                             thickness. (Default: 0, clear)
        g              spectrum, texture     Asymmetry of its Henyey-Greenstein phase function,
                                             -1 to 1, both excluded. (Default: 0)
        (nested)       BSDF                  The bottom, under any name: any opaque BSDF that has
                                             no perfectly smooth lobe and no normals of its own;
                                             coats nest. Its values in air are used.
        resolution     integer               Texels per side of the latent texture if anything is
                                             textured. (Default: that of the largest texture, at
                                             most 2048; 256 for procedural ones)
        weights        string                File of the networks. (Default: the shipped
                                             ones, ``default``)
        mipmaps        boolean               Whether to build the mip pyramid of the latent texture:
                                             averages of it at lower resolutions, for integrators
                                             that compute derivatives of uv. Those that ship with
                                             Mitsuba do not. (Default: false)
        eta            float                 The ratio int_ior / ext_ior; exposed by
                                             ``mi.traverse``, not a property.
        ============== ===================== ====================================================

        Takes the parameters of ``layered``, its reference, and adds ``resolution``, ``weights`` and
        ``mipmaps``. When the scene is loaded, the bottom is evaluated at the encoder's probe pairs,
        averaged over azimuth and over the exchange of the directions, encoded, and layered by the
        network. Textures are baked in their own space if they share one ``to_uv``, otherwise over
        the unit square of uv, which repeats. A change through ``mi.traverse`` recomputes the codes
        that depend on it. The method ``save`` writes the codes to a file for ``neural_brdf``.
        Reflects on the front side only: nest it in ``twosided`` for both sides. Spectral variants
        treat the three channels as bands at 611, 549 and 464 nm, linear in between.

        Pictures can be differentiated with respect to all parameters, including the bottom's, by
        Mitsuba's differentiable integrators such as ``prb``: enable gradients of the parameters
        that ``mi.traverse`` lists, and update.

        .. tabs::
            .. code-tab:: xml

                <bsdf type="neural_layered">
                    <float name="alpha" value="0.05"/>
                    <rgb name="sigma_t" value="0.2, 1.0, 3.0"/>
                    <float name="albedo" value="0.8"/>
                    <bsdf type="roughconductor" name="base">
                        <string name="distribution" value="ggx"/>
                    </bsdf>
                </bsdf>

            .. code-tab:: python

                'type': 'neural_layered',
                'alpha': 0.05,
                'sigma_t': {'type': 'rgb', 'value': [0.2, 1.0, 3.0]},
                'albedo': 0.8,
                'base': {'type': 'roughconductor', 'distribution': 'ggx'}

        After Fan, Wang, Hašan, Yang and Yan, Neural Layered BRDFs, SIGGRAPH 2022.
        """

        latents: ConstantLatents | TexturedLatents | DifferentiableTexture

        def __init__(self, props):
            super().__init__(props)
            self._bottom = nested_bsdf(props)
            self._coat = CoatTextures(props)
            check_bottom(self._bottom, self._coat.where)
            resolution = int(props.get("resolution", 0))
            if resolution < 0:
                raise ParameterError(
                    f"{self._coat.where}: resolution is {resolution}; give texels per side, "
                    "or 0 to choose by the textures"
                )
            self.model = read_weights(props)
            self._resolution = resolution
            mipmaps = bool(props.get("mipmaps", False))
            self._baker = Baker(self.model, self._coat, self._bottom, resolution, mipmaps)
            self._baked = False  # whether the baker has the present bottom
            self._differentiable = mi.TensorXf()  # codes with gradients, for integrators
            self._bake()

        def _bake(self, bottom_changed=True):
            if gradients.wanted(self):
                self.latents = gradients.bake(
                    self.model, self._coat, self._bottom, self._resolution
                )
                self._baked = False
            else:
                self.latents = self._baker.update(bottom_changed or not self._baked)
                self._baked = True
            mi.set_property(self._differentiable, getattr(self.latents, "tensor", mi.TensorXf()))

        def traverse(self, callback):
            self._coat.traverse(callback, mi.ParamFlags.Differentiable)
            callback.put("bottom", self._bottom, mi.ParamFlags.Differentiable)
            callback.put("latents", self._differentiable, mi.ParamFlags.ReadOnly)

        def parameters_changed(self, keys):
            if keys == ["latents"]:
                return  # read-only: they are computed from the others
            self._check_changeable()
            self._coat.parameters_changed()
            self._bake(not keys or "bottom" in keys)

        def to_string(self):
            bottom = str(self._bottom).replace("\n", "\n  ")
            return (
                f"NeuralLayered[\n{self._coat},\n  latents = {self.latents},\n"
                f"  weights = {self.model.fingerprint},\n  bottom = {bottom}\n]"
            )

    return NeuralLayered
