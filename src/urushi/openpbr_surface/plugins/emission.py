"""The emitter `openpbr_emission`: the light that an OpenPBR base emits, seen through the coat."""

from typing import ClassVar

import drjit as dr
import mitsuba as mi

from urushi.core.appearance import optical_depth
from urushi.core.namespace import DRJIT
from urushi.mitsuba.recording import signature_of
from urushi.mitsuba.snapshot import ParameterSnapshot
from urushi.mitsuba.tables import InterfaceAlbedo
from urushi.openpbr_surface import formulas
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.parameters import EMISSION

#: Numbers and colours on which the light depends.
TEXTURED = (
    *EMISSION,
    *("coat_weight", "coat_color", "coat_roughness", "coat_ior"),
    *("fuzz_weight", "fuzz_roughness", "geometry_opacity"),
)

#: All parameters on which it depends.
NAMES = (*TEXTURED, "geometry_thin_walled")


def define() -> type:
    """Make the plugin's class in the current variant."""

    class OpenPBREmission(mi.Emitter):
        """The light that the base of OpenPBR emits (``openpbr_emission``).

        A BSDF in Mitsuba cannot emit light. Give the shape this emitter in addition to the BSDF
        ``openpbr``, with the same parameters; it reads emission, coat, fuzz, opacity and
        geometry_thin_walled. ``urushi.openpbr`` makes both. The radiance is emission_luminance
        times emission_color, in the scene's units: one unit is one nit. The base emits the same
        radiance in all directions. The coat attenuates it by the transmittance of its interface and
        by absorption along one refracted path, and fuzz by one minus its albedo. Light that the
        coat reflects back down is ignored. A thin wall (``geometry_thin_walled``) emits on both
        sides, all others on the side of the normal.

        .. tabs::
            .. code-tab:: xml

                <shape type="sphere">
                    <bsdf type="openpbr"/>
                    <emitter type="openpbr_emission">
                        <float name="emission_luminance" value="100"/>
                        <rgb name="emission_color" value="1, 0.5, 0.1"/>
                    </emitter>
                </shape>

            .. code-tab:: python

                'type': 'sphere',
                'bsdf': {'type': 'openpbr'},
                'emitter': {
                    'type': 'openpbr_emission',
                    'emission_luminance': 100.0,
                    'emission_color': {'type': 'rgb', 'value': [1, 0.5, 0.1]},
                }

        Andersson et al., OpenPBR Surface 1.1.1, Emission.
        """

        UNRECORDED: ClassVar = ("_snapshot", "_signature")

        def __init__(self, props):
            self._inputs = inputs = Inputs(props, emits=True)
            # Colours are relative to the white of sRGB, as those of Mitsuba's emitters; a spectrum
            # is the light's own.
            color = inputs.textures["emission_color"]
            of_white = "emission_color" in inputs.constants or color.is_spatially_varying()
            self._white = mi.load_dict({"type": "d65"}) if mi.is_spectral and of_white else None
            self._configure()
            self._snapshot, self._signature = ParameterSnapshot(), signature_of(self)
            mi.Emitter.__init__(self, props)  # which other threads may evaluate from here on
            self.m_flags = mi.EmitterFlags.Surface | mi.EmitterFlags.SpatiallyVarying
            self._snapshot.keep(self)

        def _configure(self):
            """Leave out coat and fuzz where their weights are given as zero."""
            self._interface = None
            if not self._inputs.is_constant("coat_weight", 0):
                self._interface = InterfaceAlbedo(None)
            self._fuzz = not self._inputs.is_constant("fuzz_weight", 0)

        def eval(self, si, active=True):
            return self._radiance(mi.Frame3f.cos_theta(si.wi), si, active)

        def bbox(self):
            return self.get_shape().bbox()

        def sample_position(self, time, sample, active=True):
            ps = self.get_shape().sample_position(time, sample, active)
            return ps, dr.select(ps.pdf > 0, 1 / ps.pdf, 0)

        def pdf_position(self, ps, active=True):
            return self.get_shape().pdf_position(ps, active)

        def sample_wavelengths(self, si, sample, active=True):
            """The weight includes the radiance towards si.wi, in world space as in ``ptracer``."""
            at, weight = mi.SurfaceInteraction3f(si), mi.Spectrum(1)
            if mi.is_spectral:
                at.wavelengths, weight = mi.sample_rgb_spectrum(mi.sample_shifted(sample))
            return at.wavelengths, weight * self._radiance(dr.dot(si.wi, si.n), at, active)

        def sample_ray(self, time, sample1, sample2, sample3, active=True):
            ps, weight = self.sample_position(time, sample2, active)
            si = mi.SurfaceInteraction3f(ps, dr.zeros(mi.Interaction3f).wavelengths)
            si.time, below, u = time, mi.Bool(False), mi.Point2f(sample3)
            if self._inputs.thin:  # half of the samples leave on the back
                below, weight = u.x < 0.5, 2 * weight
                u.x = 2 * u.x - dr.select(below, 0, 1)
            local = mi.warp.square_to_cosine_hemisphere(u)
            si.wi = si.to_world(mi.Vector3f(local.x, local.y, dr.select(below, -1, 1) * local.z))
            si.wavelengths, radiance = self.sample_wavelengths(si, sample1, active)
            return si.spawn_ray(si.wi), radiance * (weight * dr.pi)

        def sample_direction(self, it, sample, active=True):
            ds = self.get_shape().sample_direction(it, sample, active)
            value = self.eval_direction(it, ds, mi.Bool(active) & (ds.pdf > 0))
            ds.emitter = mi.EmitterPtr(self)
            return ds, dr.select(ds.pdf > 0, value / ds.pdf, 0)

        def pdf_direction(self, it, ds, active=True):
            facing = mi.Bool(active) & (self._towards(-dr.dot(ds.d, ds.n)) > 0)
            return dr.select(facing, self.get_shape().pdf_direction(it, ds, facing), 0)

        def eval_direction(self, it, ds, active=True):
            si = dr.zeros(mi.SurfaceInteraction3f, dr.width(ds))
            si.uv, si.p, si.n, si.wavelengths = ds.uv, ds.p, ds.n, it.wavelengths
            return self._radiance(-dr.dot(ds.d, ds.n), si, active)

        def _towards(self, cosine):
            """The cosine to the normal of the side that is seen; both sides of a thin wall emit."""
            return dr.abs(cosine) if self._inputs.thin else cosine

        def _radiance(self, cosine, si, active):
            """The radiance that leaves at an angle to the normal."""
            cosine = self._towards(cosine)
            active = mi.Bool(active) & (cosine > 0)
            cosine = dr.clip(cosine, 0, 1)
            at = self._inputs.at(si, active)
            value = at.emission_luminance * at.emission_color
            if self._white is not None:
                value *= self._white.eval(si, active)
            if self._interface:
                eta = dr.clip(at.coat_ior, 1 / 3, 3)
                alpha = formulas.lobe_width(at.coat_roughness, DRJIT)
                inside = dr.sqrt(dr.maximum(1 - (1 - cosine * cosine) / (eta * eta), 1e-6))
                passed = 1 - self._interface.reflected(cosine, alpha, eta)
                coated = passed * dr.exp(-optical_depth(at.coat_color, DRJIT) / inside)
                value *= dr.lerp(mi.Spectrum(1), coated, at.coat_weight)
            if self._fuzz:
                hidden = formulas.fuzz_albedo(cosine, at.fuzz_roughness, DRJIT)
                value *= 1 - at.fuzz_weight * hidden
            value *= at.geometry_opacity
            return dr.select(active, value, 0)

        def traverse(self, callback):
            self._inputs.traverse(callback, TEXTURED)

        def parameters_changed(self, keys):
            with self._snapshot.restored_on_error(self):
                if self._inputs.refresh():
                    self._configure()
            self._signature = signature_of(self)

        def to_string(self):
            return "OpenPBREmission[]"

    return OpenPBREmission
