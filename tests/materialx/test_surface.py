"""Materials of documents: constants, translations, and the examples of OpenPBR."""

import warnings

import numpy as np
import pytest

import urushi
from urushi.errors import FileError, ParameterError, UrushiWarning
from urushi.materialx.surface import read_surface

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
    surface = read_surface(path, None, "A")
    assert surface.name == "A"
    assert surface.values == {
        "base_metalness": 0.25,
        "base_color": (0.5, 0.25, 0.125),
        "geometry_thin_walled": False,
    }
    assert read_surface(path, None, "B").values == {}
    with pytest.raises(ParameterError, match="has several materials; choose one of A, B"):
        read_surface(path, None)
    with pytest.raises(ParameterError, match="has no material 'C'; choose one of A, B"):
        read_surface(path, None, "C")


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
    values = read_surface(path, None).values
    assert values["coat_weight"] == 0.5
    assert values["base_color"] == pytest.approx((1, 1, 1))


@pytest.mark.parametrize(("space", "same"), [("lin_rec709", True), ("acescg", False)])
def test_an_input_takes_the_nearest_colour_space(document, space, same):
    shader = """<open_pbr_surface name="s" type="surfaceshader">
        <input name="base_color" type="color3" value="0.3, 0.2, 0.1"{}/></open_pbr_surface>"""
    inherited = read_surface(document(shader.format(""), space), None).values["base_color"]
    own = shader.format(' colorspace="lin_rec709"')
    given = read_surface(document(own, space), None).values["base_color"]
    assert given == (0.3, 0.2, 0.1)
    assert (inherited == given) is same


def test_a_colour_outside_of_srgb_is_limited_with_a_warning(document):
    path = document(
        """<open_pbr_surface name="s" type="surfaceshader">
        <input name="base_color" type="color3" value="0, 1, 0"/></open_pbr_surface>""",
        "acescg",
    )
    with pytest.warns(UrushiWarning, match=r"base_color leaves \[0, 1\] in linear sRGB"):
        values = read_surface(path, None).values
    assert values["base_color"] == (0, 1, 0)


def test_bright_emission_keeps_its_radiance(document):
    """The luminance multiplies the colour, so that only their product counts."""
    shader = """<open_pbr_surface name="s" type="surfaceshader">
        <input name="emission_color" type="color3" value="4, 2, 1"/>
        <input name="emission_luminance" type="float" value="10"/></open_pbr_surface>"""
    values = read_surface(document(shader), None).values
    assert max(values["emission_color"]) == 1
    product = np.array(values["emission_color"]) * values["emission_luminance"]
    assert product == pytest.approx([40, 20, 10])


def test_values_out_of_range_are_refused(document):
    shader = """<open_pbr_surface name="s" type="surfaceshader">
        <input name="coat_weight" type="float" value="1.5"/></open_pbr_surface>"""
    with pytest.raises(ParameterError, match=r"coat_weight is 1.5; it must be in \[0, 1\]"):
        read_surface(document(shader), None)


def test_standard_surface_is_translated_by_the_library(document, library):
    """The library's graph: base_color takes the tint of the coat, sheen_roughness^0.4 is fuzz's."""
    path = document(
        """<standard_surface name="s" type="surfaceshader">
        <input name="base" type="float" value="0.5"/>
        <input name="base_color" type="color3" value="0.8, 0.4, 0.2"/>
        <input name="specular_IOR" type="float" value="1.7"/>
        <input name="sheen_roughness" type="float" value="0.5"/>
        <input name="thin_film_thickness" type="float" value="500"/>
        <input name="coat" type="float" value="1"/>
        <input name="coat_color" type="color3" value="0.5, 1, 1"/></standard_surface>"""
    )
    values = read_surface(path, None).values
    assert values["base_weight"] == 0.5
    assert values["base_color"] == pytest.approx((0.4, 0.4, 0.2))
    assert values["specular_ior"] == 1.7
    assert values["fuzz_roughness"] == pytest.approx(0.5**0.4)
    assert values["thin_film_thickness"] == pytest.approx(0.5)
    assert values["thin_film_weight"] == 1
    assert values["coat_weight"] == 1


def test_inputs_that_the_translation_leaves_out_are_named(document, library):
    shader = """<standard_surface name="s" type="surfaceshader">
        <input name="coat_rotation" type="float" value="0.5"/></standard_surface>"""
    with pytest.warns(UrushiWarning, match="standard_surface ignores coat_rotation"):
        read_surface(document(shader), None)


@pytest.mark.parametrize("tag", ["gltf_pbr", "UsdPreviewSurface", "disney_principled"])
def test_a_shader_without_a_translation_is_refused(document, library, tag):
    with pytest.raises(FileError, match=f"{tag}, which MaterialX does not translate"):
        read_surface(document(f'<{tag} name="s" type="surfaceshader"/>'), None)


def test_a_document_may_bring_its_own_translation(document, library):
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
    assert read_surface(path, None).values == {"base_metalness": 0.75, "coat_weight": 0.5}


def test_an_old_document_is_upgraded(tmp_path, library):
    """In 1.38, a layer's tint was an input of its own name; here the version alone is old."""
    path = tmp_path / "old.mtlx"
    path.write_text(
        """<materialx version="1.38" colorspace="lin_rec709">
        <nodegraph name="g"><constant name="c" type="color4">
        <input name="value" type="color4" value="0.1, 0.2, 0.3, 0.4"/></constant>
        <swizzle name="s" type="color3"><input name="in" type="color4" nodename="c"/>
        <input name="channels" type="string" value="bgr"/></swizzle>
        <output name="o" type="color3" nodename="s"/></nodegraph>
        <standard_surface name="s" type="surfaceshader">
        <input name="base_color" type="color3" nodegraph="g" output="o"/></standard_surface>
        </materialx>"""
    )
    assert read_surface(path, None).values["base_color"] == pytest.approx((0.3, 0.2, 0.1))


def test_every_example_of_openpbr_is_read(openpbr_examples):
    paths = sorted(openpbr_examples.glob("*.mtlx"))
    assert len(paths) == 83
    for path in paths:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UrushiWarning)  # colours outside of sRGB
            description = urushi.load_materialx(path)
        assert description["type"] == "openpbr"
        assert len(description) > 1


def test_aces_gold_is_gold(openpbr_examples):
    """ACEScg 0.944, 0.776, 0.373 (Gold of the examples) in linear sRGB, by the matrix of OCIO."""
    with pytest.warns(UrushiWarning):
        gold = urushi.load_materialx(openpbr_examples / "open_pbr_gold.mtlx")
    r, g, b = gold["base_color"]["value"]
    assert r == 1
    assert r > g > b > 0.25
