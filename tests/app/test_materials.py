"""`urushi encode` and `urushi layer` make the files that `urushi.load` reads."""

import re

import numpy as np
import pytest
from tests.measured import writers
from tests.untrained import untrained

import urushi
from urushi.app import cli
from urushi.checks import DEFAULT_COAT
from urushi.nets import weights

pytestmark = pytest.mark.usefixtures("untrained")

GOLD, OUTPUT = "conductor(alpha=0.2, r0=(0.98, 0.77, 0.34))", ["-o", "material.safetensors"]


def green(folder):
    """A MERL file of a Lambertian surface."""
    return writers.write_merl(folder / "green.binary", np.full((90 * 90 * 180, 3), 0.5))


SCENE = """<scene version="3.0.0">
    <shape type="sphere"><bsdf type="diffuse" id="{0}"><rgb name="reflectance" value="{1}"/></bsdf>
    </shape>
    <shape type="cube"><bsdf type="diffuse" id="floor"/></shape>
</scene>"""


ERRORS = {
    "encode": [
        (["scene.xml"], "has 2 BSDFs; select one by 'scene.xml#ID' with an ID from: floor, wall"),
        (["scene.xml#roof"], "has no BSDF 'roof' on a shape; it has: floor, wall"),
        (["empty.xml"], "'empty.xml' has no BSDF on a shape; give a scene with one"),
        (["none.xml"], "has 2 BSDFs; select one by 'none.xml#ID' with an ID from: none; give the"),
        (["scene.xml#wall", "-m", "llvm_rgb"], "Mitsuba has no variant 'llvm_rgb'"),
        (["absent.xml"], "'absent.xml' is neither a file nor a description"),
        (["lacquer(1)"], "'lacquer' is not one of coat, slab"),
        (["diffuse(2)"], "reflectance is 2"),
        ([], "there is nothing to encode"),
        ([GOLD, GOLD], "is one file, but there are 2 sources; give a folder"),
        (["a/gold.binary", "b/gold.bsdf", "-o", "new"], "two of the sources are called 'gold'"),
        (["a.xml#wall", "b.xml#wall", "-o", "new"], "two of the sources are called 'wall'"),
        ([GOLD, "missing.binary", "-o", "new"], "'missing.binary' is neither a file nor a descr"),
        ([GOLD, "-o", "scene.xml/gold.safetensors"], "cannot write 'scene.xml/gold.safetensors'"),
        ([GOLD, "-o", "new/a.txt"], "--output is 'new/a.txt', which ends neither in .safetensors"),
        (["gold"], "'gold' is a material file of Urushi, not a measured BRDF; urushi layer coats"),
        ([GOLD, "--table", "--no-table"], "--table and --no-table are both given; give one"),
    ],
    "layer": [
        (["missing.safetensors"], "missing.safetensors"),
        (["missing"], "'missing' is neither a file nor a description"),
        (["scene.xml#roof"], "has no BSDF 'roof' on a shape; it has: floor, wall"),
        ([GOLD, "--alpha-u", "0.1"], "alpha_v"),
        ([GOLD, "--alpha", "0.1", "--alpha-u", "0.1", "--alpha-v", "0.2"], "alpha"),
        ([GOLD, "--albedo", "0.5", "1.5", "0.5"], "albedo is 1.5"),
        ([GOLD, "--g", "nan"], "g is nan"),
        ([GOLD, "--g", "0.1", "0.2"], "has shape (2,)"),
    ],
}


@pytest.mark.parametrize(
    ("command", "arguments", "sentence"),
    [(command, *error) for command, errors in ERRORS.items() for error in errors],
)
def test_errors(command, arguments, sentence, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.xml").write_text(SCENE.format("wall", "0.5"))
    (tmp_path / "none.xml").write_text(re.sub(r' id="\w+"', "", SCENE.format("wall", "0.5")))
    (tmp_path / "empty.xml").write_text('<scene version="3.0.0"/>')
    urushi.encode(urushi.diffuse(0.5)).save(tmp_path / "gold")
    assert cli.main([command, *arguments, *([] if "-o" in arguments else OUTPUT)]) == 2
    message = capsys.readouterr().err
    several = "missing.binary" in arguments  # and how many could not be encoded
    assert sentence in message and message.count("\n") == 1 + several
    assert not (tmp_path / OUTPUT[1]).exists()


def test_encode_several_sources_into_a_folder(tmp_path, capsys):
    """A measured file, a description, and two BSDFs of a scene."""
    table, scene, folder = green(tmp_path), tmp_path / "scene.xml", tmp_path / "materials"
    scene.write_text(SCENE.format("wall", "0.1, 0.5, 0.8"))
    sources = {
        str(table): urushi.load_measured(table),
        GOLD: urushi.conductor(alpha=0.2, r0=(0.98, 0.77, 0.34)),
        f"{scene}#wall": urushi.diffuse((0.1, 0.5, 0.8)),
        f"{scene}#floor": urushi.diffuse(0.5),
    }
    assert cli.main(["encode", *sources, "-o", str(folder)]) == 0
    names = ("green", "conductor-2", "wall", "floor")
    files = [folder / f"{name}.safetensors" for name in names]
    assert sorted(capsys.readouterr().out.split()) == sorted(map(str, files))
    assert sorted(folder.iterdir()) == sorted(files)
    for file, source in zip(files, sources.values(), strict=True):
        # Mitsuba and the reference evaluate 1 / pi in float32, each in its own way
        expected, tolerance = urushi.encode(source), 1e-4 * (file.stem in ("wall", "floor"))
        np.testing.assert_allclose(
            urushi.load(file).latents, expected.latents, rtol=10 * tolerance, atol=tolerance
        )


def test_a_bad_source_stops_none_of_the_others(tmp_path, capsys):
    broken = tmp_path / "broken.binary"
    broken.write_bytes(green(tmp_path).read_bytes()[:1000])
    (tmp_path / "page.binary").write_text("<html>")
    files = [str(tmp_path / f"{name}.binary") for name in ("absent", "green", "broken", "page")]
    assert cli.main(["encode", *files, "-o", str(tmp_path / "materials")]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 4  # a sentence for each, and their number
    assert "absent.binary' is neither a file nor a description" in lines[0]
    assert any("broken.binary' is truncated" in line for line in lines)
    assert any("page.binary' is a web page" in line for line in lines)
    assert lines[-1] == "urushi: 3 of 4 sources could not be encoded"
    assert [file.name for file in (tmp_path / "materials").iterdir()] == ["green.safetensors"]


def test_averaging_is_reported(tmp_path, capsys):
    scene = tmp_path / "scene.xml"
    brushed = '<float name="alpha_u" value="0.05"/><float name="alpha_v" value="0.5"/>'
    scene.write_text(
        '<scene version="3.0.0"><shape type="sphere"><bsdf type="roughconductor" id="pan">'
        f"{brushed}</bsdf></shape></scene>"
    )
    file = str(tmp_path / "pan.safetensors")
    assert cli.main(["encode", str(scene), "-o", file, "--weights", "default"]) == 0
    assert f"urushi: {scene}: the BRDF is anisotropic" in capsys.readouterr().err


def test_a_material_file_needs_no_suffix(tmp_path, capsys):
    bare, coated = tmp_path / "gold", tmp_path / "coated"
    urushi.encode(urushi.conductor(alpha=0.2, r0=0.9)).save(bare)
    assert cli.main(["layer", str(bare), "-o", str(coated)]) == 0
    assert urushi.load(coated).coating.bottom == urushi.load(bare)


@pytest.mark.parametrize(
    ("flags", "top", "medium"),
    [
        (
            "--alpha 0.05 --eta 1.4 --albedo 0.8 --sigma-t 0.2 1 3 --g -0.2",
            {"alpha": 0.05, "eta": 1.4},
            {"albedo": 0.8, "sigma_t": (0.2, 1, 3), "g": -0.2},
        ),
        ("--alpha-u 0.05 --alpha-v 0.3 0.2 0.1", {"alpha_u": 0.05, "alpha_v": (0.3, 0.2, 0.1)}, {}),
        ("", {"alpha": DEFAULT_COAT.alpha, "eta": DEFAULT_COAT.eta}, {}),
    ],
    ids=["one width", "two widths", "defaults"],
)
def test_layer_is_that_of_python(flags, top, medium, tmp_path, capsys):
    """Of a description, and of its file."""
    gold, coated = tmp_path / "gold.safetensors", tmp_path / "coated.safetensors"
    urushi.encode(urushi.conductor(alpha=0.2, r0=(0.98, 0.77, 0.34))).save(gold)
    expected = urushi.layer(urushi.dielectric(**top), urushi.load(gold), **medium)
    for source in (GOLD, str(gold)):
        assert cli.main(["layer", source, *flags.split(), "-o", str(coated)]) == 0
        assert capsys.readouterr().out == f"{coated}\n"
        assert urushi.load(coated) == expected


def test_a_bsdf_of_a_scene_is_coated_as_its_file(tmp_path):
    wall, file = tmp_path / "scene.xml", tmp_path / "wall.safetensors"
    wall.write_text(SCENE.format("wall", "0.1, 0.5, 0.8"))
    assert cli.main(["encode", f"{wall}#wall", "-o", str(file)]) == 0
    coated = [tmp_path / "a", tmp_path / "b"]
    for source, target in zip((f"{wall}#wall", file), coated, strict=True):
        assert cli.main(["layer", str(source), "-o", str(target)]) == 0
    assert urushi.load(coated[0]) == urushi.load(coated[1])


def test_weights_are_those_of_the_option(tmp_path):
    file, other = str(tmp_path / "gold.safetensors"), str(tmp_path / "other.safetensors")
    own = untrained(1)
    weights.save(other, own.arch, own.params, {})
    for command in ("encode", "layer"):
        assert cli.main([command, GOLD, "--weights", other, "-o", file]) == 0
        assert urushi.load(file, other).model.fingerprint == own.fingerprint
