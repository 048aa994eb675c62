"""The plugin `layered_weidlich`: coats by the model of Weidlich and Wilkie 2007."""

from research.rivals import weidlich
from urushi.errors import ParameterError
from urushi.mitsuba.plugins.coated import CoatedSurface


class LayeredWeidlich(CoatedSurface):
    """A coated BSDF by one path through a common facet (``layered_weidlich``).

    ============== ===================== ====================================================
    alpha          spectrum, texture     GGX width of the coat's surface, 0.01 to 1. Textures
                                         have one channel. (Default: 0.1)
    alpha_u,       spectrum, texture     In place of alpha: the widths along the tangent and
    alpha_v                              across it, 0.01 to 1, of an anisotropic surface.
    rotation       float, texture        Angle by which the tangent is turned about the normal,
                                         counter-clockwise from dp/du of the shape, in degrees.
                                         (Default: 0)
    int_ior        float, string,        Index of refraction inside the coat, a number, a
                   texture               material such as "water", or a texture of numbers.
                                         (Default: "bk7", 1.5046)
    ext_ior        float, string         Index outside; the ratio of both must be within 0.5 to
                                         3, and at least 0.001 away from 1. (Default: "air",
                                         1.000277)
    albedo         spectrum, texture     As of ``layered``; the model ignores it, because its
                                         media only absorb. (Default: 0)
    sigma_t        spectrum, texture     Optical depth of the coat's medium, 0 or more: the coat
                                         has unit thickness. (Default: 0, clear)
    g              spectrum, texture     As of ``layered``; the model ignores it. (Default: 0)
    (nested)       BSDF                  The bottom, under any name: any opaque BSDF that has
                                         no perfectly smooth lobe; coats nest. Its values in
                                         air are used, unchanged by the coat's index.
    eta            float                 The ratio int_ior / ext_ior; exposed by
                                         ``mi.traverse``, not a property.
    ============== ===================== ====================================================

    A fast model by other authors, for comparison with ``layered`` and ``neural_layered``; it
    has the same parameters. Light enters and leaves through the facet whose normal is the half
    vector of both directions. Both directions are refracted at this facet, the bottom is
    evaluated for the refracted directions, and the result is multiplied by the Fresnel
    transmittance of both paths and by absorption along the refracted directions (Beer's law).
    The masked part of the light leaves without loss, as a compensation. Values have no noise,
    and they are reciprocal if the bottom's are.

    A scattering medium absorbs according to its extinction ``sigma_t``; ``albedo`` and ``g``
    are ignored, so that bright media are too dark. There is no interreflection between the
    layers, and the roughness of a coat does not widen the lobes below it. The model ignores
    that refraction changes the solid angle. Coated metals are therefore too dark at grazing
    angles, and Lambertian surfaces are too bright. White ones reflect more light there than
    they receive, and so do coats of an index below one. Reflects on the front side only: nest
    it in ``twosided`` for both sides. Spectral variants evaluate parameters at the rays'
    wavelengths; colours are bands at 611, 549 and 464 nm, linear in between.

    .. tabs::
        .. code-tab:: xml

            <bsdf type="layered_weidlich">
                <float name="alpha" value="0.05"/>
                <rgb name="sigma_t" value="0.2, 1.0, 3.0"/>
                <bsdf type="roughconductor" name="base">
                    <string name="distribution" value="ggx"/>
                </bsdf>
            </bsdf>

        .. code-tab:: python

            'type': 'layered_weidlich',
            'alpha': 0.05,
            'sigma_t': {'type': 'rgb', 'value': [0.2, 1.0, 3.0]},
            'base': {'type': 'roughconductor', 'distribution': 'ggx'}

    After Weidlich and Wilkie, Arbitrarily Layered Micro-Facet Surfaces, GRAPHITE 2007.
    """

    def _prepare_slab(self):
        raise ParameterError(
            f"{self._where}: the nested BSDF transmits light; a coat needs an opaque bottom"
        )

    def _model(self, coats, bottom, si, wo, color, active):
        return weidlich.value(coats, bottom, si.wi, wo)
