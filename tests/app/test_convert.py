"""`urushi convert`: the written textures are those that `load_materialx` gives."""

import xml.etree.ElementTree as ElementTree
from importlib.util import find_spec

import numpy as np
import pytest

import urushi
from urushi.app.cli import main

mi = pytest.importorskip("mitsuba")

DOCUMENT = """<materialx version="1.39" colorspace="lin_rec709">
<texcoord name="uv" type="vector2"/>
<place2d name="p" type="vector2"><input name="texcoord" type="vector2" nodename="uv"/>
<input name="rotate" type="float" value="30"/><input name="scale" type="vector2" value="0.5, 0.3"/>
<input name="offset" type="vector2" value="0.1, 0.2"/></place2d>
<image name="i" type="color3"><input name="file" type="filename" value="a.png"/>
<input name="texcoord" type="vector2" nodename="p"/></image>
<open_pbr_surface name="Paint" type="surfaceshader">
<input name="base_color" type="color3" nodename="i"/>
<input name="coat_color" type="color3" value="0.25, 0.5, 1"/>
<input name="coat_weight" type="float" value="0.5"/></open_pbr_surface></materialx>"""


@pytest.fixture
def document(tmp_path):
    path = tmp_path / "paint.mtlx"
    path.write_text(DOCUMENT)
    pixels = np.random.default_rng(0).integers(0, 256, (5, 8, 3)).astype(np.uint8)
    mi.Bitmap(pixels).write(str(tmp_path / "a.png"))
    return path


@pytest.fixture(autouse=True)
def variant():
    before = mi.variant()
    yield
    if before is not None:
        mi.set_variant(before)


def values(texture):
    si = mi.SurfaceInteraction3f()
    si.uv = mi.Point2f(np.random.default_rng(1).random((50, 2)).T * 3 - 1)
    return np.array(texture.eval(si))


def test_a_document_becomes_a_scene(document, tmp_path, capsys):
    """Values in the XML are those in the document; its texture is looked up as the dictionary's."""
    if find_spec("MaterialX") is None:
        pytest.skip("the package materialx is not installed")
    folder = tmp_path / "scene"
    assert main(["convert", str(document), "-o", str(folder)]) == 0
    assert capsys.readouterr().out.strip() == str(folder / "scene.xml")
    bsdf = ElementTree.parse(folder / "scene.xml").getroot().find("bsdf")
    assert bsdf.get("type") == "openpbr" and bsdf.get("id") == "Paint"
    assert bsdf.find("rgb[@name='coat_color']").get("value").split() == ["0.25", "0.5", "1"]
    assert bsdf.find("float[@name='coat_weight']").get("value") == "0.5"

    mi.set_variant("llvm_ad_rgb")
    element = bsdf.find("texture[@name='base_color']")
    file = element.find("string[@name='filename']")
    file.set("value", str(folder / file.get("value")))
    element.attrib.pop("name")
    element.set("version", "3.0.0")
    written = mi.load_string(ElementTree.tostring(element, encoding="unicode"))
    described = mi.load_dict(urushi.load_materialx(document)["base_color"])
    assert np.allclose(values(written), values(described), atol=1e-3)  # files are of half precision


@pytest.mark.slow
def test_an_emitting_material_gets_an_emitter(tmp_path):
    document = tmp_path / "lamp.mtlx"
    document.write_text("""<materialx version="1.39" colorspace="lin_rec709">
        <open_pbr_surface name="Lamp" type="surfaceshader">
        <input name="emission_luminance" type="float" value="20"/>
        <input name="coat_weight" type="float" value="0.5"/></open_pbr_surface></materialx>""")
    assert main(["convert", str(document), "-o", str(tmp_path / "scene")]) == 0
    mi.set_variant("llvm_ad_rgb")
    scene = mi.load_file(str(tmp_path / "scene" / "scene.xml"))
    assert sum("OpenPBREmission" in str(emitter) for emitter in scene.emitters()) == 1


GLASS = """<materialx version="1.39"><open_pbr_surface name="Glass">
    <input name="transmission_weight" type="float" value="1"/>
    <input name="transmission_dispersion_scale" type="float" value="1"/></open_pbr_surface>
    </materialx>"""

SKIN = """<standard_surface name="{}" type="surfaceshader">
    <input name="subsurface" type="float" value="1"/></standard_surface>"""
MIXTURE = f"""<materialx version="1.39">{SKIN.format("A")}{SKIN.format("B")}
    <mix name="Mix" type="surfaceshader"><input name="mix" type="float" value="0.5"/>
    <input name="bg" type="surfaceshader" nodename="A"/>
    <input name="fg" type="surfaceshader" nodename="B"/></mix></materialx>"""


@pytest.mark.parametrize(
    ("text", "flags", "sentence"),
    [
        (GLASS, [], "transmission_dispersion_scale needs dispersion"),
        (MIXTURE, ["--material", "Mix"], "subsurface_weight asks for the medium inside of a body"),
        (None, [], "there is no MaterialX file"),
    ],
)
def test_what_cannot_be_rendered_is_not_written(text, flags, sentence, tmp_path, capsys):
    document = tmp_path / "document.mtlx"
    if text is not None:
        document.write_text(text)
    assert main(["convert", str(document), "-o", str(tmp_path / "out"), *flags]) == 2
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_body_has_its_medium(tmp_path):
    document = tmp_path / "wine.mtlx"
    document.write_text("""<materialx version="1.39" colorspace="lin_rec709">
        <open_pbr_surface name="Wine" type="surfaceshader">
        <input name="transmission_weight" type="float" value="1"/>
        <input name="transmission_color" type="color3" value="0.4, 0.02, 0.05"/>
        <input name="transmission_depth" type="float" value="0.5"/></open_pbr_surface>
        </materialx>""")
    assert main(["convert", str(document), "-o", str(tmp_path / "scene")]) == 0
    mi.set_variant("llvm_ad_rgb")
    scene = mi.load_file(str(tmp_path / "scene" / "scene.xml"))
    assert "Volumetric" in str(scene.integrator())
    assert sum(shape.interior_medium() is not None for shape in scene.shapes()) == 1
