"""Shaders of MaterialX's library as parameters of OpenPBR."""

import mitsuba as mi
import numpy as np
import pytest
from tests.openpbr_surface.materialx.conftest import element

from urushi.core.fresnel import EDGE_COSINE
from urushi.errors import UrushiWarning
from urushi.openpbr_surface.materialx.conversions import edge_tint
from urushi.openpbr_surface.materialx.surface import read_surface

approx = pytest.approx


@pytest.fixture
def translated(document):
    """A function: what a shader with some inputs becomes; nodes: that they are connected to."""

    def surface(tag, nodes="", **given):
        shader = element(tag, "surfaceshader", **given)
        return read_surface(document(nodes + shader), resolution=8)

    return surface


@pytest.fixture
def values(translated):
    """A function: the parameters of a shader with some inputs."""
    return lambda *args, **given: translated(*args, **given).values


def reflectance(ior):
    return ((ior - 1) / (ior + 1)) ** 2


def widths(values, part):
    """The GGX widths along and across the tangent (OpenPBR Surface 1.1.1, "Microfacet")."""
    r, a = values[f"{part}_roughness"], values[f"{part}_roughness_anisotropy"]
    along = r**2 * (2 / (1 + (1 - a) ** 2)) ** 0.5
    return along, (1 - a) * along


#: Quantities of several parameters, of which only the product counts.
DERIVED = {
    "tint": lambda x: x.get("specular_weight", 1) * np.array(x["specular_color"]),
    "f0": lambda x: reflectance(x["specular_ior"]) * np.array(x["specular_color"]),
    "fuzz": lambda x: x["fuzz_weight"] * np.array(x["fuzz_color"]),
    "light": lambda x: x["emission_luminance"] * np.array(x["emission_color"]),
    "widths": lambda x: widths(x, "specular"),
}

AMBER, WHITE, BLUE, GOLD = (0.5, 0.6, 0.7), (1.0,) * 3, (0.1, 0.2, 0.3), (1.0, 0.5, 0.1)
#: A dielectric of index 1.5 whose reflections have this tint does not bend light by another index.
TINTED = dict(specular_ior=1.5, tint=(0.2, 0.1, 0.02))
GLASS = dict(transmission=1.0, attenuation_distance=3.0)
COLORS = dict(base_color=(1.0, 0.78, 0.34), coat_color=(0.9, 0.2, 0.1), coat_roughness=0.05)
COATED = COLORS | dict(base=1.0, specular=0.2, coat=0.75)
#: Below the coat's reflection, the graph multiplies any base by coat_color, once.
LACQUER = COLORS | dict(coat_weight=0.75, coat_darkening=0)

TRANSLATED = {
    "standard_surface": [
        (COATED, LACQUER | dict(specular_weight=0.2)),
        (COATED | dict(metalness=0.004), LACQUER | dict(specular_weight=0.2 + 0.8 * 0.004)),
        (COATED | dict(metalness=1.0), LACQUER | dict(specular_weight=1)),
        (
            dict(base_color=(0.5, 0.25, 1.0), coat=0.5, coat_affect_color=1.0),
            dict(base_color=(0.5**1.5, 0.25**1.5, 1)),  # "coat gamma"
        ),
        (
            dict(thin_film_thickness=500.0, sheen=0.5, opacity=(0.3,) * 3)
            | dict(subsurface_radius=(2.0, 1.0, 0.5), subsurface_scale=3.0)
            # MaterialX's node roughness_anisotropy.
            | dict(specular_roughness=0.5, specular_anisotropy=0.75),
            dict(thin_film_thickness=0.5, thin_film_weight=1, fuzz_weight=0.5, geometry_opacity=0.3)
            | dict(subsurface_radius=6, subsurface_radius_scale=(1, 0.5, 0.25))
            | dict(widths=(0.5, 0.125)),
        ),
        (dict(transmission_dispersion=55.3), dict(transmission_dispersion_abbe_number=55.3)),
        (dict(subsurface=1.0, subsurface_anisotropy=0.5), dict(subsurface_scatter_anisotropy=0.5)),
        # The translucent_bsdf of a leaf reflects nothing; OpenPBR's wall transmits (1 + g) / 2.
        (dict(subsurface=1.0, thin_walled=True), dict(subsurface_scatter_anisotropy=1)),
        (dict(transmission=1.0, specular=0.2, specular_color=GOLD), TINTED),
    ],
    "gltf_pbr": [
        (
            dict(metallic=0.0, specular=0.5, specular_color=(2.0, 1.0, 0.5), ior=1.4),
            dict(tint=(1.0, 0.5, 0.25), specular_ior=1.4, geometry_thin_walled=False),
        ),
        (
            dict(clearcoat=0.7, sheen_color=(0.2, 0.4, 0.1), iridescence_thickness=300.0)
            | dict(emissive=(0.5, 0.25, 0.0), emissive_strength=8.0)
            # KHR_materials_anisotropy.
            | dict(roughness=0.5, anisotropy_strength=0.6),
            dict(coat_weight=0.7, coat_ior=1.5, fuzz=(0.2, 0.4, 0.1), thin_film_thickness=0.3)
            | dict(light=(4, 2, 0), widths=(0.25 + 0.75 * 0.36, 0.25)),
        ),
        (dict(alpha=0.3), dict(geometry_opacity=1)),  # alpha_mode is OPAQUE
        (dict(alpha=0.3, alpha_mode=1), dict(geometry_opacity=0)),
        (dict(alpha=0.3, alpha_mode=2), dict(geometry_opacity=0.3)),
        (dict(transmission=1.0, metallic=0.0, specular=0.2, specular_color=GOLD), TINTED),
        # KHR_materials_volume: base_color tints light that crosses the surface, the attenuation
        # what passes the inside; OpenPBR has both in one colour. No thickness is a thin wall.
        *(
            (
                GLASS | dict(thickness=thickness, base_color=base, attenuation_color=inside),
                dict(transmission_color=color, transmission_depth=depth)
                | dict(geometry_thin_walled=thickness == 0),
            )
            for thickness, base, inside, color, depth in (
                (0.0, BLUE, AMBER, BLUE, 0),
                (0.0, WHITE, AMBER, WHITE, 0),
                (2.0, WHITE, AMBER, AMBER, 3),
                (2.0, AMBER, WHITE, AMBER, 0),
            )
        ),
    ],
    "UsdPreviewSurface": [
        (
            dict(useSpecularWorkflow=1, specularColor=(0.04, 0.16, 0.08), metallic=1.0),
            dict(f0=(0.04, 0.16, 0.08), base_metalness=0, emission_luminance=0),
        ),
        (dict(clearcoat=0.5), dict(coat_weight=0.5)),
        (
            dict(opacity=0.25, roughness=0.0, metallic=0.5),
            dict(transmission_weight=0.75, base_metalness=0.5),
        ),
        (dict(opacity=0.25, opacityThreshold=0.5), dict(transmission_weight=0, geometry_opacity=0)),
        (
            dict(opacity=0.0, roughness=0.0, useSpecularWorkflow=1)
            | dict(specularColor=(0.008, 0.004, 0.0008)),
            TINTED,
        ),
    ],
    "disney_principled": [
        # Burley 2012: specular is F0 / 0.08, and a gloss of clearcoat is 1 - roughness.
        (
            dict(specular=0.75, roughness=0.5, anisotropic=0.75, clearcoat=1.0, clearcoatGloss=0.9),
            dict(f0=(0.06,) * 3, widths=(0.5, 0.125), coat_roughness=0.1),
        ),
        (
            dict(specTrans=1.0, roughness=0.0, specular=0.1, specularTint=1.0, baseColor=GOLD),
            TINTED,
        ),
    ],
    "open_pbr_surface": [
        (
            dict(emission_color=(4.0, 2.0, 1.0), emission_luminance=10.0),
            dict(light=(40, 20, 10), emission_color=(1, 0.5, 0.25)),
        ),
    ],
}


@pytest.mark.parametrize(
    ("tag", "given", "expected"),
    [(tag, *row) for tag, rows in TRANSLATED.items() for row in rows],
)
def test_inputs_become_parameters(values, tag, given, expected):
    """As in the shaders' own graphs, or in OpenPBR's definition."""
    found = values(tag, **given)
    for name, value in expected.items():
        derived = DERIVED[name](found) if name in DERIVED else found[name]
        assert derived == approx(value), name


@pytest.mark.parametrize("r", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("edge", [0.2, 1.0])
def test_the_edge_of_a_metal_is_that_of_its_index(r, edge):
    """F82 times Schlick's term is Mitsuba's Fresnel term of Gulbrandsen's index, up to a tint of 1.

    The index is equation 6 and 8 of his paper; Mitsuba is in single precision.
    """
    n = edge * (1 - r) / (1 + r) + (1 - edge) * (1 + r**0.5) / (1 - r**0.5)
    k = max(((n + 1) ** 2 * r - (n - 1) ** 2) / (1 - r), 0) ** 0.5
    mi.set_variant("scalar_rgb")
    fresnel = mi.fresnel_conductor(EDGE_COSINE, mi.Complex2f(n, k))
    schlick = r + (1 - r) * (1 - EDGE_COSINE) ** 5
    assert edge_tint(np.full(1, r), np.full(1, edge)) == approx(min(fresnel / schlick, 1), 1e-4)


MASK = element("splitlr", "float", "map", valuel=0.0, valuer=1.0)


@pytest.mark.parametrize(
    ("given", "thin"),
    [
        (dict(transmission="@map"), True),
        (dict(transmission="@map", thickness=1.0), False),
        (dict(transmission=1.0, thickness="@map"), False),
        (dict(transmission="@map", thickness="@map"), False),
        (dict(thickness="@map"), False),
    ],
)
def test_maps_of_transmission_and_thickness(values, given, thin):
    """A surface is a thin wall, or none: where the map of thickness is 0, a volume ends."""
    assert values("gltf_pbr", MASK, **given)["geometry_thin_walled"] is thin


@pytest.mark.parametrize("given", [dict(specular="@map"), dict(metalness="@map", specular=0.2)])
def test_a_body_has_one_index(values, given):
    """What lets light inside needs one index: a map of the strength of reflections tints them."""
    found = values("standard_surface", MASK.replace('"0.0"', '"0.2"'), subsurface=1.0, **given)
    colors = found["specular_color"].pixels
    assert found["specular_weight"] == 1
    assert 0.2 <= colors.min() < colors.max() <= 1


def test_transmitted_light_has_its_own_roughness(translated):
    """The transmission of UsdPreviewSurface is smooth; a mixture keeps its opaque share rough.

    Of metalness m and opacity o, (1 - m) (1 - o) is clear; the rest has all of the metal.
    """
    with pytest.warns(UrushiWarning, match="both get that of transmitted light"):
        mix = translated("UsdPreviewSurface", opacity=0.5, metallic=0.4, roughness=0.6)
    assert mix.weight == approx(0.3)
    clear, opaque = mix.fg.values, mix.bg.values
    assert (clear["specular_roughness"], clear["transmission_weight"]) == (0, 1)
    assert (opaque["specular_roughness"], opaque["transmission_weight"]) == (0.6, 0)
    assert (clear["base_metalness"], opaque["base_metalness"]) == (0, approx(0.4 / 0.7))
    with pytest.warns(UrushiWarning, match="both get that of reflected light"):
        lamp = translated("UsdPreviewSurface", opacity=0.5, emissiveColor=(1.0, 0.5, 0.0))
    assert lamp.values["emission_color"] == (1, 0.5, 0)  # mixtures have none
    with pytest.warns(UrushiWarning, match="both get that of transmitted light"):
        rougher = dict(transmission_extra_roughness=0.2, specular_roughness=0.3)
        glass = translated("standard_surface", transmission=1.0, **rougher)
    assert glass.values["specular_roughness"] == approx(0.5)


@pytest.mark.parametrize("color", [(0.9, 0.6, 0.3), (0.5, 0.5, 0.5), (0.3, 0.2, 0.26)])
@pytest.mark.parametrize("diffuse", [0.0, 0.1, 0.6])
def test_a_bright_specular_color_is_a_metal_s(values, color, diffuse):
    """Indices end at 3, so that dielectrics reflect a quarter at most along the normal."""
    given = dict(specularColor=color, diffuseColor=(diffuse,) * 3)
    found = values("UsdPreviewSurface", useSpecularWorkflow=1, **given)
    metal, base = found["base_metalness"], np.array(found["base_color"])
    f0 = reflectance(found["specular_ior"])
    assert f0 == approx(0.25)
    dielectric = (DERIVED["tint"](found) - metal) / max(1 - metal, 1e-6)
    albedo = metal * base + (1 - metal) * f0 * dielectric
    assert albedo.max() == approx(max(color), abs=0.01)
    kept = (1 - metal) * (1 - f0) * base
    assert kept.max() == approx((1 - max(color)) * diffuse, abs=0.03)


@pytest.mark.parametrize(
    ("tag", "kept", "lost"),
    [
        ("standard_surface", dict(specular_rotation=0.2), dict(specular_anisotropy=0.5)),
        ("gltf_pbr", dict(anisotropy_rotation=0.2), dict(anisotropy_strength=0.5)),
        (
            "gltf_pbr",
            dict(attenuation_color=AMBER, thickness=2.0, attenuation_distance=3.0),
            dict(transmission=1.0, base_color=BLUE),
        ),
    ],
)
def test_a_warning_says_what_is_lost(values, tag, kept, lost):
    """The first input; one that the other inputs leave without effect is not lost."""
    values(tag, **kept)
    with pytest.raises(UrushiWarning, match=f"no counterpart of {next(iter(kept))} of {tag}"):
        values(tag, **kept, **lost)


@pytest.mark.parametrize(
    ("tag", "name"),
    [("open_pbr_surface", "thin_film_thickness"), ("gltf_pbr", "iridescence_thickness")],
)
@pytest.mark.parametrize(
    ("value", "unit"), [("500", "nanometer"), ("0.5", "micron"), ("5e-7", "meter")]
)
def test_the_thickness_of_a_film_has_a_unit(values, tag, name, value, unit):
    """OpenPBR's is in micrometres; wherever in the graph the number is."""
    number = ("float", f'value="{value}" unit="{unit}" unittype="distance"')
    node = element("constant", "float", "c", value=number)
    for given in (number, "@c"):
        assert values(tag, node, **{name: given})["thin_film_thickness"] == approx(0.5)


def test_directions_that_are_not_set(values):
    """Editors write them as 0, 0, 0."""
    directions = dict.fromkeys(("normal", "coat_normal", "tangent"), ("vector3", "0, 0, 0"))
    found = values("standard_surface", **directions)
    assert not [name for name in found if name.endswith("al")]


def test_an_abbe_number_as_a_scale_is_limited(values):
    with pytest.warns(UrushiWarning, match=r"dispersion_scale leaves \[0, 1\] and is clipped"):
        found = values("open_pbr_surface", transmission_dispersion_scale=55.3)
    assert found == {"transmission_dispersion_scale": 1}


def test_a_document_may_bring_its_own_translation(values):
    translation = """<nodedef name="ND" node="gltf_pbr_to_open_pbr_surface">
        <input name="metallic" type="float" value="1"/>
        <output name="base_metalness_out" type="float"/>
        <output name="coat_weight_out" type="float"/></nodedef>
        <nodegraph name="NG" nodedef="ND">
        <dot name="d" type="float"><input name="in" type="float" interfacename="metallic"/></dot>
        <output name="base_metalness_out" type="float" nodename="d"/>
        <output name="coat_weight_out" type="float" value="0.5"/></nodegraph>"""
    found = values("gltf_pbr", translation, metallic=0.75)
    assert found == {"base_metalness": 0.75, "coat_weight": 0.5}


def test_translations_of_materialx_are_nodes(values):
    """A document may use the library's translation of one shader to another as a node."""
    node = element("standard_surface_to_gltf_pbr", "multioutput", "t", metalness=0.25)
    node += element("dot", "float", "d", in_=("float", 'nodename="t" output="metallic_out"'))
    assert values("gltf_pbr", node, metallic="@d")["base_metalness"] == 0.25
