"""`urushi render` works like Mitsuba's executable, and errors are one sentence."""

import io
import re
import sys
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from gallery import export
from gallery.globe import globe
from gallery.options import Options
from tests.untrained import untrained

from urushi.app import cli
from urushi.app.render import DEMO_SCENE, Render, load_scene
from urushi.nets import weights

SENSOR = """<sensor type="orthographic">
        <film type="hdrfilm">
            <integer name="width" value="{}"/><integer name="height" value="{}"/>
        </film>
        <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
        <transform name="to_world"><lookat origin="0,0,-1" target="0,0,0" up="0,1,0"/></transform>
    </sensor>"""
SCENE = f"""<scene version="3.0.0">
    <default name="grey" value="0.5"/><default name="spp" value="4"/>
    <integrator type="direct"/>
    {SENSOR.format(6, 4)}
    {SENSOR.format(2, 2)}
    <emitter type="constant"><rgb name="radiance" value="$grey"/></emitter>
</scene>"""
DEPTHS = SCENE.replace(
    '<integrator type="direct"/>',
    '<integrator type="aov"><string name="aovs" value="d:depth"/></integrator>',
)
NO_INTEGRATOR = SCENE.replace('<integrator type="direct"/>', "")


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.xml"
    path.write_text(SCENE)
    return path


def read(path) -> np.ndarray:
    return np.array(mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32))


def test_a_scene_becomes_a_picture_beside_it(scene, capsys):
    assert cli.main(["render", str(scene)]) == 0
    picture = scene.with_suffix(".exr")
    assert capsys.readouterr().out.strip() == str(picture)
    image = read(picture)
    assert image.shape == (4, 6, 3)
    np.testing.assert_allclose(image, 0.5, rtol=1e-3)  # half floats


def test_flags(scene, tmp_path):
    output = tmp_path / "small.exr"
    flags = ["-s", "1", "-D", "grey=0.25", "-D", "spp=1", "-o", str(output), "--spp", "2"]
    assert cli.main(["render", str(scene), "-m", "scalar_rgb", *flags]) == 0
    image = read(output)
    assert image.shape == (2, 2, 3)
    np.testing.assert_allclose(image, 0.25, rtol=1e-3)


def test_channels_have_their_names(tmp_path):
    """As of Mitsuba's executable, in order; EXR files sort them."""
    path = tmp_path / "scene.xml"
    nested = '<integrator name="nested" type="direct"/></integrator>'
    path.write_text(DEPTHS.replace("</integrator>", nested))
    assert cli.main(["render", str(path), "--spp", "5"]) == 0
    picture = mi.Bitmap(str(path.with_suffix(".exr")))
    assert np.array(picture.split()[0][1]).mean() == pytest.approx(0.5, rel=1e-3)
    names = [channel.name for channel in picture.struct_()]
    assert sorted(names) == ["B", "G", "R", "d.T", *(f"nested.{x}" for x in "ABGR")]


def test_a_film_of_xyz_has_the_same_colours(tmp_path):
    """In files that hold RGB."""
    pictures = []
    for colours in ("rgb", "xyz"):
        path = tmp_path / f"{colours}.xml"
        text = SCENE.replace('"$grey"', '"0.2, 0.4, 0.7"')
        option = f'<string name="pixel_format" value="{colours}"/>'
        film = '<film type="hdrfilm">'
        path.write_text(text.replace(film, film + option))
        assert cli.main(["render", str(path), "-o", str(path.with_suffix(".png"))]) == 0
        pictures.append(np.array(mi.Bitmap(str(path.with_suffix(".png"))), int))
    assert np.abs(pictures[0] - pictures[1]).max() <= 1


@pytest.mark.parametrize("flags", [["-t", "1"], []], ids=["asked for", "one core"])
def test_one_thread_reads_and_writes_exr_files(flags, scene, tmp_path):
    """Mitsuba waits for ever if it has one thread at that time."""
    mi.util.write_bitmap(str(tmp_path / "light.exr"), np.full((2, 4, 3), 0.5, np.float32), False)
    light = '<emitter type="envmap"><string name="filename" value="light.exr"/></emitter>'
    scene.write_text(SCENE[: SCENE.index("<emitter")] + light + "</scene>")
    threads = dr.thread_count() if flags else 1
    dr.set_thread_count(threads)
    assert cli.main(["render", str(scene), *flags]) == 0
    assert dr.thread_count() == max(threads, 2)
    np.testing.assert_allclose(read(scene.with_suffix(".exr")), 0.5, rtol=1e-3)


#: A plate whose direct light is sampled by its emitter as well, so that pictures have noise.
PLATE = SCENE.replace(
    "</scene>",
    '<shape type="rectangle"><bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape></scene>',
)


def test_a_picture_is_the_mean_of_independent_passes(tmp_path, monkeypatch, capsys):
    """The same for a seed but for rounding, and of 16 passes a quarter of the noise of one."""
    path = tmp_path / "plate.xml"
    path.write_text(PLATE)
    monkeypatch.setattr(Render, "RAYS", 4 * 32 * 32)

    def picture(spp, seed):
        flags = ["--spp", str(spp), "--seed", str(seed), "--width", "32", "--height", "32"]
        assert cli.main(["render", str(path), *flags]) == 0
        return read(path.with_suffix(".exr"))[..., 0]

    one, many = picture(4, 0), picture(64, 0)
    np.testing.assert_allclose(picture(64, 0), many, rtol=1e-3)  # half floats
    assert np.abs(picture(64, 1) - many).mean() > 0.5 * many.std()
    # 1,024 pixels, neighbours correlated by the filter: a standard deviation is known to 5 %.
    assert one.std() / many.std() == pytest.approx(4, rel=0.2)
    assert many.mean() == pytest.approx(0.25, rel=0.02)  # half of the light of 0.5
    assert capsys.readouterr().err == ""  # no bar off a terminal
    unequal = picture(6, 0)  # a pass of 4 samples and one of 2
    assert one.std() / unequal.std() == pytest.approx(1.5**0.5, rel=0.2)


def test_a_terminal_shows_the_progress(scene, monkeypatch):
    class Terminal(io.StringIO):
        def isatty(self):
            return True

    monkeypatch.setattr(sys, "stderr", Terminal())
    assert cli.main(["render", str(scene)]) == 0
    assert "4/4" in sys.stderr.getvalue()


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".PNG"])
def test_lights_of_thousands_of_nits_are_white(suffix, scene):
    path = scene.with_suffix(suffix)
    assert cli.main(["render", str(scene), "-D", "grey=10000", "-o", str(path)]) == 0
    assert np.array(mi.Bitmap(str(path))).min() >= 254  # JPEG rounds


def coated(parameter: str) -> str:
    return (
        f'<scene version="3.0.0"><shape type="sphere"><bsdf type="layered"><float {parameter}/>'
        '<bsdf type="diffuse"/></bsdf></shape></scene>'
    )


@pytest.mark.parametrize(
    ("text", "arguments", "sentence"),
    [
        (SCENE, "-m llvm_rgb", "Mitsuba has no variant 'llvm_rgb'; choose one of"),
        (SCENE, "-s 2", "--sensor is 2, but"),
        (SCENE, "-D grey", "-D 'grey' is not of the form key=value"),
        (SCENE, "-D gloss=1", "cannot load 'bad.xml': "),
        (SCENE, "-o picture.gif", "'picture.gif' does not end in a picture format; use .exr, .pn"),
        (SCENE, "-o /nowhere/at/all.exr", "cannot write '/nowhere/at/all.exr'"),
        (None, "", "scene file 'bad.xml' does not exist"),
        (None, "-o /proc/all.exr", "cannot write '/proc/all.exr': "),  # before the scene is read
        ("no XML", "", "cannot load 'bad.xml': "),
        ('<bsdf version="3.0.0" type="diffuse"/>', "", "its outermost element must be <scene>"),
        (
            '<scene version="3.0.0"><bsdf type="lacquer"/></scene>',
            "",
            "cannot load 'bad.xml': line 1: neither Mitsuba nor Urushi has a plugin 'lacquer'; if",
        ),
        ('<scene version="3.0.0"/>', "", "'bad.xml' has 0 sensors; give an index from 0, or add a"),
        (
            DEPTHS,
            "-o depths.png",
            "'bad.xml' has more channels than colours, which only .exr files",
        ),
        (NO_INTEGRATOR, "", "'bad.xml' has no integrator; add an <integrator> to the scene"),
        (SCENE.replace('"4"', '"many"', 1), "", "'bad.xml': line 8: could not parse integer"),
        (coated('name="alpha" value="7"'), "", "alpha is 7; it must be a GGX width in [0.01, 1]"),
        (coated('name="alpa" value="0.7"'), "", "alpa"),
        (coated('name="alpha" value="0.5"'), "-m scalar_rgb", "'layered' does not work in the var"),
    ],
)
def test_errors_name_the_file_once_with_the_line_and_without_a_traceback(
    text, arguments, sentence, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "bad.xml"
    if text is not None:
        path.write_text(text)
    assert cli.main(["render", str(path), *arguments.split()]) == 2
    error = capsys.readouterr().err.replace(str(path), "bad.xml")
    assert sentence in error and error.count("\n") == 1
    assert error.count("bad.xml") <= 1 + (text == "no XML")  # Mitsuba's parser names it
    assert not re.search(r"Traceback|\.py|\.cpp", error)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["tea-pot"], "there is no scene 'tea-pot'; give a scene file or 'caddy'"),
        (["."], "there is no scene '.'; give a scene file or 'caddy'"),
        (["x" * 300], f"there is no scene '{'x' * 300}'; give a scene file or 'caddy'"),
        (["caddy", "-D", "coat=foo"], "cannot load 'caddy': neither Mitsuba nor Urushi has a plu"),
        (["caddy", "-D", "spp=x"], "cannot load 'caddy': could not parse integer value \"x\""),
    ],
)
def test_errors_of_named_scenes_name_no_file(arguments, sentence, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["render", *arguments]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"urushi: {sentence}") and "scene.xml" not in error
    assert error.count("\n") == 1 and not list(tmp_path.iterdir())


def test_the_demos_scene_has_a_name_and_can_be_written(tmp_path, monkeypatch, capsys):
    """The folder of its name, which `urushi scene caddy` leaves behind, does not hide it."""
    monkeypatch.chdir(tmp_path)
    assert cli.main(["scene", "caddy"]) == 0
    assert capsys.readouterr().out == "caddy/scene.xml\n"
    written, shipped = ({x.name for x in f.iterdir()} for f in (Path("caddy"), DEMO_SCENE.parent))
    assert written == shipped
    flags = ["-D", "coat=layered", "-D", "width=16", "--height", "12", "--spp", "2"]
    assert cli.main(["render", "caddy", *flags]) == 0
    assert capsys.readouterr().out == "caddy.exr\n"
    assert list(mi.Bitmap("caddy.exr").size()) == [16, 12]


@pytest.mark.parametrize("stage", ["load_scene", "render"])
def test_an_interrupt_inside_a_plugin_is_an_interrupt(stage, tmp_path, monkeypatch, capsys):
    """Dr.Jit raises a RuntimeError because of it, Mitsuba one that quotes it."""

    def wrapped(*args, **options):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise RuntimeError("error while performing a custom operation") from error

    monkeypatch.chdir(tmp_path)
    path = tmp_path / "box.xml"
    path.write_text(SCENE)
    monkeypatch.setattr(
        *((mi, "render") if stage == "render" else (mi.parser, "instantiate")), wrapped
    )
    assert cli.main(["render", str(path), "-o", "a.exr"]) == cli.INTERRUPTED
    assert "interrupted" in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == ["box.xml"]


def test_render_replaces_weights_and_size_of_a_scene_file(variant, tmp_path, monkeypatch):
    """Weights only where a coat names none itself, from the working folder; the size always."""
    own = untrained()
    other = weights.save(tmp_path / "other", own.arch, own.params, {})
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "scene"
    path = export.export(globe, folder, Options(detail=0.05))
    coats = path.read_text().split('type="$coat"')
    assert len(coats) == 3
    named = '<string name="weights" value="default"/>'
    path.write_text('type="$coat"'.join([*coats[:2], coats[2].replace(">", f">{named}", 1)]))
    scene = load_scene(path, {}, weights="other", size={"width": 8, "height": 6})
    assert list(scene.sensors()[0].film().size()) == [8, 6]
    found = {
        shape.bsdf().model.fingerprint
        for shape in scene.shapes()
        if shape.bsdf().class_name() == "NeuralLayered"
    }
    assert found == {weights.default_model().fingerprint, other.fingerprint}
