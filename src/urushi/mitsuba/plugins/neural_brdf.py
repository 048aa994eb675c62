"""The plugin `neural_brdf`: a material that was saved as latent codes."""

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi import files
from urushi.errors import ParameterError
from urushi.material import Material, load
from urushi.material.layer import under as below_medium
from urushi.mitsuba import spectrum
from urushi.mitsuba.frames import Turn
from urushi.mitsuba.latents.codes import ConstantLatents
from urushi.mitsuba.latents.over_axes import AxisLatents, texel_axes
from urushi.mitsuba.properties import path_of, read_weights
from urushi.mitsuba.recording import opaque, owned
from urushi.mitsuba.surface import KnownSurface, Surface
from urushi.nets.weights import Model
from urushi.textures.baking import Baked
from urushi.textures.store import KIND, read_texture, write_texture


class EncodedSurface(Surface):
    """A surface given by latent codes; subclasses set `model` and `latents`."""

    model: Model
    latents: ConstantLatents | AxisLatents
    _colors = False  # whether three channels are colours, see `spectrum.from_channels`

    def known(self):
        return KnownSurface(self.latents)

    def _vertex(self, si, active):
        return self.latents.vertex(si, active)

    def _proposal(self, vertex, si, active):
        return vertex.proposal

    def _f_and_pdf(self, vertex, ctx, si, wo, active):
        channels, pdf = self.latents.f_and_pdf(vertex, si, wo, active)
        return spectrum.from_channels(channels, si.wavelengths, colors=self._colors), pdf


class NeuralBRDF(EncodedSurface):
    """A saved material (``neural_brdf``).

    ============== ===================== ====================================================
    filename       string                File that ``urushi.Material.save`` wrote, or the
                                         method ``save`` of a ``neural_layered``, textures
                                         included; relative to the scene file. (Required)
    weights        string                File of the basis that the material was encoded
                                         with. (Default: the shipped one)
    rotation       float, texture        Angle by which the tangent of an anisotropic material
                                         is turned about the normal, counter-clockwise from
                                         dp/du of the shape, in degrees; it is added to that of
                                         the file. (Default: 0)
    latents        tensor                The latent codes (channels, L), differentiable;
                                         exposed by ``mi.traverse``, not a property, and not
                                         for textures. Edited codes also replace the material's
                                         table.
    ============== ===================== ====================================================

    The material may come from a description, a simulation, a measurement or a function, and
    may be coated and blended: see ``urushi.encode``, ``urushi.layer`` and ``urushi.lerp``.
    Spectral variants also load the 56 bands that a ``neural_layered`` saved in one.

    .. tabs::
        .. code-tab:: xml

            <bsdf type="neural_brdf">
                <string name="filename" value="lacquer.safetensors"/>
            </bsdf>

        .. code-tab:: python

            'type': 'neural_brdf',
            'filename': 'lacquer.safetensors'

    After Fan, Wang, Hašan, Yang and Yan, Neural Layered BRDFs, SIGGRAPH 2022.
    """

    PROPERTIES = ("filename", "weights", "rotation")

    _colors = True

    def _load(self, props):
        if "filename" not in props:
            raise ParameterError(
                f"{self._where} has no filename; give the file of a material saved by Material.save"
            )
        self._filename = props["filename"]
        model = read_weights(props)
        path, angle = path_of(props, "filename"), 0.0
        self._texture = None
        if files.tensor_file_kind(path) == KIND:
            self._texture = texture, grid, self.model = read_texture(path, model)
            codes = texture.codes()
            self.latents = AxisLatents(Baked.of_texels(self.model, codes, grid), texel_axes(grid))
        else:
            self._material = material = load(path, model)
            self.model, angle, codes = material.model, material.rotation, material.latents
            self._tensor = mi.TensorXf(owned(mi.Float, codes), codes.shape)
            self.latents = ConstantLatents(material)
        bands, channels = (spectrum.COUNT,) if mi.is_spectral else (), codes.shape[-2]
        if channels not in (1, 3, *bands):
            raise ParameterError(
                f"{self._where}: '{self._filename}' has {channels} channels; "
                "only materials of one or three can be rendered"
            )
        self._angle, given = opaque(angle), "rotation" in props
        self._rotation = props.get_unbounded_texture("rotation", 0.0) if given else None
        self._turned = self.model.widths == 2 and (given or angle != 0)

    def save(self, path):
        """Write the codes to a file that ``neural_brdf`` loads, textured or not.

        Raises:
            FileError: it cannot be written.
        """
        if self._texture:
            texture, grid, model = self._texture
            write_texture(path, texture, grid, model.fingerprint)
        else:
            self._material.save(path)

    def relative_to(self, coat):
        """See `Surface.relative_to`: a material below the medium of a coat, if both are
        constant."""
        if self._texture or coat.has_textured_eta:
            return self
        index = float(coat.inside(dr.zeros(mi.SurfaceInteraction3f)).numpy()[0])
        material = below_medium(self._material, index)
        if material is self._material:
            return self
        under = self._copy()
        under._material = material
        under.latents = ConstantLatents(under._material)
        return under

    def _turn(self, si, active):
        if not self._turned:
            return None
        given = 0 if self._rotation is None else self._rotation.eval_1(si, active)
        return Turn.of(self._angle + given)

    def traverse(self, callback):
        if self._rotation is not None:
            callback.put("rotation", self._rotation, mi.ParamFlags.Differentiable)
        if not self._texture:
            callback.put("latents", self._tensor, mi.ParamFlags.Differentiable)

    def _update(self, keys):
        if self._texture:
            return
        codes = self._tensor.numpy()
        if not np.array_equal(codes, self._material.latents):
            self._material = Material(codes, self.model)
        tensor = self._tensor if dr.grad_enabled(self._tensor) else None
        self.latents = ConstantLatents(self._material, tensor)

    def to_string(self):
        return (
            f'NeuralBRDF[\n  filename = "{self._filename}",\n  latents = {self.latents},\n'
            f"  weights = {self.model.fingerprint}\n]"
        )
