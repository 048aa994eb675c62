"""`urushi view` serves the page to this machine alone, and writes it for web servers."""

import gzip
import hashlib
import http.client
import json
import os
import re
import runpy
import signal
import subprocess
import sys
import threading
import zlib
from pathlib import Path

import numpy as np
import pytest
import safetensors.numpy

import urushi
from urushi.app import cli, page_files, view
from urushi.app.view import HOST, POLICY, PageServer
from urushi.core.table import SHAPE
from urushi.errors import FileError, ParameterError
from urushi.export.languages import LANGUAGES
from urushi.nets import weights

#: The page's sources, in a checkout.
VIEWER = Path(__file__).parents[2] / "viewer"


@pytest.fixture
def server():
    with PageServer({"index.html": b"<!doctype html>", "assets/page.js": b"0"}) as started:
        thread = threading.Thread(target=started.serve_forever)
        thread.start()
        yield started
        started.shutdown()
        thread.join()


def request(server, path, method="GET", **headers):
    connection = http.client.HTTPConnection(HOST, server.server_port, timeout=20)
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    connection.request(method, path, headers=named)
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer, body


def test_the_page_is_at_the_root(server):
    """Compressed for browsers that accept it."""
    answer, body = request(server, "/")
    assert (answer.status, body) == (200, b"<!doctype html>")
    assert answer.headers["Content-Type"] == "text/html; charset=utf-8"
    assert answer.headers["Content-Security-Policy"] == POLICY
    assert (answer.headers["Content-Encoding"], answer.headers["Vary"]) == (None, "Accept-Encoding")
    answer, body = request(server, "/", Accept_Encoding="gzip, br")
    assert answer.headers["Content-Encoding"] == "gzip"
    assert int(answer.headers["Content-Length"]) == len(body)
    assert gzip.decompress(body) == b"<!doctype html>"
    answer, body = request(server, "/", "HEAD")
    assert (answer.status, body, answer.headers["Content-Length"]) == (200, b"", "15")
    answer, body = request(server, "/assets/page.js?new")
    assert (answer.status, body) == (200, b"0")
    assert answer.headers["Content-Type"].startswith("text/javascript")


def test_nothing_else_is_answered(server):
    """No other path, nothing that is sent, and no other machine."""
    for path in ("/missing", "/assets", "/../pyproject.toml", "/%2e%2e/setup.py", "//etc/passwd"):
        assert request(server, path)[0].status == 404
    for method in ("POST", "PUT", "DELETE"):
        assert request(server, "/", method)[0].status == 501
    assert server.server_address[0] == "127.0.0.1"
    assert request(server, "/", Host="urushi.example")[0].status == 403
    assert request(server, "/", Host=f"localhost:{server.server_port}")[0].status == 200


def test_the_built_page_has_the_servers_policy_and_says_that_it_needs_a_server():
    """The page carries the policy for other hosts; frames can be forbidden by a server only.

    Browsers refuse scripts and styles of a folder; the style hides the sentence.
    """
    text = (page_files.BUILT / "index.html").read_text()
    (carried,) = re.findall(r'content="(default-src[^"]*)"', text)
    assert f"{carried}; frame-ancestors 'none'" == POLICY
    (sentence,) = re.findall(r'<p class="unserved">(.*?)</p>', text, re.DOTALL)
    assert "only from a web server" in sentence and "urushi view" in sentence
    style = (page_files.BUILT / "assets" / "index.css").read_text()
    assert re.search(r"\.unserved\s*{\s*display:\s*none", style)


@pytest.mark.skipif(not VIEWER.is_dir(), reason="the page's sources are not here")
def test_the_built_page_is_that_of_the_sources_and_its_formulas_are_those_of_python():
    """After a change in `viewer`, or of a formula, `make viewer` makes the page anew.

    See `viewer/sources.ts` and `viewer/formulas.py`.
    """
    paths = [path for name in ("src", "public") for path in (VIEWER / name).rglob("*")]
    paths += [VIEWER / name for name in ("index.html", "package-lock.json", "vite.config.ts")]
    files = {
        path.relative_to(VIEWER).as_posix(): path.read_bytes() for path in paths if path.is_file()
    }
    printed = runpy.run_path(str(VIEWER / "formulas.py"))["files"]()
    files |= {f"src/printed/{name}": text.encode() for name, text in printed.items()}
    digest = hashlib.sha256()
    for name in sorted(files):
        digest.update(name.encode() + b"\0" + files[name] + b"\0")
    built = (page_files.BUILT / "sources.txt").read_text().strip()
    assert built == digest.hexdigest()


def test_the_whole_page_is_small():
    """At most a megabyte, compressed, and 1.25 more for anisotropic materials when they are needed.

    These are the sizes of the shipped weights. A basis of two widths has 60 functions.
    """
    files = page_files.page_files(weights.default_model(), None)
    sizes = {name: len(zlib.compress(content)) for name, content in files.items()}
    later = sum(size for name, size in sizes.items() if "anisotropic" in name)
    assert sum(sizes.values()) - later < 1_000_000
    assert later < 1_250_000


def test_networks_are_those_of_the_model_in_half_precision(untrained):
    model = weights.default_model()
    content = page_files.packed_weights(model)
    arrays = safetensors.numpy.load(content)
    for name, array in model.params.items():
        if name not in ("basis.rows", "basis.measure", "basis.prior"):
            assert np.allclose(arrays[name], array, rtol=2**-11, atol=2**-24)
    assert model.fingerprint.encode() in content


def test_the_rows_of_a_basis_are_rounded_to_a_step():
    """`viewer/src/core/weights.ts` undoes it in the same way."""
    rng, shape = np.random.default_rng(1), (3, 4, 2)
    rows = rng.normal(size=(24, 5)) * [1, 0, 2, 0.1, 3] + [0, 1, 0, 0, 0]
    packed = page_files.packed_rows(rows, shape)
    low, high = packed["basis.bytes"].astype(np.int32)
    number = low + 256 * high
    steps = ((number >> 1) ^ -(number & 1)).reshape(4, *shape)
    for axis in (1, 2, 3):
        steps = steps.cumsum(axis=axis)
    (step,) = packed["basis.step"]
    found = step * steps.reshape(4, -1)
    assert (np.abs(found - np.delete(rows, 1, axis=1).T) < 0.51 * step).all()


@pytest.mark.parametrize(
    ("text", "bottom"),
    [
        ("conductor(0.3, r0=0.9)", {"kind": "conductor", "alpha": 0.3, "r0": 0.9}),
        (
            "conductor(0.3, eta=(0.2, 0.9, 1.1), k=3)",
            {"kind": "conductor", "alpha": 0.3, "eta": [0.2, 0.9, 1.1], "k": 3.0},
        ),
        ("dielectric(0.1, ior=1.5)", {"kind": "dielectric", "alpha": 0.1, "ior": 1.5}),
        ("diffuse((0.1, 0.2, 0.3))", {"kind": "diffuse", "reflectance": (0.1, 0.2, 0.3)}),
    ],
)
def test_a_description_becomes_cards(text, bottom):
    shown = {"name": "Material", "bottom": bottom, "coats": []}
    assert view.first_material(text, None).material == shown
    coated = f"coat(coat({text}, sigma_t=(1, 2, 3), g=0.5), 0.05, eta=1.4)"
    cards = view.first_material(coated, None).material
    assert cards["bottom"].pop("kind") == bottom["kind"]
    for name, value in cards["bottom"].items():
        assert value == pytest.approx(bottom[name])  # its indices are those in air
    top, lower = cards["coats"]
    assert (top["alpha"], top["ior"], top["sigmaT"]) == (0.05, pytest.approx(1.4 * 1.000277), 0.0)
    assert lower["ior"] == 1.5046
    assert (lower["sigmaT"], lower["g"]) == ((1.0, 2.0, 3.0), 0.5)


def test_two_widths_become_cards_and_codes(untrained, tmp_path):
    text = "coat(conductor(alpha_u=0.3, alpha_v=0.1, r0=0.9), alpha_u=0.2, alpha_v=0.4)"
    cards = view.first_material(text, None).material
    assert (cards["bottom"]["alpha"], cards["bottom"]["alphaV"]) == (0.3, 0.1)
    assert (cards["coats"][0]["alpha"], cards["coats"][0]["alphaV"]) == (0.2, 0.4)
    brushed = urushi.encode(urushi.conductor(alpha_u=0.3, alpha_v=0.1, r0=0.9)).rotated(300)
    brushed.save(tmp_path / "brushed.safetensors")
    shown = view.first_material(str(tmp_path / "brushed.safetensors"), None).material
    assert (shown["bottom"]["widths"], shown["rotation"]) == (2, -60)
    with pytest.raises(ParameterError, match="are for anisotropic materials; give --weights"):
        page_files.page_files(weights.anisotropic_model(), None)


def test_a_table_lies_beside_the_page(tmp_path):
    """A grey one has three equal channels."""
    model = weights.find(None)
    codes = np.zeros((1, model.arch.latent), np.float32)
    logs = np.random.default_rng(0).uniform(-3, 3, (*SHAPE, 1)).astype(np.float16)
    urushi.Material(codes, model, logs).save(tmp_path / "paint.safetensors")
    first = view.first_material(str(tmp_path / "paint.safetensors"), None)
    files = page_files.page_files(model, first)
    start = json.loads(files["start.json"])
    found = np.frombuffer(files[start["table"]], "<f2").reshape(*SHAPE, 3)
    assert (found == logs).all()
    bottom = start["materials"][0]["bottom"]
    assert bottom["table"] == f"{zlib.crc32(files[start['table']]):08x}"
    assert not bottom["besideLobe"]


SCENE = """<scene version="3.0.0">
    <shape type="sphere"><bsdf type="roughconductor" id="gold">
        <string name="distribution" value="ggx"/><float name="alpha" value="0.3"/>
    </bsdf></shape>
    <shape type="sphere"><bsdf type="neural_layered" id="lacquer">
        <float name="alpha" value="0.1"/><integer name="resolution" value="8"/>
        <bsdf type="diffuse" name="bottom">
            <texture type="checkerboard" name="reflectance"/>
        </bsdf>
    </bsdf></shape>
</scene>"""


def test_a_bsdf_of_a_scene_becomes_codes_or_a_texture(tmp_path, rgb):
    path = tmp_path / "scene.xml"
    path.write_text(SCENE)
    shown = view.first_material(f"{path}#gold", None).material
    assert (shown["name"], shown["bottom"]["kind"]) == ("gold", "codes")
    latents = np.reshape(shown["bottom"]["latents"], (3, -1))
    np.testing.assert_allclose(latents[:, 0], 0.3, rtol=1e-6)  # the lobe's width
    first = view.first_material(f"{path}#lacquer", None)
    name = f"{zlib.crc32(first.texture):08x}"
    assert first.material["bottom"] == {"kind": "texels", "texture": name}
    saved = tmp_path / "saved.safetensors"
    saved.write_bytes(first.texture)
    again = view.first_material(str(saved), None)
    assert (again.material["name"], again.texture) == ("saved", first.texture)
    files = page_files.page_files(weights.default_model(), again)
    assert files[json.loads(files["start.json"])["texture"]] == first.texture
    other = tmp_path / "other.safetensors"
    model = weights.default_model()
    weights.save(other, model.arch, {k: 0.5 * x for k, x in model.params.items()}, {})
    with pytest.raises(FileError, match="does not match the weights"):
        view.first_material(str(saved), str(other))


def test_what_the_page_cannot_show(untrained, monkeypatch, tmp_path):
    with pytest.raises(FileError, match="missing"):
        view.first_material(str(tmp_path / "missing.safetensors"), None)
    model = weights.default_model()
    large = {name: array * np.float32(1e6) for name, array in model.params.items()}
    with pytest.raises(ParameterError, match="too large for half precision"):
        page_files.packed_weights(weights.Model.of(model.arch, large, {}))
    monkeypatch.setattr(page_files, "BUILT", tmp_path)
    with pytest.raises(FileError, match="make viewer"):
        page_files.page_files(model, None)


def test_the_page_is_written_into_a_folder(untrained, tmp_path, capsys):
    """Any server can serve it: an address in it is a file and, as a query, its content's hash."""
    folder = tmp_path / "site"
    assert cli.main(["view", "diffuse(0.5)", "-o", str(folder)]) == 0
    assert capsys.readouterr().out == f"{folder}\n"
    start = json.loads((folder / "start.json").read_text())
    assert start["materials"][0]["bottom"] == {"kind": "diffuse", "reflectance": 0.5}
    assert (folder / "index.html").is_file()
    assert (folder / "weights.safetensors").stat().st_size > 10_000
    document = (folder / "index.html").read_text()
    links = re.findall(r'(?:href|src)="\./([^"?]*)\?([^"]*)"', document)
    assert len(links) == len(re.findall(r'(?:href|src)="', document)) == 5
    listed = json.loads(re.search(r'id="versions">(.*?)</script>', document)[1])
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert listed.keys() == files - {"index.html"}
    assert {f"shaders/{language}.txt" for language in LANGUAGES} < files
    for path, version in (*links, *listed.items()):
        assert version == hashlib.sha256((folder / path).read_bytes()).hexdigest()[:16]
    assert re.search(r'rel="preload" as="fetch" crossorigin href="./weights', document)


def test_a_taken_port_is_one_sentence(untrained, server, capsys):
    assert cli.main(["view", "--port", str(server.server_port), "--no-browser"]) == 2
    assert capsys.readouterr().err.startswith("urushi: cannot serve the page on port")


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="the signal of Ctrl-C is sent otherwise")
def test_it_ends_by_ctrl_c():
    command = [sys.executable, "-m", "urushi.app.cli", "view", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        address = process.stdout.readline()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/ \(end with Ctrl-C\)\n", address)
        process.send_signal(signal.SIGINT)
        assert process.wait(timeout=60) == 0
