"""`urushi convert`: scenes of MaterialX documents, whose textures are those of `load_materialx`."""

import xml.etree.ElementTree as ElementTree

import mitsuba as mi
import numpy as np
import pytest

import urushi
from urushi.app.cli import main

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


def openpbr(**inputs: str | float) -> str:
    """A document of a material; texts are colours in ACEScg."""
    lines = (
        f'<input name="{name}" type="{"color3" if isinstance(value, str) else "float"}" '
        f'value="{value}"/>'
        for name, value in inputs.items()
    )
    return f"""<materialx version="1.39" colorspace="acescg"><open_pbr_surface name="Made"
        type="surfaceshader">{"".join(lines)}</open_pbr_surface></materialx>"""


@pytest.fixture
def convert(tmp_path, capsys):
    """From a document's text: the status of the command, its folder, and what it prints."""

    def run(text, *flags):
        if text is not None:
            (tmp_path / "document.mtlx").write_text(text)
        folder = tmp_path / "scene"
        status = main(["convert", str(tmp_path / "document.mtlx"), "-o", str(folder), *flags])
        return status, folder, capsys.readouterr()

    return run


def values(texture):
    si = mi.SurfaceInteraction3f()
    si.uv = mi.Point2f(np.random.default_rng(1).random((50, 2)).T * 3 - 1)
    return np.array(texture.eval(si))


def test_a_document_becomes_a_scene(convert, tmp_path, rgb):
    """Values in the XML are those in the document; its texture is looked up as the dictionary's."""
    pytest.importorskip("MaterialX")
    pixels = np.random.default_rng(0).integers(0, 256, (5, 8, 3)).astype(np.uint8)
    mi.Bitmap(pixels).write(str(tmp_path / "a.png"))
    status, folder, printed = convert(DOCUMENT)
    assert status == 0 and printed.out.strip() == str(folder / "scene.xml")
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
    described = mi.load_dict(urushi.load_materialx(tmp_path / "document.mtlx")["base_color"])
    assert np.allclose(values(written), values(described), atol=1e-3)  # files are of half precision


def test_light_and_medium_of_a_material(convert):
    """A warning is one sentence without a place in the code."""
    wine = dict(transmission_weight=1, transmission_color="0.4, 0, 0", transmission_depth=0.5)
    status, folder, printed = convert(openpbr(emission_luminance=20, coat_weight=0.5, **wine))
    assert status == 0
    assert printed.err.startswith("urushi: '") and printed.err.count("\n") == 1
    assert "'Made': transmission_color leaves [0, 1] in linear sRGB and is clipped" in printed.err
    mi.set_variant("llvm_ad_rgb")
    scene = mi.load_file(str(folder / "scene.xml"))
    assert sum("OpenPBREmission" in str(emitter) for emitter in scene.emitters()) == 1
    assert "Volumetric" in str(scene.integrator())
    assert sum(shape.interior_medium() is not None for shape in scene.shapes()) == 1


SKIN = """<standard_surface name="{}" type="surfaceshader">
    <input name="subsurface" type="float" value="1"/></standard_surface>"""
MIXTURE = f"""<materialx version="1.39">{SKIN.format("A")}{SKIN.format("B")}
    <mix name="Mix" type="surfaceshader"><input name="mix" type="float" value="0.5"/>
    <input name="bg" type="surfaceshader" nodename="A"/>
    <input name="fg" type="surfaceshader" nodename="B"/></mix></materialx>"""
GLASS = openpbr(transmission_weight=1, transmission_dispersion_scale=1)


@pytest.mark.parametrize(
    ("text", "flags", "sentence"),
    [
        (GLASS, [], "transmission_dispersion_scale needs dispersion"),
        (MIXTURE, ["--material", "Mix"], "subsurface_weight asks for the medium inside of a body"),
        (None, [], "there is no MaterialX file"),
    ],
)
def test_what_cannot_be_rendered_is_not_written(convert, text, flags, sentence):
    status, folder, printed = convert(text, *flags)
    assert status == 2 and sentence in printed.err
    assert not folder.exists()
