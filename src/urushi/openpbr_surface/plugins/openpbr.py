"""The plugin `openpbr`: OpenPBR Surface, its coat by a table, codes or random walks."""

import mitsuba as mi

from urushi.errors import ParameterError
from urushi.mitsuba.properties import switch_of
from urushi.mitsuba.surface import bsdf_of
from urushi.openpbr_surface.bsdfs import OpenPBRSurface
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.parts import COATS, Coating, transmits, without_medium
from urushi.openpbr_surface.transmission import Body


def openpbr(props):
    """OpenPBR Surface 1.1.1, with its coat as light transport (``openpbr``).

    ==================== ===================== =============================================
    (parameters)         float, spectrum,      The parameters of the specification under their
                         texture               names, with its defaults.
    geometry_normal,     texture               Maps of 0.5 n + 0.5 in the tangent frame. The
    geometry_tangent                           coat shares both: geometry_coat_normal and
                                               geometry_coat_tangent must be equal to them, or
                                               the base isotropic.
    reference            boolean or string     Whether the coat is computed by random walks
                                               (``layered``) instead of ``neural_layered``;
                                               or the name of one of these plugins.
                                               (Default: false)
    energy_compensation  boolean               Whether energy that the coated base loses is
                                               compensated: white materials reflect all light.
                                               (Default: true)
    unsupported          string                "error" or "ignore": whether an unsupported
                                               feature is refused or left out with a warning.
                                               (Default: "error")
    interior             boolean               Whether the shape has the medium inside of the
                                               body as its ``interior``. (Default: false)
    resolution, weights  integer, string       As of ``neural_layered``, without ``reference``.
    ==================== ===================== =============================================

    The base is a closed form; the coat's light transport is computed by a table, codes or
    walks. With ``transmission_weight``, ``subsurface_weight`` or ``geometry_thin_walled`` the
    surface has two sides, and a body may need a medium inside: ``urushi.openpbr(...).on(shape)``
    gives it. Light is emitted by the emitter ``openpbr_emission``. A number that ``mi.traverse``
    changes is treated like a texture from then on. :doc:`/openpbr` says how parameters become
    layers, and what is missing.

    .. tabs::
        .. code-tab:: xml

            <bsdf type="openpbr">
                <rgb name="base_color" value="0.6, 0.1, 0.05"/>
                <float name="coat_weight" value="1"/>
                <rgb name="coat_color" value="0.9, 0.7, 0.4"/>
            </bsdf>

        .. code-tab:: python

            'type': 'openpbr',
            'base_color': {'type': 'rgb', 'value': [0.6, 0.1, 0.05]},
            'coat_weight': 1.0,
            'coat_color': {'type': 'rgb', 'value': [0.9, 0.7, 0.4]}

    Andersson et al., OpenPBR Surface 1.1.1, Academy Software Foundation.
    """
    inputs = Inputs(props)
    if transmits(inputs) and not (inputs.thin or inputs.interior):
        inputs = without_medium(inputs)
    reference = props.get("reference", False)
    if isinstance(reference, str):
        if reference not in COATS:
            raise ParameterError(f"reference is '{reference}'; choose one of {', '.join(COATS)}")
        reference = reference == COATS[1]
    compensated = switch_of(props, "energy_compensation", default=True)
    options = {name: props[name] for name in ("resolution", "weights") if name in props}
    for name in options:
        props.mark_queried(name)
    coating = Coating(not reference, options, compensated)
    bsdf = bsdf_of((Body if transmits(inputs) else OpenPBRSurface)(inputs, coating))
    if "geometry_normal" in inputs.maps:
        bsdf = mi.load_dict(
            {"type": "normalmap", "normalmap": inputs.maps["geometry_normal"], "bsdf": bsdf}
        )
    if not inputs.is_constant("geometry_opacity", 1):
        opacity = inputs.textures["geometry_opacity"]
        bsdf = mi.load_dict({"type": "mask", "opacity": opacity, "bsdf": bsdf})
    return bsdf
