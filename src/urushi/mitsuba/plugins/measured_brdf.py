"""The plugin `measured_brdf`: a measured BRDF from its file."""

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.errors import ParameterError
from urushi.measured import Rgl, load_measured
from urushi.mitsuba import spectrum
from urushi.mitsuba.properties import path_of
from urushi.mitsuba.surface import KnownSurface, Surface
from urushi.mitsuba.tables import Interpolated
from urushi.walk.tabulated import Tabulated

#: Wavelengths [nm] at which the spectra of a file are tabulated: the first, and their number.
FIRST, COUNT = 360, 471


class MeasuredBRDF(Surface):
    """A measured BRDF (``measured_brdf``).

    ============== ===================== ====================================================
    filename       string                A MERL table (``.binary``) or an isotropic RGL material
                                         (``.bsdf``), relative to the scene file; the
                                         content decides, not the name. (Required)
    ============== ===================== ====================================================

    Can be used alone or under a coat: ``layered`` walks through the coat to the measured BRDF,
    and ``neural_layered`` encodes it. Evaluation is trilinear in a table over
    half and difference angles, as by ``urushi.load_measured``. An RGL material is not exactly
    reciprocal: it is averaged over the exchange of its directions and tabulated on
    256 x 64 x 64 bins (Mitsuba's own ``measured`` does not average). Directions are drawn from
    two GGX lobes and a cosine lobe that are fitted to the table. In spectral variants, a
    spectral file has its own spectra, by up to 16 principal components; the RGB values of
    others become spectra of the same colour.

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

    PROPERTIES = ("filename",)

    def _load(self, props):
        if "filename" not in props:
            raise ParameterError(f"{self._where} has no filename; give a MERL or RGL file")
        self._filename = props["filename"]
        self.source = source = load_measured(path_of(props, "filename"))
        #: Of the channels of the table, by the wavelength; None: the channels are colours.
        self._spectra: Interpolated | None = None
        try:
            if mi.is_spectral and isinstance(source, Rgl) and source.wavelengths is not None:
                (table, spectra), nm = source.components, np.arange(FIRST, FIRST + COUNT)
                rows = np.stack([np.interp(nm, source.wavelengths, x) for x in spectra], axis=-1)
                self._spectra = Interpolated(rows)
                tabulated = Tabulated(table, rows.mean(axis=0))
            else:
                tabulated = source.tabulated
            self._reflector = tabulated.on(mi.Float)
        except ParameterError as error:
            raise ParameterError(f"{self._where}: {error}") from error

    def known(self):
        return KnownSurface(measured=self.source)

    def _f(self, vertex, ctx, si, wo, active):
        channels = self._reflector.channels(si.wi, wo)
        if self._spectra is None:
            return spectrum.from_channels(channels, si.wavelengths, colors=True)
        lanes = []
        for wavelength in si.wavelengths:  # the last ones of the file hold beyond them
            parts = self._spectra([(wavelength - FIRST) * (1 / (COUNT - 1))])
            total = sum(value * part for value, part in zip(channels, parts, strict=True))
            lanes.append(dr.maximum(total, 0))
        return mi.Spectrum(*lanes)

    def _proposal(self, vertex, si, active):
        return self._reflector.mixture(si.wi.z)

    def to_string(self):
        return f'MeasuredBRDF[\n  filename = "{self._filename}"\n]'
