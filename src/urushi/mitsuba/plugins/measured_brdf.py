"""The plugin `measured_brdf`: a measured BRDF from its file."""

import mitsuba as mi

from urushi.errors import ParameterError
from urushi.measured import load_measured
from urushi.mitsuba import spectrum
from urushi.mitsuba.plugins.base import resolve
from urushi.mitsuba.reading.offers import Offer


def define(base: type) -> type:
    """Make the plugin's class in the current variant; base: of `define_proposal_bsdf`."""

    class MeasuredBRDF(base):
        """A measured BRDF (``measured_brdf``).

        ============== ===================== ====================================================
        filename       string                A MERL table (``.binary``) or an isotropic RGL material
                                             (``.bsdf``), relative to the scene file; the
                                             content decides, not the name. (Required)
        ============== ===================== ====================================================

        Can be used alone or under a coat: ``layered`` walks through the coat to the measured BRDF,
        and ``neural_layered`` encodes it with refinement. Evaluation is trilinear in a table over
        half and difference angles, as by ``urushi.load_measured``. An RGL material is not exactly
        reciprocal: it is averaged over the exchange of its directions and tabulated on
        256 x 64 x 64 bins (Mitsuba's own ``measured`` does not average). Directions are drawn from
        two GGX lobes and a cosine lobe that are fitted to the table.

        .. tabs::
            .. code-tab:: xml

                <bsdf type="measured_brdf">
                    <string name="filename" value="gold-paint.binary"/>
                </bsdf>

            .. code-tab:: python

                'type': 'measured_brdf',
                'filename': 'gold-paint.binary'

        Matusik, Pfister, Brand and McMillan, A data-driven reflectance model, SIGGRAPH 2003; Dupuy
        and Jakob, An adaptive parameterization for efficient material acquisition and rendering,
        SIGGRAPH Asia 2018.
        """

        def _load(self, props):
            if "filename" not in props:
                raise ParameterError(f"{self._where} has no filename; give a MERL or RGL file")
            self._filename = props["filename"]
            self.source = load_measured(resolve(self._filename))
            try:
                self._reflector = self.source.tabulated.on(mi.Float)
            except ParameterError as error:
                raise ParameterError(f"{self._where}: {error}") from error

        def offer(self):
            return Offer(measured=self.source)

        def _f(self, vertex, ctx, si, wo, active):
            channels = self._reflector.f(si.wi, wo)
            return spectrum.from_channels(list(channels), si.wavelengths)

        def _proposal(self, vertex, si, active):
            return self._reflector.mixture(si.wi.z)

        def to_string(self):
            return f'MeasuredBRDF[\n  filename = "{self._filename}"\n]'

    return MeasuredBRDF
