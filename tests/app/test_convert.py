"""`urushi convert`: scenes of MaterialX documents, whose textures are those of `load_materialx`."""

import xml.etree.ElementTree as ElementTree

import mitsuba as mi
import numpy as np
import pytest
from tests.openpbr_surface.materialx.conftest import HEAD, element

import urushi
from urushi.app.cli import main


def document(*nodes: str, space: str = "lin_rec709") -> str:
    return HEAD.format(space=space, body="".join(nodes))


def openpbr(**inputs) -> str:
    """A document of a material, whose colours are in ACEScg."""
    return document(element("open_pbr_surface", "surfaceshader", "Made", **inputs), space="acescg")


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


PLACE = dict(texcoord=("vector2", "@uv"), scale=("vector2", "0.5, 0.3"), rotate=30.0)
PLACE |= dict(offset=("vector2", "0.1, 0.2"))
PAINT = dict(base_color=("color3", "@i"), coat_color=(0.25, 0.5, 1), coat_weight=0.5)
DOCUMENT = document(
    element("texcoord", "vector2", "uv"),
    element("place2d", "vector2", "p", **PLACE),
    element("image", "color3", "i", file=("filename", "a.png"), texcoord=("vector2", "@p")),
    element("open_pbr_surface", "surfaceshader", "Paint", **PAINT),
)


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
    wine = dict(transmission_weight=1.0, transmission_color=(0.4, 0, 0), transmission_depth=0.5)
    status, folder, printed = convert(openpbr(emission_luminance=20.0, coat_weight=0.5, **wine))
    assert status == 0
    assert printed.err.startswith("urushi: '") and printed.err.count("\n") == 1
    assert "'Made': transmission_color leaves [0, 1] in linear sRGB and is clipped" in printed.err
    mi.set_variant("llvm_ad_rgb")
    scene = mi.load_file(str(folder / "scene.xml"))
    assert sum("OpenPBREmission" in str(emitter) for emitter in scene.emitters()) == 1
    assert "Volumetric" in str(scene.integrator())
    assert sum(shape.interior_medium() is not None for shape in scene.shapes()) == 1


@pytest.mark.parametrize("name", ["sky", "object", "type"])
def test_a_material_may_have_the_name_of_a_part_of_the_scene(convert, name):
    status, folder, _ = convert(document(element("open_pbr_surface", "surfaceshader", name)))
    assert status == 0
    mi.set_variant("llvm_ad_rgb")
    scene = mi.load_file(str(folder / "scene.xml"))
    assert len(scene.shapes()) == 2 and len(scene.emitters()) == 2


SKINS = dict(bg=("surfaceshader", "@A"), fg=("surfaceshader", "@B"), mix=0.5)
MIXTURE = document(
    *(element("standard_surface", "surfaceshader", x, subsurface=1.0) for x in "AB"),
    element("mix", "surfaceshader", "Mix", **SKINS),
)
GLASS = openpbr(transmission_weight=1.0, transmission_dispersion_scale=1.0)


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
