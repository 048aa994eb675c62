"""The plugin `layered`: a coat over any BSDF by random walks, the reference of `neural_layered`."""

import mitsuba as mi

from urushi.core.random import hashed_stream
from urushi.mitsuba.plugins.coated import CoatedSurface
from urushi.walk import slabs, walk
from urushi.walk.bottoms.dielectric import Reflector


class Layered(CoatedSurface):
    """A coated BSDF by unbiased random walks (``layered``).

    ============== ===================== ====================================================
    alpha          spectrum, texture     GGX width of the coat's surface, 0.01 to 1. Textures
                                         have one channel; their darker texels are 0.01.
                                         (Default: 0.1)
    alpha_u,       spectrum, texture     In place of alpha: the widths along the tangent and
    alpha_v                              across it, 0.01 to 1, of an anisotropic surface.
    rotation       float, texture        Angle by which the tangent is turned about the normal,
                                         counter-clockwise from dp/du of the shape, in degrees.
                                         (Default: 0)
    int_ior        float, string,        Index of refraction inside the coat, a number, a
                   texture               material such as "water", or a texture of numbers.
                                         (Default: "bk7", 1.5046)
    ext_ior        float, string         Index outside; the ratio of both must be within 0.5 to
                                         3. Nearer to 1 than 0.001 it is 1, without a surface:
                                         the coat is its medium. (Default: the ``int_ior`` of
                                         the coat around this one, or else "air", 1.000277)
    albedo         spectrum, texture     Single-scattering albedo of the coat's medium, 0 to 1.
                                         (Default: 0)
    sigma_t        spectrum, texture     Its optical depth at thickness 1, 0 to 1e6. (Default:
                                         0, clear)
    color          spectrum, texture     In place of albedo and sigma_t: the colour of a clear
                                         coat, 0 to 1, which it transmits twice at normal
                                         incidence at thickness 1. (Default: 1)
    body,          spectrum, texture     With or without color, in place of albedo and sigma_t:
    body_color                           how opaque the pigment of a paint is at thickness 1, 0
                                         to 1, and its diffuse reflectance where it is opaque,
                                         as in ``urushi.coat``. (Default: 0, or 1 with
                                         body_color; 0.8)
    thickness      float, texture        Factor of the optical depth, zero or more. (Default: 1)
    g              spectrum, texture     Asymmetry of its Henyey-Greenstein phase function,
                                         -1 to 1, both excluded. (Default: 0)
    ``energy_``    boolean               Whether light that meets a second facet of the coat's
    compensation                         surface is given back, so that a white coat over white
                                         reflects all light. The option of a coat under another
                                         coat has no effect. (Default: false)
    (nested)       BSDF                  The bottom, under any name: any opaque BSDF that has
                                         no perfectly smooth lobe; coats nest. The index of a
                                         ``roughconductor`` becomes relative to the coat's;
                                         others have the values that they have in air. Without
                                         it, and over a ``roughdielectric``, ``dielectric`` or
                                         ``thindielectric``, coats are a slab, which transmits
                                         light.
    eta            float                 The ratio int_ior / ext_ior, or to air without ext_ior;
                                         exposed by ``mi.traverse``, not a property.
    ============== ===================== ====================================================

    The parameters ``resolution`` and ``weights`` of ``neural_layered`` are
    ignored, so that one word changes a scene from codes to walks.

    Every evaluation is one random walk of unbounded depth between the coat's surface and the
    bottom. Images are noisy but unbiased, up to 0.1 % in lossless media deeper than 12 (see
    :doc:`/conventions`): they are the reference for ``neural_layered``, which has the same
    parameters. The density of sampled directions has no noise. Random numbers come
    from a hash of directions, position, uv and time. Directly nested coats form one stack.
    Spectral variants evaluate parameters at the rays' wavelengths.

    Without a nested BSDF, the plugin is a *thin slab*: paper, a frosted pane, a leaf. Its lower
    interface is as wide as that of the lowest coat, and the medium outside lies beyond, too.
    Over a ``thindielectric``, the coats lie on a clear pane of its index. Indices of thin slabs
    are numbers, and not all 1; all other parameters may be textures.

    Over a ``roughdielectric`` of the distribution ``ggx`` or a ``dielectric``, the coats lie on
    a *body of glass*: its index holds below the surface of the shape. The body may have an
    interior medium. A smooth ``dielectric`` has an ``alpha`` of 0.01. Dielectrics have an
    absolute ``int_ior`` of at most four decimals and no ``ext_ior``, since Mitsuba tells only
    the ratio of both. A bubble of air in glass is a coat of ``ext_ior`` 1.5 over a
    ``dielectric`` of ``int_ior`` "air".

    Slabs scatter light from both sides to both, of radiance and of importance.

    All layers share one tangent frame: that of the shape, rotated by ``rotation``. Directly
    nested coats have no rotation of their own, and an anisotropic bottom, such as
    ``roughconductor`` with two widths, rotates with the coats. If a width is a colour, each
    channel needs its own walk.

    .. tabs::
        .. code-tab:: xml

            <bsdf type="layered">
                <float name="alpha" value="0.05"/>
                <rgb name="sigma_t" value="0.2, 1.0, 3.0"/>
                <float name="albedo" value="0.8"/>
                <bsdf type="roughconductor" name="base">
                    <string name="distribution" value="ggx"/>
                </bsdf>
            </bsdf>

        .. code-tab:: python

            'type': 'layered',
            'alpha': 0.05,
            'sigma_t': {'type': 'rgb', 'value': [0.2, 1.0, 3.0]},
            'albedo': 0.8,
            'base': {'type': 'roughconductor', 'distribution': 'ggx'}

    After Guo, Hašan and Zhao, Position-Free Monte Carlo Simulation for Arbitrary Layered
    BSDFs, SIGGRAPH Asia 2018.
    """

    def _model(self, coats, bottom, si, wo, color, active):
        # Mitsuba gives `eval` no random numbers: hash all that distinguishes the call.
        rng = hashed_stream(mi.PCG32, (*si.wi, *wo, *si.p, *si.uv, si.time))
        if isinstance(bottom, Reflector):
            return slabs.estimate(coats, bottom, si.wi, wo, rng, color, active)
        f = walk.estimate(coats, bottom, si.wi, wo, rng, color, active)
        return f + walk.top_reflection(coats, si.wi, wo)
