"""The plugin `measured_brdf`: a measured BRDF from its file."""

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.errors import ParameterError
from urushi.measured import Rgl, load_measured
from urushi.mitsuba import spectrum
from urushi.mitsuba.properties import path_of
from urushi.mitsuba.recording import owned
from urushi.mitsuba.surface import KnownSurface, Surface
from urushi.walk.tabulated import Tabulated

#: Wavelengths [nm] at which the spectra of a file are tabulated: the first, and their number.
FIRST, COUNT = 360, 471


class Components:
    """A measured BRDF as a sum of a few spectra."""

    def __init__(self, source: Rgl, wavelengths: np.ndarray):
        """wavelengths: of the source [nm]."""
        table, spectra = source.components
        nm = np.arange(FIRST, FIRST + COUNT)
        rows = [np.interp(nm, wavelengths, row) for row in spectra]
        self._spectra = [owned(mi.Float, row.astype(np.float32)) for row in rows]
        self.reflector = Tabulated(table, np.mean(rows, axis=1)).on(mi.Float)

    def f(self, wi, wo, wavelengths) -> Any:
        """f [1/sr] at wavelengths [nm]; the last ones of the file hold beyond them."""
        channels, lanes = self.reflector.channels(wi, wo), []
        for wavelength in wavelengths:
            place = dr.clip(wavelength - FIRST, 0, COUNT - 1.001)
            low = mi.UInt32(place)
            total: Any = 0
            for value, row in zip(channels, self._spectra, strict=True):
                ends = (dr.gather(mi.Float, row, low + i) for i in (0, 1))
                total += value * dr.lerp(*ends, place - low)
            lanes.append(dr.maximum(total, 0))
        return mi.Spectrum(*lanes)


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
        self._spectral = None
        try:
            if mi.is_spectral and isinstance(source, Rgl) and source.wavelengths is not None:
                self._spectral = Components(source, source.wavelengths)
                self._reflector = self._spectral.reflector
            else:
                self._reflector = source.tabulated.on(mi.Float)
        except ParameterError as error:
            raise ParameterError(f"{self._where}: {error}") from error

    def known(self):
        return KnownSurface(measured=self.source)

    def _f(self, vertex, ctx, si, wo, active):
        if self._spectral:
            return self._spectral.f(si.wi, wo, si.wavelengths)
        channels = self._reflector.channels(si.wi, wo)
        return spectrum.from_channels(channels, si.wavelengths, colors=True)

    def _proposal(self, vertex, si, active):
        return self._reflector.mixture(si.wi.z)

    def to_string(self):
        return f'MeasuredBRDF[\n  filename = "{self._filename}"\n]'
