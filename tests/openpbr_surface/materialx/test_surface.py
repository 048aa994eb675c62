"""Materials of documents: constants, translations, and the examples of OpenPBR."""

import warnings

import mitsuba as mi
import numpy as np
import pytest

from urushi.core.fresnel import EDGE_COSINE
from urushi.errors import FileError, ParameterError, UrushiWarning
from urushi.openpbr_surface.materialx.conversions import edge_tint
from urushi.openpbr_surface.materialx.surface import read_surface

TWO = """<open_pbr_surface name="a" type="surfaceshader">
    <input name="base_metalness" type="float" value="0.25"/>
    <input name="base_color" type="color3" value="0.5, 0.25, 0.125"/>
    <input name="geometry_thin_walled" type="boolean" value="false"/>
  </open_pbr_surface>
  <open_pbr_surface name="b" type="surfaceshader"/>
  <surfacematerial name="A" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="a"/></surfacematerial>
  <surfacematerial name="B" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="b"/></surfacematerial>"""


def test_a_material_is_found_by_its_name(document):
    path = document(TWO)
    surface = read_surface(path, "A")
    assert surface.name == "A"
    assert surface.values == {
        "base_metalness": 0.25,
        "base_color": (0.5, 0.25, 0.125),
        "geometry_thin_walled": False,
    }
    assert read_surface(path, "B").values == {}
    with pytest.raises(ParameterError, match="has several materials; choose one of A, B"):
        read_surface(path)
    with pytest.raises(ParameterError, match="has no material 'C'; choose one of A, B"):
        read_surface(path, "C")


def test_a_shader_may_be_in_a_graph_and_in_an_included_file(document):
    document(
        """<nodegraph name="g"><open_pbr_surface name="s" type="surfaceshader">
        <input name="base_color" type="color3" value="1, 1, 1"/>
        <input name="coat_weight" type="float" value="0.5"/></open_pbr_surface>
        <output name="o" type="surfaceshader" nodename="s"/></nodegraph>""",
        space="acescg",
        name="part.mtlx",
    )
    path = document(
        """<xi:include href="part.mtlx"/><surfacematerial name="M" type="material">
        <input name="surfaceshader" type="surfaceshader" nodegraph="g"/></surfacematerial>"""
    )
    values = read_surface(path).values
    assert values["coat_weight"] == 0.5
    assert values["base_color"] == pytest.approx((1, 1, 1))


@pytest.mark.parametrize(("space", "same"), [("lin_rec709", True), ("acescg", False)])
def test_an_input_takes_the_nearest_colour_space(document, space, same):
    shader = """<open_pbr_surface name="s" type="surfaceshader">
        <input name="base_color" type="color3" value="0.3, 0.2, 0.1"{}/></open_pbr_surface>"""
    inherited = read_surface(document(shader.format(""), space)).values["base_color"]
    own = shader.format(' colorspace="lin_rec709"')
    given = read_surface(document(own, space)).values["base_color"]
    assert given == (0.3, 0.2, 0.1)
    assert (inherited == given) is same


def test_a_colour_outside_of_srgb_is_limited_with_a_warning(document):
    path = document(
        """<open_pbr_surface name="s" type="surfaceshader">
        <input name="base_color" type="color3" value="0, 1, 0"/></open_pbr_surface>""",
        "acescg",
    )
    with pytest.warns(UrushiWarning, match=r"base_color leaves \[0, 1\] in linear sRGB"):
        values = read_surface(path).values
    assert values["base_color"] == (0, 1, 0)


def test_bright_emission_keeps_its_radiance(document):
    """The luminance multiplies the colour, so that only their product counts."""
    shader = """<open_pbr_surface name="s" type="surfaceshader">
        <input name="emission_color" type="color3" value="4, 2, 1"/>
        <input name="emission_luminance" type="float" value="10"/></open_pbr_surface>"""
    values = read_surface(document(shader)).values
    assert max(values["emission_color"]) == 1
    product = np.array(values["emission_color"]) * values["emission_luminance"]
    assert product == pytest.approx([40, 20, 10])


def test_an_abbe_number_as_a_scale_is_limited(document):
    shader = """<open_pbr_surface name="s"><input name="transmission_dispersion_scale" type="float"
        value="55.3"/></open_pbr_surface>"""
    with pytest.warns(UrushiWarning, match=r"dispersion_scale leaves \[0, 1\] and is clipped"):
        assert read_surface(document(shader)).values == {"transmission_dispersion_scale": 1}


def inputs(**values):
    """Input elements: a number, a truth value, or a colour as a tuple."""
    kinds = {tuple: "color3", int: "integer", float: "float", bool: "boolean"}
    text = {
        name: ", ".join(map(str, x)) if isinstance(x, tuple) else str(x).lower()
        for name, x in values.items()
    }
    return "".join(
        f'<input name="{name}" type="{kinds[type(x)]}" value="{text[name]}"/>'
        for name, x in values.items()
    )


@pytest.fixture
def translated(document):
    """A function: the parameters of a shader with some inputs; any warning is an error."""

    def values(tag, **given):
        path = document(f'<{tag} name="s" type="surfaceshader">{inputs(**given)}</{tag}>')
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return read_surface(path).values

    return values


def test_a_coat_of_standard_surface_tints_once_and_stays_on_metal(translated):
    """Below the coat's reflection, the graph multiplies any base by coat_color."""
    for metalness in (0.0, 0.00392, 1.0):
        values = translated(
            "standard_surface",
            base=1.0,
            base_color=(1.0, 0.78, 0.34),
            specular=0.2,
            metalness=metalness,
            coat=0.75,
            coat_color=(0.9, 0.2, 0.1),
            coat_roughness=0.05,
        )
        assert values["base_color"] == pytest.approx((1.0, 0.78, 0.34))
        assert values["coat_color"] == pytest.approx((0.9, 0.2, 0.1))
        assert values["coat_weight"] == 0.75
        assert values["coat_darkening"] == 0  # its graph does not darken the base
        assert values["coat_roughness"] == pytest.approx(0.05)
        assert values["specular_weight"] == pytest.approx(0.2 + 0.8 * metalness)


def test_values_of_standard_surface(translated):
    values = translated(
        "standard_surface",
        base_color=(0.5, 0.25, 1.0),
        coat=0.5,
        coat_affect_color=1.0,
        thin_film_thickness=500.0,
        transmission_dispersion=55.3,
        subsurface_radius=(2.0, 1.0, 0.5),
        subsurface_scale=3.0,
        sheen=0.5,
        opacity=(0.3, 0.3, 0.3),
    )
    assert values["base_color"] == pytest.approx((0.5**1.5, 0.25**1.5, 1))  # "coat gamma"
    assert (values["thin_film_thickness"], values["thin_film_weight"]) == (0.5, 1)
    assert values["transmission_dispersion_abbe_number"] == 55.3
    assert values["subsurface_radius"] == 6
    assert values["subsurface_radius_scale"] == (1, 0.5, 0.25)
    assert values["fuzz_weight"] == 0.5
    assert values["geometry_opacity"] == pytest.approx(0.3)


@pytest.mark.parametrize("reflectivity", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("edge", [0.2, 1.0])
def test_the_edge_of_a_metal_is_that_of_its_index(reflectivity, edge):
    """F82 times Schlick's term is Mitsuba's Fresnel term of Gulbrandsen's index, up to a tint of 1.

    The index is equation 6 and 8 of his paper; Mitsuba is in single precision.
    """
    r = reflectivity
    n = edge * (1 - r) / (1 + r) + (1 - edge) * (1 + r**0.5) / (1 - r**0.5)
    k = max(((n + 1) ** 2 * r - (n - 1) ** 2) / (1 - r), 0) ** 0.5
    mi.set_variant("scalar_rgb")
    fresnel = mi.fresnel_conductor(EDGE_COSINE, mi.Complex2f(n, k))
    schlick = r + (1 - r) * (1 - EDGE_COSINE) ** 5
    assert edge_tint(np.full(1, r), np.full(1, edge)) == pytest.approx(
        min(fresnel / schlick, 1), 1e-4
    )


def widths(values, part):
    """The GGX widths along and across the tangent (OpenPBR Surface 1.1.1, "Microfacet")."""
    r, a = values[f"{part}_roughness"], values[f"{part}_roughness_anisotropy"]
    along = r**2 * (2 / (1 + (1 - a) ** 2)) ** 0.5
    return along, (1 - a) * along


def test_anisotropy_keeps_its_widths(translated):
    """MaterialX's node roughness_anisotropy, and glTF's extension KHR_materials_anisotropy."""
    values = translated("standard_surface", specular_roughness=0.5, specular_anisotropy=0.75)
    assert widths(values, "specular") == pytest.approx((0.25 / 0.5, 0.25 * 0.5))
    values = translated("disney_principled", roughness=0.5, anisotropic=0.75)
    assert widths(values, "specular") == pytest.approx((0.25 / 0.5, 0.25 * 0.5))
    values = translated("gltf_pbr", roughness=0.5, anisotropy_strength=0.6)
    assert widths(values, "specular") == pytest.approx((0.25 + 0.75 * 0.36, 0.25))


def reflectance(ior):
    return ((ior - 1) / (ior + 1)) ** 2


def test_gltf_pbr(translated):
    """A sheen of colour c is a fuzz of weight max c; emission above 1 goes into the luminance."""
    values = translated(
        "gltf_pbr",
        base_color=(0.1, 0.2, 0.3),
        metallic=0.0,
        specular_color=(2.0, 1.0, 0.5),
        specular=0.5,
        ior=1.4,
        clearcoat=0.7,
        clearcoat_roughness=0.2,
        sheen_color=(0.2, 0.4, 0.1),
        emissive=(0.5, 0.25, 0.0),
        emissive_strength=8.0,
        iridescence_thickness=300.0,
        alpha=0.3,
    )
    tint = values["specular_weight"] * np.array(values["specular_color"])
    assert tint == pytest.approx((1.0, 0.5, 0.25))
    assert values["fuzz_weight"] * np.array(values["fuzz_color"]) == pytest.approx((0.2, 0.4, 0.1))
    light = values["emission_luminance"] * np.array(values["emission_color"])
    assert light == pytest.approx((4, 2, 0))
    assert values["thin_film_thickness"] == pytest.approx(0.3)
    assert values["geometry_opacity"] == 1  # alpha_mode is OPAQUE
    assert (values["coat_weight"], values["coat_ior"], values["specular_ior"]) == (0.7, 1.5, 1.4)
    assert not translated("gltf_pbr")["geometry_thin_walled"]
    assert translated("gltf_pbr", alpha=0.3, alpha_mode=1)["geometry_opacity"] == 0
    assert translated("gltf_pbr", alpha=0.3, alpha_mode=2)["geometry_opacity"] == 0.3


def test_a_volume_of_gltf(translated):
    """One of no thickness is a thin wall (KHR_materials_volume).

    base_color tints light that crosses the surface, the attenuation what passes the inside.
    OpenPBR has both in one colour.
    """
    amber, white = (0.5, 0.6, 0.7), (1.0, 1.0, 1.0)
    volume = dict(transmission=1.0, attenuation_color=amber, attenuation_distance=3.0)
    for thickness, base, color, depth in (
        (0.0, (0.1, 0.2, 0.3), (0.1, 0.2, 0.3), 0),
        (0.0, white, white, 0),
        (2.0, white, amber, 3),
    ):
        glass = translated("gltf_pbr", thickness=thickness, base_color=base, **volume)
        assert glass["geometry_thin_walled"] == (thickness == 0)
        assert glass["transmission_color"] == pytest.approx(color)
        assert glass["transmission_depth"] == depth
    clear = translated("gltf_pbr", thickness=2.0, transmission=1.0, base_color=amber)
    assert (clear["transmission_color"], clear["transmission_depth"]) == (pytest.approx(amber), 0)
    with pytest.raises(UrushiWarning, match="no counterpart of attenuation_color of gltf_pbr"):
        translated("gltf_pbr", thickness=2.0, base_color=(0.1, 0.2, 0.3), **volume)


@pytest.mark.parametrize(
    ("given", "thin"),
    [
        ("transmission=map", True),
        ("transmission=map thickness=1", False),
        ("transmission=1 thickness=map", False),
        ("transmission=map thickness=map", False),
        ("thickness=map", False),
    ],
)
def test_maps_of_transmission_and_thickness(document, given, thin):
    """A surface is a thin wall, or none: where the map of thickness is 0, a volume ends."""
    mask = """<splitlr name="map" type="float"><input name="valuel" type="float" value="0"/>
        <input name="valuer" type="float" value="1"/></splitlr>"""
    text = "".join(
        f'<input name="{name}" type="float" {"nodename" if x == "map" else "value"}="{x}"/>'
        for name, _, x in (pair.partition("=") for pair in given.split())
    )
    path = document(f'{mask}<gltf_pbr name="s" type="surfaceshader">{text}</gltf_pbr>')
    assert read_surface(path, resolution=8).values["geometry_thin_walled"] is thin


@pytest.mark.parametrize(
    ("tag", "given"),
    [
        ("standard_surface", dict(transmission=1.0, specular=0.2, specular_color=(1.0, 0.5, 0.1))),
        (
            "gltf_pbr",
            dict(transmission=1.0, metallic=0.0, specular=0.2, specular_color=(1.0, 0.5, 0.1)),
        ),
        (
            "UsdPreviewSurface",
            dict(opacity=0.0, useSpecularWorkflow=1, specularColor=(0.008, 0.004, 0.0008)),
        ),
        (
            "disney_principled",
            dict(specTrans=1.0, specular=0.1, specularTint=1.0, baseColor=(1.0, 0.5, 0.1)),
        ),
    ],
)
def test_the_strength_of_reflections_does_not_bend_light(translated, tag, given):
    """In the graphs, dielectric_bsdf refracts by the index, whatever the reflection's weight."""
    smooth = {"UsdPreviewSurface": "roughness", "disney_principled": "roughness"}.get(tag)
    values = translated(tag, **given, **({smooth: 0.0} if smooth else {}))
    assert (values["specular_ior"], values.get("specular_weight", 1)) == (1.5, 1)
    assert values["specular_color"] == pytest.approx((0.2, 0.1, 0.02))


@pytest.mark.parametrize("varying", ["specular", "metalness"])
def test_a_body_has_one_index(document, varying):
    """What lets light inside needs one index: a map of the strength of reflections tints them."""
    ramp = """<ramplr name="map" type="float"><input name="valuel" type="float" value="0.2"/>
        <input name="valuer" type="float" value="0.4"/></ramplr>"""
    text = inputs(subsurface=1.0, **({"specular": 0.2} if varying == "metalness" else {}))
    text += f'<input name="{varying}" type="float" nodename="map"/>'
    path = document(f'{ramp}<standard_surface name="s">{text}</standard_surface>')
    values = read_surface(path, resolution=8).values
    assert values["specular_weight"] == 1
    assert 0.2 <= values["specular_color"].pixels.min() < values["specular_color"].pixels.max() < 1


def test_the_leaf_of_standard_surface_transmits_all(translated):
    """Its translucent_bsdf reflects nothing; OpenPBR's wall transmits (1 + g) / 2."""
    leaf = translated("standard_surface", subsurface=1.0, subsurface_anisotropy=0.5)
    assert leaf["subsurface_scatter_anisotropy"] == 0.5
    leaf = translated("standard_surface", subsurface=1.0, thin_walled=True)
    assert leaf["subsurface_scatter_anisotropy"] == 1


def test_transmitted_light_has_its_own_roughness(document):
    """The transmission of UsdPreviewSurface is smooth; a mixture keeps its opaque share rough.

    Of metalness m and opacity o, (1 - m) (1 - o) is clear; the rest has all of the metal.
    """
    text = inputs(opacity=0.5, metallic=0.4, roughness=0.6)
    path = document(f'<UsdPreviewSurface name="s" type="surfaceshader">{text}</UsdPreviewSurface>')
    with pytest.warns(UrushiWarning, match="both get that of transmitted light"):
        mix = read_surface(path)
    assert mix.weight == pytest.approx(0.3)
    clear, opaque = mix.fg.values, mix.bg.values
    assert (clear["specular_roughness"], clear["transmission_weight"]) == (0, 1)
    assert (opaque["specular_roughness"], opaque["transmission_weight"]) == (0.6, 0)
    assert (clear["base_metalness"], opaque["base_metalness"]) == (0, pytest.approx(0.4 / 0.7))
    text = inputs(opacity=0.5, emissiveColor=(1.0, 0.5, 0.0))
    path = document(f'<UsdPreviewSurface name="s" type="surfaceshader">{text}</UsdPreviewSurface>')
    with pytest.warns(UrushiWarning, match="both get that of reflected light"):
        assert read_surface(path).values["emission_color"] == (1, 0.5, 0)  # mixtures have none
    text = inputs(transmission=1.0, transmission_extra_roughness=0.2, specular_roughness=0.3)
    path = document(f'<standard_surface name="s" type="surfaceshader">{text}</standard_surface>')
    with pytest.warns(UrushiWarning, match="both get that of transmitted light"):
        assert read_surface(path).values["specular_roughness"] == pytest.approx(0.5)


def test_usd_preview_surface(translated):
    values = translated(
        "UsdPreviewSurface",
        useSpecularWorkflow=1,
        specularColor=(0.04, 0.16, 0.08),
        metallic=1.0,
        clearcoat=0.5,
    )
    f0 = reflectance(values["specular_ior"]) * np.array(values["specular_color"])
    assert f0 == pytest.approx((0.04, 0.16, 0.08))
    assert (values["base_metalness"], values["coat_weight"]) == (0, 0.5)
    assert values["emission_luminance"] == 0
    clear = translated("UsdPreviewSurface", opacity=0.25, roughness=0.0, metallic=0.5)
    assert (clear["transmission_weight"], clear["base_metalness"]) == (0.75, 0.5)
    cut = translated("UsdPreviewSurface", opacity=0.25, opacityThreshold=0.5)
    assert (cut["transmission_weight"], cut["geometry_opacity"]) == (0, 0)


@pytest.mark.parametrize("color", [(0.9, 0.6, 0.3), (0.5, 0.5, 0.5), (0.3, 0.2, 0.26)])
@pytest.mark.parametrize("diffuse", [0.0, 0.1, 0.6])
def test_a_bright_specular_color_is_a_metal_s(translated, color, diffuse):
    """Indices end at 3, so that dielectrics reflect a quarter at most along the normal."""
    diffuse = (diffuse,) * 3
    values = translated(
        "UsdPreviewSurface", useSpecularWorkflow=1, specularColor=color, diffuseColor=diffuse
    )
    metal, base = values["base_metalness"], np.array(values["base_color"])
    f0 = reflectance(values["specular_ior"])
    assert f0 == pytest.approx(0.25)
    tint = (np.array(values["specular_color"]) - metal) / max(1 - metal, 1e-6)  # of the dielectric
    found = metal * base + (1 - metal) * f0 * tint
    assert found.max() == pytest.approx(max(color), abs=0.01)
    kept = (1 - metal) * (1 - f0) * base
    assert kept.max() == pytest.approx((1 - max(color)) * diffuse[0], abs=0.03)


def test_disney_principled(translated):
    """Burley 2012: specular is F0 / 0.08, and a gloss of clearcoat is 1 - roughness."""
    values = translated("disney_principled", specular=0.75, clearcoat=1.0, clearcoatGloss=0.9)
    assert reflectance(values["specular_ior"]) == pytest.approx(0.06)
    assert values["coat_roughness"] == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("tag", "kept", "lost"),
    [
        ("standard_surface", "specular_rotation", {"specular_anisotropy": 0.5}),
        ("gltf_pbr", "anisotropy_rotation", {"anisotropy_strength": 0.5}),
    ],
)
def test_a_warning_says_what_is_lost(translated, tag, kept, lost):
    """An input that the other inputs leave without effect is not lost."""
    translated(tag, **{kept: 0.2})
    with pytest.raises(UrushiWarning, match=f"no counterpart of {kept} of {tag}"):
        translated(tag, **{kept: 0.2}, **lost)


def test_shaders_of_other_sides_are_named(document):
    """A displacement by nothing is not lost."""
    displaced = """<displacement name="d" type="displacementshader">
        <input name="displacement" type="float" value="0.1"/></displacement>
        <standard_surface name="s" type="surfaceshader"/>
        <surfacematerial name="m" type="material">
        <input name="surfaceshader" type="surfaceshader" nodename="s"/>
        <input name="{}" type="{}" nodename="{}"/></surfacematerial>"""
    for given, part in (
        (("displacementshader", "displacementshader", "d"), "displacement"),
        (("backsurfaceshader", "surfaceshader", "s"), "back's shader"),
    ):
        with pytest.warns(UrushiWarning, match=f"its {part} is left out"):
            read_surface(document(displaced.format(*given)))
    flat = displaced.format("displacementshader", "displacementshader", "d").replace("0.1", "0")
    read_surface(document(flat))


SHADER = """<open_pbr_surface name="s" type="surfaceshader">
    <input name="base_color" type="color3" {}/></open_pbr_surface>
    <output name="out" type="surfaceshader" nodename="s"/>"""
PAINT = (
    '<constant name="paint" type="color3"><input name="value" type="color3" value="{}"/></constant>'
)
MATERIAL = """<surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" {}="{}"/></surfacematerial>"""
OF_GRAPH, OF_NODE = MATERIAL.format("nodegraph", "g"), MATERIAL.format("nodename", "s")
RED = PAINT.format("1, 0, 0")
GREEN = PAINT.format("0, 1, 0")
INSIDE = SHADER.format('nodename="paint"')
INTERFACE = SHADER.format('interfacename="c"')


@pytest.mark.parametrize(
    "body",
    [
        f'{RED}<nodegraph name="g">{GREEN}{INSIDE}</nodegraph>{OF_GRAPH}',
        f'{RED}<nodegraph name="g">{GREEN}{INSIDE}{OF_NODE}</nodegraph>',
        f"""{RED}<nodegraph name="o"><nodegraph name="g">{GREEN}{INSIDE}</nodegraph>
        <output name="out" type="surfaceshader" nodegraph="g"/></nodegraph>
        {OF_GRAPH.replace('"g"', '"o" output="out"')}""",
        f"""{GREEN}<nodegraph name="g"><input name="c" type="color3" nodename="paint"/>
        {RED}{INTERFACE}</nodegraph>{OF_GRAPH}""",
        f"""<nodegraph name="g"><input name="c" type="color3" value="0, 1, 0"/>
        {RED}{INTERFACE}</nodegraph>{OF_GRAPH}""",
        f"""<nodedef name="ND" node="coat_of_paint"><input name="c" type="color3" value="1, 0, 0"/>
        <output name="out" type="surfaceshader"/></nodedef>
        <nodegraph name="NG" nodedef="ND">{RED}{INTERFACE}</nodegraph>{GREEN}
        <coat_of_paint name="p" type="surfaceshader">
        <input name="c" type="color3" nodename="paint"/></coat_of_paint>
        {OF_NODE.replace('"s"', '"p"')}""",
        f'{RED}<nodegraph name="g">{GREEN}{INSIDE}</nodegraph>',
    ],
    ids=["graph", "material", "nested", "interface", "value", "functional", "shader only"],
)
def test_names_belong_to_their_graph(document, body):
    """The shader's colour is green; a node of the same name in another scope is red."""
    assert read_surface(document(body)).values["base_color"] == (0, 1, 0)


@pytest.mark.parametrize(
    ("tag", "name"),
    [("open_pbr_surface", "thin_film_thickness"), ("gltf_pbr", "iridescence_thickness")],
)
@pytest.mark.parametrize(
    ("value", "unit"), [("500", "nanometer"), ("0.5", "micron"), ("5e-7", "meter")]
)
def test_the_thickness_of_a_film_has_a_unit(document, tag, name, value, unit):
    """OpenPBR's is in micrometres; wherever in the graph the number is."""
    number = f'type="float" value="{value}" unit="{unit}" unittype="distance"'
    shader = f'<{tag} name="s" type="surfaceshader"><input name="{name}" {{}}/></{tag}>'
    direct = document(shader.format(number))
    assert read_surface(direct).values["thin_film_thickness"] == pytest.approx(0.5)
    node = f'<constant name="c" type="float"><input name="value" {number}/></constant>'
    linked = document(node + shader.format('type="float" nodename="c"'))
    assert read_surface(linked).values["thin_film_thickness"] == pytest.approx(0.5)


def test_unknown_shaders_are_refused(document):
    with pytest.raises(FileError, match="of kind simple_hair, which is not read; translate it to"):
        read_surface(document('<simple_hair name="s" type="surfaceshader"/>'))
    mix = """<mix name="m" type="surfaceshader"/><surfacematerial name="x" type="material">
        <input name="surfaceshader" type="surfaceshader" nodename="m"/></surfacematerial>"""
    with pytest.raises(FileError, match=r"node 'm' \(mix\): its bg is connected to no surface"):
        read_surface(document(mix))
    chain = "".join(
        f"""<mix name="m{k}" type="surfaceshader"><input name="mix" type="float" value="0.5"/>
        <input name="bg" type="surfaceshader" nodename="m{k - 1}"/>
        <input name="fg" type="surfaceshader" nodename="m{k - 1}"/></mix>"""
        for k in range(1, 40)
    )
    shader = '<open_pbr_surface name="m0" type="surfaceshader"/>'
    with pytest.raises(FileError, match="mixes more than 16 surface shaders"):
        read_surface(document(shader + chain), "m39")


def test_directions_that_are_not_set(document):
    """Editors write them as 0, 0, 0."""
    directions = "".join(
        f'<input name="{name}" type="vector3" value="0, 0, 0"/>'
        for name in ("normal", "coat_normal", "tangent")
    )
    path = document(f'<standard_surface name="s">{directions}</standard_surface>')
    assert not [name for name in read_surface(path).values if name.endswith("al")]


def test_a_document_may_bring_its_own_translation(document):
    path = document(
        """<nodedef name="ND" node="gltf_pbr_to_open_pbr_surface">
        <input name="metallic" type="float" value="1"/>
        <output name="base_metalness_out" type="float"/>
        <output name="coat_weight_out" type="float"/></nodedef>
        <nodegraph name="NG" nodedef="ND">
        <dot name="d" type="float"><input name="in" type="float" interfacename="metallic"/></dot>
        <output name="base_metalness_out" type="float" nodename="d"/>
        <output name="coat_weight_out" type="float" value="0.5"/></nodegraph>
        <gltf_pbr name="s" type="surfaceshader">
        <input name="metallic" type="float" value="0.75"/></gltf_pbr>"""
    )
    assert read_surface(path).values == {"base_metalness": 0.75, "coat_weight": 0.5}


def test_an_old_document_is_upgraded(tmp_path):
    """Swizzles are of 1.38. A pattern of file names, which is escaped in XML, stays so."""
    path = tmp_path / "old.mtlx"
    path.write_text(
        """<materialx version="1.38" colorspace="lin_rec709">
        <nodegraph name="g"><constant name="c" type="color4">
        <input name="value" type="color4" value="0.1, 0.2, 0.3, 0.4"/></constant>
        <swizzle name="s" type="color3"><input name="in" type="color4" nodename="c"/>
        <input name="channels" type="string" value="bgr"/></swizzle>
        <output name="o" type="color3" nodename="s"/></nodegraph>
        <image name="i" type="color3"><input name="file" type="filename" value="&lt;UDIM&gt;.png"/>
        </image>
        <standard_surface name="s" type="surfaceshader">
        <input name="base_color" type="color3" nodegraph="g" output="o"/></standard_surface>
        </materialx>"""
    )
    assert read_surface(path).values["base_color"] == pytest.approx((0.3, 0.2, 0.1))


def test_translations_of_materialx_are_nodes(document):
    """A document may use the library's translation of one shader to another as a node."""
    node = """<standard_surface_to_gltf_pbr name="t" type="multioutput">
        <input name="metalness" type="float" value="0.25"/></standard_surface_to_gltf_pbr>
        <gltf_pbr name="s" type="surfaceshader"><input name="metallic" type="float" nodename="t"
        output="metallic_out"/></gltf_pbr>"""
    assert read_surface(document(node)).values["base_metalness"] == 0.25
