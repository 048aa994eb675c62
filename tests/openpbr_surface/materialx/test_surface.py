"""Materials of documents: names, scopes, colour spaces, mixtures and what is left out."""

import pytest
from tests.openpbr_surface.materialx.conftest import element

from urushi.errors import ParameterError, UrushiWarning
from urushi.openpbr_surface.materialx.surface import read_surface

SHADER = """<open_pbr_surface name="s" type="surfaceshader">
    <input name="base_color" type="color3" {}/></open_pbr_surface>"""
OUTPUT = '<output name="out" type="surfaceshader" nodename="s"/>'
MATERIAL = """<surfacematerial name="{}" type="material">
    <input name="surfaceshader" type="surfaceshader" {}="{}"/></surfacematerial>"""
A = dict(base_metalness=0.25, base_color=(0.5, 0.25, 0.125), geometry_thin_walled=False)
TWO = element("open_pbr_surface", "surfaceshader", "a", **A)
TWO += element("open_pbr_surface", "surfaceshader", "b")
TWO += MATERIAL.format("A", "nodename", "a") + MATERIAL.format("B", "nodename", "b")


def test_a_material_is_found_by_its_name(document):
    path = document(TWO)
    surface = read_surface(path, "A")
    assert surface.name == "A"
    assert surface.values == A
    assert read_surface(path, "B").values == {}
    with pytest.raises(ParameterError, match="has several materials; choose one of A, B"):
        read_surface(path)
    with pytest.raises(ParameterError, match="has no material 'C'; choose one of A, B"):
        read_surface(path, "C")


def test_a_shader_may_be_in_a_graph_and_in_an_included_file(document):
    white = dict(base_color=(1.0, 1.0, 1.0), coat_weight=0.5)
    shader = element("open_pbr_surface", "surfaceshader", "s", **white)
    graph = f'<nodegraph name="g">{shader}{OUTPUT}</nodegraph>'
    document(graph, space="acescg", name="part.mtlx")
    path = document('<xi:include href="part.mtlx"/>' + MATERIAL.format("M", "nodegraph", "g"))
    values = read_surface(path).values
    assert values["coat_weight"] == 0.5
    assert values["base_color"] == pytest.approx((1, 1, 1))


def test_included_files_include_files_beside_them_or_beside_the_document(tmp_path, document):
    (tmp_path / "parts").mkdir()
    document('<xi:include href="paint.mtlx"/>', name="parts/all.mtlx")
    text = '<xi:include href="parts/all.mtlx"/>' + SHADER.format('nodename="paint"')
    for name, colour in (("paint.mtlx", (0.5, 0.25, 0.75)), ("parts/paint.mtlx", (0, 1, 0.5))):
        document(PAINT.format(str(colour)[1:-1]), name=name)
        assert read_surface(document(text)).values["base_color"] == colour


@pytest.mark.parametrize(("space", "same"), [("lin_rec709", True), ("acescg", False)])
def test_an_input_takes_the_nearest_colour_space(document, space, same):
    text = 'value="0.3, 0.2, 0.1"'
    inherited = read_surface(document(SHADER.format(text), space)).values["base_color"]
    own = SHADER.format(text + ' colorspace="lin_rec709"')
    given = read_surface(document(own, space)).values["base_color"]
    assert given == (0.3, 0.2, 0.1)
    assert (inherited == given) is same


def test_a_colour_outside_of_srgb_is_limited_with_a_warning(document):
    path = document(SHADER.format('value="0, 1, 0"'), "acescg")
    with pytest.warns(UrushiWarning, match=r"base_color leaves \[0, 1\] in linear sRGB"):
        values = read_surface(path).values
    assert values["base_color"] == (0, 1, 0)


@pytest.mark.parametrize(("sum_of", "expected"), [(0.70002, 1.0), (-0.3000001, 0.0)])
def test_a_number_that_rounding_moves_out_of_its_range_is_at_the_range_s_end(
    document, sum_of, expected
):
    total = element("add", "float", "sum", in1=0.3, in2=sum_of)
    shader = element("open_pbr_surface", "surfaceshader", coat_weight="@sum")
    assert read_surface(document(total + shader)).values == {"coat_weight": expected}
    far = document(shader.replace('nodename="sum"', 'value="1.2"'))
    with pytest.raises(ParameterError, match=r"coat_weight is 1.2; it must be in \[0, 1\]"):
        read_surface(far)


PAINT = (
    '<constant name="paint" type="color3"><input name="value" type="color3" value="{}"/></constant>'
)
OF_GRAPH, OF_NODE = MATERIAL.format("m", "nodegraph", "g"), MATERIAL.format("m", "nodename", "s")
RED = PAINT.format("1, 0, 0")
GREEN = PAINT.format("0, 1, 0")
INSIDE = SHADER.format('nodename="paint"') + OUTPUT
INTERFACE = SHADER.format('interfacename="c"') + OUTPUT


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
        f'<input name="c" type="color3" value="0, 1, 0"/>{INTERFACE}',
    ],
    ids=["graph", "material", "nested", "interface", "value", "functional", "shader", "document"],
)
def test_names_belong_to_their_graph(document, body):
    """The shader's colour is green; a node of the same name in another scope is red."""
    assert read_surface(document(body)).values["base_color"] == (0, 1, 0)


def test_shaders_of_other_sides_are_named(document):
    """A displacement by nothing is not lost."""

    def read(height=0.1, **other):
        body = element("displacement", "displacementshader", "d", displacement=height)
        body += element("standard_surface", "surfaceshader", "s")
        sides = {"surfaceshader": ("surfaceshader", "@s")} | other
        read_surface(document(body + element("surfacematerial", "material", "m", **sides)))

    displaced = {"displacementshader": ("displacementshader", "@d")}
    with pytest.warns(UrushiWarning, match="its displacement is left out"):
        read(**displaced)
    with pytest.warns(UrushiWarning, match="its back's shader is left out"):
        read(backsurfaceshader=("surfaceshader", "@s"))
    read(height=0.0, **displaced)


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
