"""What notebooks show: the page as one document, and pictures of materials."""

import base64
import gzip
import hashlib
import html
import io
import json
import re

import numpy as np
import pytest

import urushi
from urushi.app import cli, notebook, page_files
from urushi.app.page_files import page_document
from urushi.errors import FileError, ParameterError
from urushi.material import Material
from urushi.nets import weights


@pytest.fixture(autouse=True)
def short_shaders(monkeypatch):
    """Shader code is tested elsewhere, and printing it takes seconds."""
    monkeypatch.setattr(page_files, "shader_files", lambda model: {"shaders/glsl.txt": b"// f"})


def packed(document):
    """The files in a document by their paths."""
    found = re.search(r'<script type="application/json" id="files">(.*?)</script>', document)
    return {
        path: gzip.decompress(base64.b64decode(text)) for path, text in json.loads(found[1]).items()
    }


def start(document):
    return json.loads(packed(document)["start.json"])["materials"][0]


def test_a_document_holds_the_files_and_asks_for_none(untrained):
    """Its policy allows its own script and style."""
    files = page_files.page_files(weights.default_model(), None)
    document = page_document(files)
    assert not re.search(r"<(script|link|img)[^>]*\s(src|href)=", document)
    for path, content in packed(document).items():
        assert content == files[path]
    assert {"weights.safetensors", "assets/worker.js", "shaders/glsl.txt"} <= set(packed(document))
    policy = re.search(r'content="(default-src[^"]*)"', document)[1]
    for kind, pattern in (
        ("script", r'<script type="module">(.*)</script>'),
        ("style", r"<style>(.*?)</style>"),
    ):
        text = re.search(pattern, document, re.DOTALL)[1]
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"{kind}-src 'sha256-{digest}';" in policy
    assert policy.startswith("default-src 'none';") and "connect-src" not in policy
    for name, content in ("index.html", b"<!doctype html>"), ("assets/index.js", b"'</script>'"):
        with pytest.raises(FileError, match="make viewer"):
            page_document(files | {name: content})


@pytest.mark.parametrize("name", ["clay.html", "CLAY.HTML"])
def test_the_command_writes_a_document_and_a_notebook_shows_it(untrained, tmp_path, capsys, name):
    """In a frame."""
    path = tmp_path / name
    assert cli.main(["view", "diffuse(0.5)", "-o", str(path)]) == 0
    assert capsys.readouterr().out == f"{path}\n"
    document = path.read_bytes().decode()
    assert document.startswith("<!doctype html>")
    assert start(document)["bottom"] == {"kind": "diffuse", "reflectance": 0.5}
    page = urushi.show(urushi.diffuse(0.5), height=500)
    frame = re.fullmatch(r'<iframe ([^>]*)srcdoc="([^"]*)"></iframe>', page._repr_html_())
    assert html.unescape(frame[2]) == page.document == document
    assert 'height="500"' in frame[1]


def test_a_material_is_shown_by_its_codes(untrained, tmp_path):
    material = urushi.encode(urushi.conductor(0.2, r0=(0.9, 0.7, 0.3)))
    shown = start(urushi.show(material).document)
    assert np.array_equal(shown["bottom"]["latents"], material.latents.ravel())
    material.save(tmp_path / "gold.safetensors")
    read = start(urushi.show(str(tmp_path / "gold.safetensors")).document)
    assert read == shown | {"name": "gold"}


def test_what_a_notebook_cannot_show_and_what_the_page_has_no_cards_for(untrained):
    """Two channels; more coats than cards, which become codes."""
    codes = np.tile(urushi.encode(urushi.diffuse(0.5)).latents[:1], (2, 1))
    with pytest.raises(ParameterError, match="has 2 channels"):
        urushi.show(Material(codes, weights.default_model()))
    many = urushi.diffuse(0.5)
    for _ in range(page_files.MOST_COATS + 1):
        many = urushi.coat(many)
    assert start(urushi.show(many).document)["bottom"]["kind"] == "codes"


@pytest.fixture
def pixels(rgb, monkeypatch):
    """A function: the picture (24, 24, 4) of a material, from 0 to 255."""
    image = pytest.importorskip("PIL.Image")
    monkeypatch.setattr(notebook, "SIZE", 24)
    notebook.png.cache_clear()
    yield lambda x: np.asarray(image.open(io.BytesIO(x._repr_png_()), formats=["PNG"])).astype(int)
    notebook.png.cache_clear()


def test_colours_are_those_of_the_surface(pixels):
    red = (0.8, 0.05, 0.05)
    dark, bright, red = (pixels(urushi.encode(urushi.diffuse(r))) for r in (0.1, 0.8, red))
    assert dark.shape == bright.shape == (24, 24, 4)
    inside = dark[..., 3] == 255
    assert inside[12, 12] and not inside[0, 0]
    assert (bright[inside][:, :3] > dark[inside][:, :3]).all()
    assert red[12, 12, 0] > 2 * red[12, 12, 1]


def test_anisotropy_shows(pixels):
    """Tangents are horizontal, so that exchanged widths are another picture."""
    one, other = (
        pixels(urushi.encode(urushi.conductor(alpha_u=u, alpha_v=v, r0=0.9)))
        for u, v in ((0.05, 0.5), (0.5, 0.05))
    )
    assert np.abs(one - other).max() > 50


def test_materials_of_other_numbers_of_channels_have_no_picture(pixels):
    grey = urushi.encode(urushi.diffuse(0.5))
    assert Material(grey.latents[:2], grey.model)._repr_png_() is None
    assert pixels(Material(grey.latents[:1], grey.model)).shape == (24, 24, 4)
