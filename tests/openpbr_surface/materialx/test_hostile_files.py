"""Damaged, foreign and malicious documents: one error sentence each, and bounded memory."""

import struct
import zlib

import numpy as np
import pytest
from tests.fuzzing import bounded, fuzz
from tests.openpbr_surface.materialx.conftest import HEAD, element, write_image

from urushi.errors import FileError, ParameterError
from urushi.openpbr_surface.materialx import images
from urushi.openpbr_surface.materialx.graph import library
from urushi.openpbr_surface.materialx.surface import read_surface

BOMB = """<?xml version="1.0"?><!DOCTYPE m [<!ENTITY a "aaaaaaaaaa">
<!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;"><!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;">]>
<materialx version="1.39"><x name="&c;"/></materialx>"""

SURFACE = '<open_pbr_surface name="s" type="surfaceshader">{}</open_pbr_surface>'
INPUT = SURFACE.format('<input name="base_color" type="color3" {}/>')
COLOUR = INPUT.format('nodename="n"')
IMAGE = """<image name="n" type="color3"><input name="file" type="filename" value="{}"/></image>"""
MATERIAL = """<surfacematerial name="m" type="material">
    <input name="surfaceshader" type="surfaceshader" {}="{}"/></surfacematerial>"""
OUTPUT = '<nodegraph name="{}"><output name="o" type="color3" nodegraph="{}"/></nodegraph>'
MIX = """<mix name="{}" type="surfaceshader"><input name="mix" type="float" value="0.5"/>
    <input name="bg" type="surfaceshader" nodename="{}"/></mix>"""
LINK = '<add name="{}" type="color3"><input name="in1" type="color3" nodename="{}"/></add>'


def refused(path, message):
    with pytest.raises((FileError, ParameterError), match=message) as caught:
        read_surface(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is not a MaterialX document: it has no element <materialx>"),
        (b"\x00\x01", "is not a MaterialX document"),
        (b"<html></html>", "is not a MaterialX document"),
        (b"<materialx>\xff</materialx>", "cannot read the MaterialX file .*utf-8"),
        (b"<materialx>", "refused by the package materialx .*tags mismatch"),
        (BOMB.encode(), "has no material"),  # entities are not expanded
        (b'<!DOCTYPE x SYSTEM "file:///etc/passwd"><materialx/>', "has no material"),
        (b'<materialx version="2.0"/>', "is of MaterialX 2.0; up to 1.39 can be read"),
        (b'<materialx version="new"/>', "has version 'new'"),
        (
            b"<materialx>" + b'<a name="a">' * 999 + b"</a>" * 999 + b"</materialx>",
            "Maximum tree depth exceeded",
        ),
        (b"<materialx><a/></materialx>", "has an element <a> without a name"),
        (b"<materialx>" + b" " * (17 << 20) + b"</materialx>", "larger than 16 MiB"),
    ],
)
def test_a_bad_file_gets_one_sentence(tmp_path, content, message):
    path = tmp_path / "bad.mtlx"
    path.write_bytes(content)
    assert "bad.mtlx" in refused(path, message)


def circle_of_graphs():
    graph = """<nodegraph name="{0}"><input name="i" type="color3" nodegraph="{1}"/>
        <dot name="d" type="color3"><input name="in" type="color3" interfacename="i"/></dot>
        <output name="o" type="color3" nodename="d"/></nodegraph>"""
    return graph.format("a", "b") + graph.format("b", "a") + INPUT.format('nodegraph="a"')


def wide_tree():
    """Distinct nodes, four inputs each: more than 5,000."""

    def node(i):
        links = {f"in{k}": f"@n{4 * i + k}" for k in range(1, 5)}
        return element("switch", "float", f"n{i or ''}", **links)

    leaves = (element("constant", "float", f"n{i}") for i in range(1365, 5461))
    return "".join([*map(node, range(1365)), *leaves]) + COLOUR


def doubling_definitions():
    """Each of 24 definitions uses the next twice: 2^24 nodes if they were all evaluated."""
    body = ""
    for i in range(24):
        node = f"d{i + 1}" if i < 23 else "add"
        body += f"""<nodedef name="ND_{i}" node="d{i}"><input name="in" type="color3"/>
            <output name="out" type="color3"/></nodedef>
            <nodegraph name="NG_{i}" nodedef="ND_{i}">
            <{node} name="x" type="color3"/><{node} name="y" type="color3"/>
            <add name="z" type="color3"><input name="in1" type="color3" nodename="x"/>
            <input name="in2" type="color3" nodename="y"/></add>
            <output name="out" type="color3" nodename="z"/></nodegraph>"""
    return body + '<d0 name="n" type="color3"/>' + COLOUR


NO_COLOURS = ("1", "1, 2", "0.5, , 1", "0.5 e 1", "nan, 0, 0", "1e999, 0, 0", "x, y, z", "1,2,3,4")

BODIES = {
    "a circle of nodes": (
        LINK.format("n", "b") + LINK.format("b", "n") + COLOUR,
        "is connected to itself; remove the cycle",
    ),
    "a circle of graphs": (circle_of_graphs(), r"node 'd' \(dot\) is connected to itself; remove"),
    "a circle of outputs": (
        OUTPUT.format("n", "b") + OUTPUT.format("b", "n") + INPUT.format('nodegraph="n"'),
        "node 's' .* connected to 'n/o', which is connected to itself; remove the cycle",
    ),
    "a circle of texts": (
        IMAGE.replace("value", "nodename").format("c")
        + element("constant", "filename", "c", value=("filename", "@c"))
        + COLOUR,
        r"node 'c' \(constant\) is connected to itself; remove the cycle",
    ),
    "a node inside of itself": (
        """<nodedef name="ND" node="d"><output name="out" type="color3"/></nodedef>
        <nodegraph name="NG" nodedef="ND"><d name="x" type="color3"/>
        <add name="y" type="color3"><input name="in1" type="color3" nodename="x"/></add>
        <output name="out" type="color3" nodename="y"/></nodegraph><d name="n" type="color3"/>"""
        + COLOUR,
        r"node 'x' \(d\) is used by its own definition; remove the cycle",
    ),
    "a position of four channels": (
        element("constant", "vector4", "p", value=("vector4", "1, 2, 3, 4"))
        + element("noise2d", "color3", texcoord=("vector2", "@p"))
        + COLOUR,
        "numbers of channels do not match its type vector3; check them",
    ),
    "a shader of unequal inputs": (
        element("constant", "vector2", "n", value=("vector2", "1, 2"))
        + element("standard_surface", "surfaceshader", "s", specular_color=("color3", "@n")),
        r"node 's' \(standard_surface\): specular_color has 2 channels instead of 3",
    ),
    "a circle of definitions": (
        """<nodedef name="A" node="a" inherit="B"><output name="out" type="color3"/></nodedef>
        <nodedef name="B" node="b" inherit="A"><output name="out" type="color3"/></nodedef>
        <a name="n" type="color3"/>"""
        + COLOUR,
        "inherits from itself",
    ),
    "a long chain": (
        "".join(LINK.format(f"n{i or ''}", f"n{i + 1}") for i in range(5000)) + COLOUR,
        "a chain of more than 80 nodes|nested too",
    ),
    "a wide tree": (wide_tree(), "more than 2048 nodes"),
    "definitions that double": (doubling_definitions(), "more than (2048|80) nodes"),
    # The package names every text, in a time that grows with the square of their number.
    "texts": ("".join(f'text <a name="a{k}"/>' for k in range(20_000)), "has no material"),
    **{x: (INPUT.format(f'value="{x}"'), "which is not of type color3") for x in NO_COLOURS},
    "a division by zero": (
        '<divide name="n" type="color3"><input name="in2" type="color3" value="0,0,0"/></divide>'
        + COLOUR,
        "not finite everywhere",
    ),
    "no node": (COLOUR, "is connected to 'n', which does not exist"),
    "no such node": ('<magic name="n" type="color3"/>' + COLOUR, "not supported"),
    "no type": ('<add name="n"/>' + COLOUR, "has no type; give it one"),
    "no graph": (INPUT.format('interfacename="c"'), "from a node graph, but is not inside one"),
    "no parameter": (SURFACE.format('<input name="colour" type="color3"/>'), "no parameter"),
    "no unit": (INPUT.format('value="1, 1, 1" unit="cubit"'), "in 'cubit', an unknown unit; use"),
    "a unit of no size": (
        '<unitdef name="U" unittype="angle"><unit name="turn" scale="big"/></unitdef>'
        + INPUT.format('value="1, 1, 1" unit="turn"'),
        "the unit 'turn' has no number as scale",
    ),
    "no shader": (MATERIAL.format("nodename", "n"), "which does not exist"),
    "no connection": (
        '<surfacematerial name="m" type="material"/>',
        "is connected to no surface shader",
    ),
    "no such shader": (
        '<simple_hair name="s" type="surfaceshader"/>',
        "of kind simple_hair, which is not read; translate it to",
    ),
    "an empty mixture": (
        '<mix name="s" type="surfaceshader"/>' + MATERIAL.format("nodename", "s"),
        r"node 's' \(mix\): its bg is connected to no surface shader",
    ),
    "a mixture with itself": (
        MIX.format("s", "s") + MATERIAL.format("nodename", "s"),
        r"node 's' \(mix\) is connected to itself; remove the cycle",
    ),
    "many shaders": (
        "".join(MIX.format(f"s{i}", f"s{i + 1}") for i in range(17))
        + MATERIAL.format("nodename", "s0"),
        "mixes more than 16 surface shaders",
    ),
    "a direction in space": (
        SURFACE.format('<input name="geometry_normal" type="vector3" value="1, 0, 1"/>'),
        "geometry_normal is a constant direction in space",
    ),
    **{
        name[:20]: (
            IMAGE.format(name.replace("<", "&lt;")) + COLOUR,
            "image .* (does not exist|is not a file|depends on the geometry by <Part>|cannot be)",
        )
        for name in ("none.png", ".", "[T].png", "a<UDIM>.png", "a<Part>.png", "\u00e4" * 3000)
    },
}


@pytest.mark.parametrize("case", BODIES)
def test_a_bad_graph_gets_one_sentence(document, case):
    body, message = BODIES[case]
    refused(document(body), message)


def test_a_missing_file_and_a_folder(tmp_path):
    refused(tmp_path / "none.mtlx", "there is no MaterialX file")
    refused(tmp_path, "there is no MaterialX file")
    (tmp_path / "Paint.mtlx").write_text("<materialx/>")
    refused(tmp_path / "paint.mtlx", "there is no .*/Paint.mtlx' differs in case only")


def test_memory_is_bounded_by_the_limits(tmp_path):
    """A file of 16 MiB of elements stops at 50,000, which take less than 64 MiB."""
    path = tmp_path / "huge.mtlx"
    path.write_bytes(b"<materialx>" + b'<a name="a"/>' * (1 << 20))
    with bounded(64 << 20):
        refused(path, "more than 50000 elements")


@pytest.mark.parametrize(
    "href", ["../other.mtlx", "/etc/passwd", "a/../../other.mtlx", "link.mtlx"]
)
def test_includes_stay_in_the_folder(tmp_path, document, href):
    (tmp_path / "inside").mkdir()
    (tmp_path / "other.mtlx").write_text("<materialx/>")
    (tmp_path / "inside" / "link.mtlx").symlink_to(tmp_path / "other.mtlx")
    path = document(f'<xi:include href="{href}"/>', name="inside/material.mtlx")
    refused(path, f"includes '{href}' outside its folder")


def test_includes_share_the_limits(document):
    document('<xi:include href="a.mtlx"/>', name="b.mtlx")
    refused(document('<xi:include href="b.mtlx"/>', name="a.mtlx"), "cycle detected")
    document("".join(f'<a name="a{k}"/>' for k in range(20_000)), name="part.mtlx")
    path = document('<xi:include href="part.mtlx"/>' * 5)
    refused(path, "more than 50000 elements, with its includes")
    document("", name="part.mtlx")
    refused(document('<xi:include href="part.mtlx"/>' * 100), "includes more than 64 files")


def test_a_document_that_materialx_reads_need_not_be_xml(document):
    """Its parser accepts the characters < and & in attributes, and dashes in comments."""
    text = """<!-- it's <a> & "b -- c -->
        <open_pbr_surface name="s" type="surfaceshader" doc='a < "b" & c'>
        <input name="base_color" type="color3" value="1, 0, 0" doc="&lt;UDIM&gt; or <UDIM>"/>
        </open_pbr_surface>"""
    path = document(text)
    assert read_surface(path).values["base_color"] == (1, 0, 0)
    path.write_text("\n<!-- above -->" + path.read_text())
    assert read_surface(path).values["base_color"] == (1, 0, 0)


def test_paths_of_other_systems(tmp_path, document):
    """Backslashes part folders; a name that differs in case only is named."""
    (tmp_path / "maps").mkdir()
    write_image(tmp_path / "maps" / "a.exr", np.full((1, 1, 3), 0.5))
    refused(document(IMAGE.format("Maps\\A.exr") + COLOUR), "maps/a.exr' differs in case")
    path = document(IMAGE.format("maps\\a.exr") + COLOUR)
    assert read_surface(path).values["base_color"] == (0.5,) * 3
    write_image(tmp_path / "maps" / "a.exr", np.full((1, 1, 3), np.nan))
    refused(path, "image 'maps.a.exr' has pixels that are not finite")


def test_a_picture_is_measured_before_it_is_decoded(tmp_path, document, monkeypatch):
    """All images together; OpenImageIO itself refuses a size that its file cannot have."""
    path = document(IMAGE.format("a.exr") + COLOUR)
    write_image(tmp_path / "a.exr", np.zeros((6, 10, 3)))
    monkeypatch.setattr(images, "MAX_PIXELS", 59)
    monkeypatch.setattr(images, "_decoded", None)
    refused(path, "'a.exr' has 10 x 6 pixels; all images")
    header = struct.pack(">IIBBBBB", 100_000, 100_000, 8, 2, 0, 0, 0)
    content = b"".join(
        struct.pack(">I", len(x)) + name + x + struct.pack(">I", zlib.crc32(name + x))
        for name, x in ((b"IHDR", header), (b"IDAT", b""))
    )
    (tmp_path / "bomb.png").write_bytes(b"\x89PNG\r\n\x1a\n" + content)
    refused(document(IMAGE.format("bomb.png") + COLOUR), "cannot be read")


TWO_INPUTS = {"in1": ("color3", 'interfacename="in"'), "in2": ("color3", "@v")}
#: Documents of which mutants are read, line by line.
SEEDS = [
    element("open_pbr_surface", "surfaceshader", "s", base_color=(0.5, 0.2, 0.1), coat_weight=1.0)
    + MATERIAL.format("nodename", "s"),
    '<nodegraph name="g"><input name="a" type="float" value="3"/>'
    + element("texcoord", "vector2", "uv")
    + element("place2d", "vector2", "p", texcoord=("vector2", "@uv"))
    + element("image", "color3", "i", file=("filename", "a.exr"), texcoord=("vector2", "@p"))
    + element("fractal2d", "float", "f", amplitude=("float", 'interfacename="a"'))
    + element("mix", "color3", "x", fg=("color3", "@i"), mix="@f")
    + element("separate3", "multioutput", "c", in_=("color3", "@x"))
    + element("checkerboard", "color3", "k")
    + """<output name="o" type="color3" nodename="x"/>
    <output name="r" type="float" nodename="c" output="outr"/>
    <output name="b" type="color3" nodename="k"/></nodegraph>"""
    + element(
        *("open_pbr_surface", "surfaceshader", "s"),
        base_color=("color3", 'nodegraph="g" output="o"'),
        coat_color=("color3", 'nodegraph="g" output="b"'),
    ),
    """<nodedef name="D" node="d"><input name="in" type="color3"/>
    <output name="out" type="color3"/></nodedef><nodegraph name="N" nodedef="D">"""
    + element("worleynoise2d", "vector3", "w")
    + element("convert", "color3", "v", in_=("vector3", "@w"))
    + element("add", "color3", "z", **TWO_INPUTS)
    + '<output name="out" type="color3" nodename="z"/></nodegraph><d name="n" type="color3"/>'
    + element("standard_surface", "surfaceshader", "s", base_color=("color3", "@n"), coat=1.0),
]

#: Words that replace others.
WORDS = """0 -1 1e30 1e-320 nan 4294967296 true float color3 vector2 color4 integer string 1.36
    multioutput surfaceshader image switch extract combine4 s g i x out nodename nodegraph value
    output ../a normalmap noise2d acescg srgb_texture interfacename colorspace fileprefix inherit
    nodedef defaultgeomprop UV0"""


def test_mutants_are_refused_in_one_sentence(tmp_path):
    write_image(tmp_path / "a.exr", np.full((4, 4, 3), 0.5))
    library()  # not a part of any document's memory
    documents = [HEAD.format(space="acescg", body=x).replace("><", ">\n<") for x in SEEDS]
    seeds, words = [x.encode() for x in documents], [*WORDS.split(), "", "0, 0, 0", "1, 2"]

    def read(path):
        return read_surface(path, resolution=8)

    assert 3 < fuzz(read, tmp_path / "m.mtlx", seeds, 150, 512 << 20, words) < 150
