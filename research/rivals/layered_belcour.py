"""The plugin `layered_belcour`: coats by the statistical operators of Belcour 2018."""

from collections.abc import Sequence

import drjit as dr
import mitsuba as mi

from research.rivals import belcour, belcour_tables
from research.rivals.belcour import Lobe
from research.rivals.belcour_bottoms import Bottom
from research.rivals.described import DescribedSurface, StackNumbers
from urushi.core.mixture import Mixture

#: Least energy of a lobe in the proposal, so that a black stack has one.
MIN_SHARE = 1e-6


class LayeredBelcour(DescribedSurface):
    """A coated BSDF by statistical operators (``layered_belcour``).

    ============== ===================== ====================================================
    alpha          spectrum, texture     GGX width of the coat's surface, 0.01 to 1. Textures
                                         have one channel. (Default: 0.1)
    int_ior        float, string,        Index of refraction inside the coat, a number, a
                   texture               material such as "water", or a texture of numbers.
                                         (Default: "bk7", 1.5046)
    ext_ior        float, string         Index outside; the ratio of both must be within 0.5 to
                                         3, and at least 0.001 away from 1. (Default: "air",
                                         1.000277)
    albedo         spectrum, texture     Single-scattering albedo of the coat's medium, 0 to 1.
                                         (Default: 0)
    sigma_t        spectrum, texture     Its optical depth, 0 or more: the coat has unit
                                         thickness. (Default: 0, clear)
    g              spectrum, texture     Asymmetry of its Henyey-Greenstein phase function,
                                         -1 to 1, both excluded; the model takes those below 0
                                         as 0. (Default: 0)
    (nested)       BSDF                  The bottom, under any name: a ``roughconductor`` of the
                                         distribution "ggx" with one alpha, a ``diffuse``, or
                                         another ``layered_belcour``. Its values in air are
                                         used, unchanged by the coat's index.
    eta            float                 The ratio int_ior / ext_ior; exposed by
                                         ``mi.traverse``, not a property.
    ============== ===================== ====================================================

    A fast model by another author, for comparison with ``layered`` and ``neural_layered``. It
    has those of their parameters that it supports. Every interface gives one GGX lobe around
    the mirror direction of the viewer, with an energy and a width for each channel. They are
    computed from the reflectances and widths of the interfaces, including all interreflection
    and total internal reflection. The only noise is that of sampled directions, which are drawn
    from the lobes in proportion to their energies.

    A medium absorbs, transmits light that it scatters once, and widens the lobes below it. It
    reflects no light, and light that is scattered more than once on one path is lost: materials
    with thick, bright media are too dark. Energies depend on the viewer only: the BSDF is not
    reciprocal. A Lambertian bottom, which the paper does not have, gives a Lambertian lobe.
    Surfaces have one width, without ``alpha_u``, ``alpha_v`` and ``rotation``. The mean
    reflectance of a metal is read from a table, within 0.01 of ``research.rivals.belcour.f``.
    Reflects on the front side only: nest it in ``twosided`` for both sides. Spectral variants
    evaluate parameters at the rays' wavelengths; colours are bands at 611, 549 and 464 nm,
    linear in between.

    .. tabs::
        .. code-tab:: xml

            <bsdf type="layered_belcour">
                <float name="alpha" value="0.05"/>
                <rgb name="sigma_t" value="0.2, 1.0, 3.0"/>
                <bsdf type="roughconductor" name="base">
                    <string name="distribution" value="ggx"/>
                </bsdf>
            </bsdf>

        .. code-tab:: python

            'type': 'layered_belcour',
            'alpha': 0.05,
            'sigma_t': {'type': 'rgb', 'value': [0.2, 1.0, 3.0]},
            'base': {'type': 'roughconductor', 'distribution': 'ggx'}

    After Belcour, Efficient Rendering of Layered Materials using an Atomic Decomposition with
    Statistical Operators, SIGGRAPH 2018.
    """

    PLUGIN = "layered_belcour"

    def _load(self, props):
        super()._load(props)
        self._tables = belcour_tables.data(mi.Float, with_facets=True)

    def _vertex(self, si, active):
        """The lobes of each channel."""
        cos_i = dr.select(active, dr.clip(si.wi.z, belcour.MIN_COSINE, 1), 1)
        return [self._lobes(stack, cos_i) for stack in self._stacks(si, active)]

    def _lobes(self, stack: StackNumbers, cos_i) -> list[Lobe]:
        def reflectance(cos, alpha):
            if stack.bottom.alpha is None:
                return stack.bottom.reflectance(cos)
            values = [stack.bottom.reflectance(mi.Float(x)) for x in belcour_tables.FACET_COSINES]
            return belcour_tables.mean_of_values(values, cos, alpha, self._tables)

        bottom = Bottom(stack.bottom.alpha, reflectance)
        return belcour.added_lobes(stack.coats, bottom, cos_i, self._tables)

    def _f(self, vertex, ctx, si, wo, active):
        return mi.Spectrum(*(belcour.value(lobes, si.wi, wo) for lobes in vertex))

    def _proposal(self, vertex, si, active):
        return proposal(vertex)


def proposal(channels: Sequence[Sequence[Lobe]]) -> Mixture:
    """The mixture of the channels' lobes, each drawn in proportion to its mean energy.

    channels: lobes of each channel, of equal numbers. The channels share a lobe's width, the mean
    weighed by energy.
    """
    shares, alphas, diffuse = [], [], type(channels[0][0].energy)(0)
    for lobes in zip(*channels, strict=True):
        energies = [lobe.energy + MIN_SHARE for lobe in lobes]
        energy = sum(energies)
        if lobes[0].alpha is None:
            diffuse += energy
            continue
        shares.append(energy)
        widths = sum(e * lobe.alpha for e, lobe in zip(energies, lobes, strict=True))
        alphas.append(widths / energy)
    scale = 1 / (sum(shares) + diffuse)
    return Mixture([share * scale for share in (*shares, diffuse)], alphas)
