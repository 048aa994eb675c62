"""The plugin `neural_layered`: a coat over any BSDF, by tables and latent codes."""

from typing import ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.errors import ParameterError
from urushi.mitsuba.latents.over_axes import AxisLatents
from urushi.mitsuba.plugins.coated import Coated
from urushi.mitsuba.plugins.compensation import Compensation
from urushi.mitsuba.plugins.neural_brdf import EncodedSurface
from urushi.mitsuba.properties import read_weights
from urushi.mitsuba.reading.bottoms import Layer, has_two_widths
from urushi.mitsuba.reading.changed import relative_to
from urushi.mitsuba.reading.layer_codes import Baker, at_texels
from urushi.mitsuba.reading.nested import check_bottom, check_rotation
from urushi.mitsuba.surface import KnownSurface, surface_of
from urushi.nets.weights import anisotropic_model, default_model
from urushi.textures.store import write_texture

#: Greatest number of texels per side: the words of larger textures cannot be indexed by 32 bits.
LARGEST_RESOLUTION = 8192


class NeuralLayered(Coated, EncodedSurface):
    """A coated BSDF by latent codes and tables, without noise (``neural_layered``).

    Takes the parameters of ``layered``, its reference, and these:

    ============== ===================== ====================================================
    resolution     integer               Texels per side of saved files, and where the bottom
                                         is of an unknown kind and varies; at most 8192.
                                         (Default: that of the largest texture, at most 512;
                                         256 for procedural ones)
    weights        string                File of the weights. (Default: the shipped
                                         ones, ``anisotropic`` where the coat or the bottom is
                                         anisotropic, otherwise ``default``)
    ============== ===================== ====================================================

    Two widths of a ratio above 10 are refused. The bottom must have no normals of its own.

    Without a nested BSDF, over dielectrics and over slabs, it is a *slab* as ``layered``, which
    scatters light from both sides to both. Tables of what it reflects and transmits are
    computed by light transport when the scene is loaded. Up to six parameters may vary over the
    surface or carry gradients, but no index of refraction, and each interface has one width. In
    spectral variants, colours are among them.

    When the scene is loaded, the bottom is evaluated at the probe pairs, averaged if it lacks
    the symmetries of materials (see ``urushi.encode``), and encoded. Constant coats over
    constant bottoms are computed by light transport, as in ``urushi.layer``: a table for one
    width, codes for two. Parameters of the coat and of the bottom that vary are axes, from one
    to six. Light transport gives codes along them, and Mitsuba's own textures the place on
    them, with their filter and transform; mesh attributes and volumes are textures, too. In
    spectral variants, a constant coat has one code for each of 56 bands from 380 to 720 nm,
    and the wavelength is an axis of others.

    Where a bottom of an unknown kind varies, or more than six parameters do, codes are computed
    for each texel of the unit square of uv, which repeats, by light transport and the layering
    network. The network knows sigma_t from 0 to 8 and g from -0.8 to 0.9, and takes a similar
    medium outside, with a warning.

    A change through ``mi.traverse`` recomputes codes, but not where textures stay within their
    former ranges. The method ``save`` writes the codes to a file for ``neural_brdf``.

    Pictures can be differentiated with respect to all parameters, including the bottom's, by
    Mitsuba's differentiable integrators such as ``prb``: enable gradients of the parameters
    that ``mi.traverse`` lists, and update. A texture with gradients is an axis over all values
    that it may take; its derivative is the slope along it. The derivative by a constant is a
    difference of light transport.

    After Fan, Wang, Hašan, Yang and Yan, Neural Layered BRDFs, SIGGRAPH 2022.
    """

    UNRECORDED: ClassVar = ("_baker",)
    _differentiable = True

    _baker: Baker | None

    def _load(self, props):
        super()._load(props)
        check_bottom(self._nested, self._coat.where)
        resolution = props.get("resolution", 0)
        if resolution not in range(LARGEST_RESOLUTION + 1):
            raise ParameterError(
                f"{self._coat.where}: resolution is {resolution}; give texels per side, at "
                f"most {LARGEST_RESOLUTION}, or 0 to choose by the textures"
            )
        self._weights = read_weights(props)
        self._resolution = int(resolution)
        self._baker, self._compensation = None, None
        self._below = relative_to(self._nested, self._coat)
        self._prepare()

    def relative_to(self, coat):
        """See `Surface.relative_to`."""
        under = self._copy()
        under._coat, under._baker = self._coat.relative_to(coat), None
        under._prepare()
        return under

    def known(self):
        return KnownSurface(self.latents, rotated=self._coat.has_rotation)

    def _prepare(self):
        check_rotation(self._nested, self._coat.where)
        model = self._weights
        if model is None:
            anisotropic = self._coat.is_anisotropic or has_two_widths(self._below)
            model = anisotropic_model() if anisotropic else default_model()
        if self._baker is None or self.model.fingerprint != model.fingerprint:
            self.model, self._baker = model, Baker(model, self._resolution)
        with dr.suspend_grad():
            self.latents = self._baker.update(Layer(self._coat, self._nested, self._below))
            if self._coat.compensated:
                self._compensation = Compensation(self._coat, self._below)
        self._absorbs = self._baker.absorbs
        # Kernels of Mitsuba's textures have their transforms as literals: see `recording`.
        nodes = map(mi.traverse, (*self._coat.textures.values(), self._nested))
        places = [value for node in nodes for key, value in node if key.endswith("to_uv")]
        self._places = [tuple(np.ravel(place.matrix.numpy()).tolist()) for place in places]

    def save(self, path):
        """Write the codes to a file that ``neural_brdf`` loads, textured or not.

        The file of a latent texture does not store a rotation: set it in ``neural_brdf`` again.

        Raises:
            FileError: it cannot be written.
        """
        angle = self._coat.constant_rotation
        if isinstance(self.latents, AxisLatents):
            texture, grid = at_texels(self.latents, self._resolution, self._coat.where)
            write_texture(path, texture, grid, self.model.fingerprint)
            angle = None  # the file has none
        else:
            self.latents.material.rotated(angle or 0.0).save(path)
        if self._coat.has_rotation and angle is None:
            mi.Log(
                mi.LogLevel.Warn,
                f"{self._coat.where}: the file of the codes leaves out the rotation; give it "
                "to the plugin 'neural_brdf' that reads the file",
            )

    def _f_and_pdf(self, vertex, ctx, si, wo, active):
        f, pdf = super()._f_and_pdf(vertex, ctx, si, wo, active)
        if self._absorbs:  # without codes: f of the bottom by Beer's law
            cos_i, cos_o = (dr.select(active, w.z, 1) for w in (si.wi, wo))
            depth = self._coat.evaluate(si, active).sigma_t * (1 / cos_i + 1 / cos_o)
            f = self._below.eval(ctx, si, wo, active) / cos_o * dr.exp(-depth)
        elif self._compensation is not None:
            f = self._compensation.with_lost_light(f, si, wo, active)
        return f, pdf

    def _update(self, keys):
        self._coat.parameters_changed()
        nested = surface_of(self._below)
        if isinstance(nested, NeuralLayered) and self._below is not self._nested:
            nested._update([])  # it has the bottom's textures
        else:
            self._below = relative_to(self._nested, self._coat)
        self._prepare()

    def _details(self):
        return f"  latents = {self.latents},\n  weights = {self.model.fingerprint},\n"
