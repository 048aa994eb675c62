"""The Fresnel terms of OpenPBR's base under a thin film."""

import drjit as dr
import mitsuba as mi

from urushi.openpbr_surface import metal, roughness, thin_film
from urushi.physics import fresnel
from urushi.render.reading.openpbr_inputs import Inputs

#: The parameters that the film reads.
NAMES = ("thin_film_weight", "thin_film_thickness", "thin_film_ior")

#: Nodes and weights of 2 times the integral of a function times the cosine over [0, 1].
_NODES = (
    (0.073054, 0.017477),
    (0.230766, 0.08791),
    (0.441328, 0.197322),
    (0.663015, 0.281585),
    (0.851921, 0.271085),
    (0.970684, 0.144621),
)

#: Distance of facets in `excess`, in units of their width.
_SPREAD = 1.2

#: Cosines inside a coat of light from above.
_COAT_COSINES = (1.0, 0.9, 0.8, 0.7)

#: Cosine whose reflectance stands for the mean of a metal's, which is nearly constant.
_MEAN_COSINE = 0.66


class FilmFresnel:
    """Fresnel terms with the film, which covers the share `thin_film_weight` of the facets.

    In colour variants the channels have the sensitivities of linear sRGB, in spectral ones those of
    single wavelengths, and a monochromatic one has that of Y.
    """

    def __init__(self, inputs: Inputs):
        self._inputs = inputs

    def dielectric(self, cosine, eta, si, active):
        """The term of a dielectric of index eta relative to the medium above, a spectrum."""
        bare = fresnel.dielectric(cosine, eta)[0]
        film = self._film(si, active)
        values = [
            thin_film.reflectance(cosine, film, thin_film.Below(eta), response, dr)
            for response in self._responses(si)
        ]
        return dr.lerp(mi.Spectrum(bare), mi.Spectrum(*values), self._weight(si, active))

    def metal(self, cosine, f0, tint, bare, si, active):
        """The term of a metal of `bare` reflectance without film, a spectrum."""
        film, values = self._film(si, active), []
        for i, response in enumerate(self._responses(si)):
            below = thin_film.metal_index(f0[i], tint[i], dr)
            values.append(thin_film.reflectance(cosine, film, below, response, dr))
        return dr.lerp(mi.Spectrum(bare), mi.Spectrum(*values), self._weight(si, active))

    def metal_mean(self, f0, tint, bare, si, active):
        """The mean of `metal` over the hemisphere; bare: that without film."""
        return self.metal(mi.Float(_MEAN_COSINE), f0, tint, bare, si, active)

    def excess(self, cosine, alpha, eta, si, active):
        """What the film adds to the reflectance of a dielectric's facets, a spectrum.

        The mean over three facets, whose angles spread with the width alpha.
        """
        spread = _SPREAD * alpha * dr.safe_sqrt(1 - cosine * cosine)
        total = mi.Spectrum(0)
        for offset, weight in ((-1, 1 / 6), (0, 2 / 3), (1, 1 / 6)):
            c = dr.clip(cosine + offset * spread, 0, 1)
            bare = fresnel.dielectric(c, eta)[0]
            total += weight * (self.dielectric(c, eta, si, active) - bare)
        return total

    def lobe_terms(self, eta, f0, tint, si, active):
        """What stands for the film in the base's lobe: metal and dielectric without film.

        Means over the angles that light from above has in a coat.

        Returns:
            A metal's reflectance at normal incidence, and a dielectric's index; spectra.
        """
        metal_f0, dielectric_f0 = mi.Spectrum(0), mi.Spectrum(0)
        for cosine in _COAT_COSINES:
            c, weight = mi.Float(cosine), 1 / len(_COAT_COSINES)
            bare = metal.f82(c, f0, tint)
            metal_f0 += weight * self.metal(c, f0, tint, bare, si, active)
            dielectric_f0 += weight * self.dielectric(c, eta, si, active)
        root = dr.sqrt(dr.clip(dielectric_f0, 1e-5, 0.25))
        above = self._film(si, active).eta  # total reflection begins where the film's does
        return metal_f0, dr.select(above < 1, mi.Spectrum(above), (1 + root) / (1 - root))

    def mean_excess(self, eta, si, active):
        """The cosine-weighted mean of `excess` over the hemisphere."""
        film, weight = self._film(si, active), self._weight(si, active)
        bare = _mean(lambda c: fresnel.dielectric(c, eta)[0], eta)
        means = [
            _mean(
                lambda c, r=r: thin_film.reflectance(c, film, thin_film.Below(eta), r, dr), film.eta
            )
            for r in self._responses(si)
        ]
        return weight * (mi.Spectrum(*means) - bare)

    def traverse(self, callback):
        """List the textures for `mi.traverse`."""
        for name in NAMES:
            callback.put(name, self._inputs.textures[name], mi.ParamFlags.Differentiable)

    def _weight(self, si, active):
        return self._inputs.number("thin_film_weight", si, active)

    def _film(self, si, active):
        names = "thin_film_ior", "coat_ior", "coat_weight", "thin_film_thickness"
        ior, coat_ior, coat, thickness = (self._inputs.number(n, si, active) for n in names)
        ior, coat_ior = (dr.maximum(x, roughness.LEAST_INDEX) for x in (ior, coat_ior))
        return thin_film.Film(roughness.relative_index(ior, coat_ior, coat), ior, thickness)

    def _responses(self, si):
        if mi.is_monochromatic:
            return [thin_film.luminance_response()]
        if mi.is_spectral:
            return [thin_film.wavelength_response(x) for x in si.wavelengths]
        return thin_film.rgb_responses()


def _mean(reflectance, eta):
    """The cosine-weighted mean of a reflectance over the hemisphere.

    Below an index eta of one it is 1 beyond the critical angle; the nodes are in between.
    """
    share = dr.minimum(eta * eta, 1)
    total = 1 - share
    for node, weight in _NODES:
        cosine = dr.sqrt(1 - share * (1 - node * node))
        total += share * (weight * reflectance(cosine))
    return total
