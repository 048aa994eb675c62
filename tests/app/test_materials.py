"""`urushi encode` and `urushi layer` make the files that `urushi.load` reads."""

import numpy as np
import pytest
from tests.untrained import untrained

import urushi
from urushi.app import cli
from urushi.checks import DEFAULT_COAT
from urushi.nets import weights

pytestmark = pytest.mark.usefixtures("untrained")

GOLD, OUTPUT = "conductor(alpha=0.2, r0=(0.98, 0.77, 0.34))", ["-o", "material.safetensors"]


def test_encode_a_description(tmp_path, capsys):
    file = tmp_path / "gold.safetensors"
    assert cli.main(["encode", GOLD, "-o", str(file)]) == 0
    assert capsys.readouterr().out.strip() == str(file)
    expected = urushi.encode(urushi.conductor(alpha=0.2, r0=(0.98, 0.77, 0.34)))
    np.testing.assert_array_equal(urushi.load(file).latents, expected.latents)


@pytest.fixture
def merl(tmp_path):
    """Writes tables of MERL's format, all of one value [1/sr], by name."""

    def write(name, value):
        # The format's values are doubles over scales of 1/1500, 1.15/1500 and 1.66/1500.
        scales = np.array([1.0, 1.15, 1.66]) / 1500
        planes = [np.full(90 * 90 * 180, value / scale) for scale in scales]
        file = tmp_path / f"{name}.binary"
        file.write_bytes(np.array([90, 90, 180], "<i4").tobytes() + np.stack(planes).tobytes())
        return file

    return write


SCENE = """<scene version="3.0.0">
    <shape type="sphere"><bsdf type="diffuse" id="{0}"><rgb name="reflectance" value="{1}"/></bsdf>
    </shape>
    <shape type="cube"><bsdf type="diffuse" id="floor"/></shape>
</scene>"""


def test_encode_a_bsdf_of_a_scene(tmp_path):
    scene, file = tmp_path / "scene.xml", tmp_path / "wall.safetensors"
    scene.write_text(SCENE.format("wall", "0.1, 0.5, 0.8"))
    assert cli.main(["encode", f"{scene}#wall", "-o", str(file)]) == 0
    expected = urushi.encode(urushi.diffuse((0.1, 0.5, 0.8)))
    # Mitsuba and the reference evaluate 1 / pi in float32, each in its own way
    np.testing.assert_allclose(urushi.load(file).latents, expected.latents, rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["scene.xml"], "has 2 BSDFs; select one by 'scene.xml#ID' with an ID from: floor, wall"),
        (["scene.xml#roof"], "has no BSDF 'roof' on a shape; it has: floor, wall"),
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
    ],
)
def test_errors_of_encode(arguments, sentence, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.xml").write_text(SCENE.format("wall", "0.5"))
    assert cli.main(["encode", *arguments, *([] if "-o" in arguments else OUTPUT)]) == 2
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / OUTPUT[1]).exists()


def test_encode_several_sources_into_a_folder(merl, tmp_path, capsys):
    table, other = merl("green", 0.5), merl("grey", 0.2)
    folder = tmp_path / "materials"
    assert cli.main(["encode", str(table), GOLD, str(other), "-o", str(folder)]) == 0
    names = [folder / f"{name}.safetensors" for name in ("green", "conductor-2", "grey")]
    assert sorted(capsys.readouterr().out.split()) == sorted(map(str, names))
    sources = (urushi.load_measured(table), urushi.conductor(alpha=0.2, r0=(0.98, 0.77, 0.34)))
    for file, source in zip(names, sources, strict=False):
        expected = urushi.encode(source)
        np.testing.assert_array_equal(urushi.load(file).latents, expected.latents)


def test_a_bad_source_stops_none_of_the_others(merl, tmp_path, capsys):
    broken = tmp_path / "broken.binary"
    broken.write_bytes(merl("green", 0.5).read_bytes()[:1000])
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


def test_encoding_again_encodes_again(tmp_path):
    folder = tmp_path / "materials"
    for description, name in (("diffuse(0.2)", "diffuse-1"), ("diffuse(0.7)", "diffuse-1")):
        assert cli.main(["encode", description, "-o", str(folder)]) == 0
        last = urushi.load(folder / f"{name}.safetensors")
    assert last == urushi.encode(urushi.diffuse(0.7))


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


def test_several_bsdfs_of_a_scene(tmp_path):
    scene, folder = tmp_path / "scene.xml", tmp_path / "folder"
    scene.write_text(SCENE.format("wall", "0.5"))
    assert cli.main(["encode", f"{scene}#wall", GOLD, f"{scene}#floor", "-o", str(folder)]) == 0
    names = ["conductor-2.safetensors", "floor.safetensors", "wall.safetensors"]
    assert sorted(file.name for file in folder.iterdir()) == names


def test_layer_a_file_and_a_description_alike(tmp_path):
    gold, coated, other = (tmp_path / f"{name}.safetensors" for name in ("gold", "coated", "other"))
    flags = ["--alpha", "0.05", "--eta", "1.4", "--albedo", "0.8", "--sigma-t", "0.2", "1", "3"]
    assert cli.main(["encode", GOLD, "-o", str(gold)]) == 0
    assert cli.main(["layer", str(gold), *flags, "--g", "-0.2", "-o", str(coated)]) == 0
    assert cli.main(["layer", GOLD, *flags, "--g", "-0.2", "-o", str(other)]) == 0
    expected = urushi.layer(
        urushi.dielectric(0.05, 1.4),
        urushi.load(gold),
        albedo=0.8,
        sigma_t=(0.2, 1, 3),
        g=-0.2,
    )
    np.testing.assert_array_equal(urushi.load(coated).latents, expected.latents)
    np.testing.assert_array_equal(urushi.load(other).latents, expected.latents)


@pytest.mark.slow
def test_layer_takes_two_widths(tmp_path):
    file = tmp_path / "brushed.safetensors"
    flags = ["--alpha-u", "0.05", "--alpha-v", "0.3", "0.2", "0.1"]
    assert cli.main(["layer", GOLD, *flags, "-o", str(file)]) == 0
    top = urushi.dielectric(alpha_u=0.05, alpha_v=(0.3, 0.2, 0.1))
    assert urushi.load(file) == urushi.layer(
        top, urushi.encode(urushi.conductor(alpha=0.2, r0=(0.98, 0.77, 0.34)))
    )


def test_layer_has_the_coat_of_python_by_default(tmp_path):
    """The defaults are those of `urushi.coat`; the networks are those of --weights."""
    file, other = tmp_path / "coated.safetensors", tmp_path / "other.safetensors"
    own = untrained(1)
    weights.save(other, own.arch, own.params, {})
    assert cli.main(["layer", GOLD, "--weights", str(other), "-o", str(file)]) == 0
    gold = urushi.encode(urushi.conductor(alpha=0.2, r0=(0.98, 0.77, 0.34)), other)
    top = urushi.dielectric(DEFAULT_COAT.alpha, DEFAULT_COAT.eta)
    assert urushi.load(file, other) == urushi.layer(top, gold)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["missing.safetensors"], "missing.safetensors"),
        ([GOLD, "--alpha-u", "0.1"], "alpha_v"),
        ([GOLD, "--alpha", "0.1", "--alpha-u", "0.1", "--alpha-v", "0.2"], "alpha"),
        ([GOLD, "--albedo", "0.5", "1.5", "0.5"], "albedo is 1.5"),
        ([GOLD, "--g", "nan"], "g is nan"),
        ([GOLD, "--g", "0.1", "0.2"], "has shape (2,)"),
    ],
)
def test_errors_of_layer(arguments, sentence, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["layer", *arguments, *OUTPUT]) == 2
    message = capsys.readouterr().err
    assert sentence in message and message.count("\n") == 1
    assert not list(tmp_path.glob("*.safetensors"))
