"""The plugin `openpbr`: OpenPBR Surface, its coat by a table, codes or random walks."""

from typing import Any

import mitsuba as mi

from urushi.core.appearance import optical_depth
from urushi.core.namespace import DRJIT
from urushi.errors import ParameterError
from urushi.mitsuba.properties import switch_of
from urushi.mitsuba.surface import bsdf_of
from urushi.openpbr_surface import formulas
from urushi.openpbr_surface.bsdfs import Layers, OpenPBRBase, OpenPBRSurface
from urushi.openpbr_surface.compensation import Compensation
from urushi.openpbr_surface.inputs import Inputs, derived, load_part, width_properties
from urushi.openpbr_surface.shares import transmits, without_medium
from urushi.openpbr_surface.transmission import transmitting

#: Plugins of the coat: by tables or codes, and by walks.
COATS = ("neural_layered", "layered")


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

    The base is a closed form. A dielectric reflects by single scattering and transmits the rest
    to the diffuse slab, and the fraction base_color leaves it again; a metal has the F82-tint
    term. The coat's light transport is computed by a table, codes or walks; coat_weight
    mixes the BRDFs of the bare and the coated base. Fuzz lies above both. Not supported, and
    refused or left out with a warning, are dispersion, separate directions for the coat, and
    over a base that transmits light fuzz and some thin films and coats. Light is emitted by
    the emitter ``openpbr_emission``.

    With ``transmission_weight``, ``subsurface_weight`` or ``geometry_thin_walled`` the surface
    has two sides. A body needs one ``specular_ior`` and ``specular_weight``. With subsurface or
    a ``transmission_depth``, its shape needs a medium, too: ``urushi.openpbr(...).on(shape)``
    gives it, and sets ``interior``. Without ``interior`` a body is refused; if ``unsupported``
    is "ignore", the medium's colours are the surface's: a diffuse base of ``subsurface_color``,
    glass tinted by ``transmission_color``. Panes, and coats over transmitting bases, are tables
    if they are constant and isotropic, and walks otherwise.

    A number that ``mi.traverse`` changes is treated like a texture from then on. Components
    that were left out because of it, for instance a coat or fuzz of weight zero, are created. A
    coat is updated with its base, and the energy compensation is computed again if it depends
    on the change.

    Fuzz is layered by the albedo of the direction that is seen, as the specification says.
    Material with fuzz is therefore not reciprocal: f changes by some per cent in the mean when
    wi and wo are exchanged. A coat of index one has no interface: it absorbs light of the
    uncoated base.

    Where all parameters are constant and isotropic and the base is not smooth, the coat is
    computed as a table when the material is loaded. All others have codes.

    If the coat's index exceeds the base's, total internal reflection occurs at the base.

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

    def opaque(inputs: Inputs) -> "mi.BSDF":
        return bsdf_of(OpenPBRSurface(inputs, made))

    def made(inputs: Inputs) -> Layers:
        return _layers(inputs, COATS[bool(reference)], options, compensated)

    if transmits(inputs):
        bsdf = transmitting(inputs, opaque, _coat, not reference, compensated)
    else:
        bsdf = opaque(inputs)
    if "geometry_normal" in inputs.maps:
        bsdf = mi.load_dict(
            {"type": "normalmap", "normalmap": inputs.maps["geometry_normal"], "bsdf": bsdf}
        )
    if not inputs.is_constant("geometry_opacity", 1):
        opacity = inputs.textures["geometry_opacity"]
        bsdf = mi.load_dict({"type": "mask", "opacity": opacity, "bsdf": bsdf})
    return bsdf


def _layers(inputs: Inputs, plugin: str, options: dict[str, Any], compensated: bool) -> Layers:
    """The layers that parameters need.

    plugin: of the coat, one of `COATS`. options: its weights and resolution, if given.
    """
    tables = plugin == COATS[0]

    def base(inputs: Inputs, under_coat: bool) -> "mi.BSDF":
        return bsdf_of(OpenPBRBase(inputs, under_coat))

    def coated(inputs: Inputs, below: "mi.BSDF") -> "mi.BSDF":
        given = options if tables else {}
        coat = {"type": plugin, **_coat(inputs), "bottom": below, **given}
        return load_part(inputs, coat)

    covered = inputs.is_constant("coat_weight", 1)
    # A coat of index one has no interface: it only absorbs, see `model.absorbed`.
    if inputs.is_constant("coat_weight", 0) or inputs.is_constant("coat_ior", 1):
        return Layers(base(inputs, False), None, None, None)
    below = base(inputs, True)
    compensation = None
    if compensated:
        compensation = Compensation(inputs, tables, lambda x: coated(x, base(x, True)))
    in_air = None if covered else base(inputs, False)
    return Layers(in_air, below, coated(inputs, below), compensation)


def _coat(inputs: Inputs) -> dict[str, Any]:
    """The coat as a dictionary of a plugin, without its type and bottom."""
    coat: dict[str, Any] = {"ext_ior": 1.0, **width_properties(inputs, "coat")}
    if inputs.known("coat_ior") is not None:
        coat["int_ior"] = float(formulas.interface_index(inputs.known("coat_ior")))
    else:
        coat["int_ior"] = derived(
            inputs, ("coat_ior",), lambda ior: formulas.interface_index(ior, DRJIT)
        )
    if not inputs.is_constant("coat_color", 1):
        coat["sigma_t"] = derived(
            inputs, ("coat_color",), lambda color: optical_depth(color, DRJIT), color=True
        )
    return coat
