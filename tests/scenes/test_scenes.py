"""The shipped scenes: they load and render, one word swaps networks and walk, and XML is Python."""

import re
from functools import partial

import numpy as np
import pytest

from urushi.app import cli
from urushi.app.commands.render import Overrides, load_scene
from urushi.errors import ParameterError
from urushi.nets import weights
from urushi.scenes import shipped
from urushi.scenes.stage import COATS, Options

TINY = {"width": 64, "height": 48, "spp": 16, "detail": 0.1}

#: The scenes; two of them take longest to compile.
NAMES = [
    pytest.param(name, marks=pytest.mark.slow) if name in ("still-life", "shoe") else name
    for name in shipped.SCENES
]


@pytest.fixture(scope="module")
def mi():
    import mitsuba

    import urushi  # noqa: F401  (registers the plugins)

    mitsuba.set_variant("llvm_ad_rgb")
    return mitsuba


@pytest.mark.parametrize("name", NAMES)
def test_networks_and_walk_give_a_scene_the_same_light(mi, name, tmp_path):
    """Mean radiances differ by less than 2 % and three standard errors.

    The networks' own error is a percent of energy on average, and more for some materials; the
    standard error is that of eight renders of 16 samples a pixel, of either kind.
    """
    means = {}
    for coat in COATS:
        scene = mi.load_dict(shipped.build(name, tmp_path, Options(coat=coat, **TINY)))
        images = np.array([mi.render(scene, seed=seed).numpy() for seed in range(8)])
        assert images.shape[1:] == (48, 64, 3)
        assert np.isfinite(images).all()
        assert images.min() >= 0
        assert (images.mean(axis=0) > 0).mean() > 0.99, "nothing is in total darkness"
        means[coat] = images.mean(axis=(1, 2, 3))
    networks, walk = means.values()
    error = np.sqrt((networks.var(ddof=1) + walk.var(ddof=1)) / 8)
    assert abs(networks.mean() - walk.mean()) < 0.02 * walk.mean() + 3 * error


@pytest.mark.parametrize("name", NAMES)
def test_the_exported_file_renders_as_the_dictionary_does(mi, name, tmp_path):
    """With the same seed, to what transforms lose when they are written as steps."""
    options = Options(coat="layered", **TINY)
    described = mi.render(mi.load_dict(shipped.build(name, tmp_path / "a", options)), seed=1)
    path = shipped.export(name, tmp_path / "b" / "c", options)
    text = path.read_text()
    assert str(tmp_path) not in text, "the folder can be moved"
    named = set(re.findall(r'name="filename" value="([^"]+)"', text))
    assert named == {file.name for file in path.parent.iterdir()} - {"scene.xml"}
    loaded = mi.render(load_scene(path, {}), seed=1)
    difference = np.abs(described.numpy() - loaded.numpy())
    assert np.quantile(difference, 0.999) < 1e-4
    assert difference.mean() < 1e-4


def test_the_coat_is_a_parameter_of_the_file(mi, tmp_path):
    path = shipped.export("globe", tmp_path, Options(**TINY))
    text = path.read_text()
    assert '<default name="coat" value="neural_layered"/>' in text
    assert text.count('type="$coat"') == 2
    small = load_scene(path, {"coat": "layered", "width": "8", "height": "6", "spp": "2"})
    assert mi.render(small).shape == (6, 8, 3)
    kinds = {type(shape.bsdf()).__name__ for shape in small.shapes()}
    assert "Layered" in kinds and "NeuralLayered" not in kinds


def test_weights_are_named_only_where_they_matter():
    def keys(**options):
        return set(Options(**options).coated({"type": "diffuse"}, alpha=0.1))

    assert keys() == keys(coat="layered") == keys(coat="layered", weights="small")
    assert keys(weights="small") == keys() | {"weights"}


def test_render_takes_a_scenes_name(mi, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(shipped, "Options", partial(Options, detail=0.05))
    flags = ["-D", "coat=layered", "-D", "width=16", "--height", "12", "--spp", "2"]
    assert cli.main(["render", "globe", *flags]) == 0
    assert capsys.readouterr().out == "globe.exr\n"
    assert list(mi.Bitmap("globe.exr").size()) == [16, 12]


def test_render_replaces_weights_and_size_of_a_scene_file(mi, tmp_path):
    """Weights only where a coat names none itself; the size always."""
    path = shipped.export("globe", tmp_path, Options(**TINY))
    coats = path.read_text().split('type="$coat"')
    assert len(coats) == 3
    named = '<string name="weights" value="base"/>'
    path.write_text('type="$coat"'.join([*coats[:2], coats[2].replace(">", f">{named}", 1)]))
    scene = load_scene(path, {}, overrides=Overrides("small", width=8, height=6))
    assert list(scene.sensors()[0].film().size()) == [8, 6]
    found = {
        shape.bsdf().model.fingerprint
        for shape in scene.shapes()
        if type(shape.bsdf()).__name__ == "NeuralLayered"
    }
    assert found == {weights.load_shipped(name).fingerprint for name in weights.SHIPPED}
    with pytest.raises(ParameterError, match="^width is 0; it must be at least 1$"):
        Overrides(width=0)


def test_export_and_list(tmp_path, capsys):
    assert cli.main(["scenes", "export", "globe", str(tmp_path / "new"), "--detail", "0.05"]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'new' / 'scene.xml'}\n"
    assert (tmp_path / "new" / "scene.xml").is_file()
    assert cli.main(["scenes", "list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == list(
        shipped.SCENES
    )


@pytest.mark.parametrize(
    "arguments",
    [["render", "tea-pot"], ["scenes", "export", "tea-pot", "folder"]],
)
def test_unknown_names_are_told_the_choices(arguments, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(arguments) == 2
    sentence = "there is no scene 'tea-pot'; choose one of still-life, globe, teapot, shoe"
    assert capsys.readouterr().err == f"urushi: {sentence}\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"coat": "varnish"}, "coat is 'varnish'; choose one of neural_layered, layered"),
        ({"width": 0}, "width is 0; it must be at least 1"),
        ({"detail": 0}, "detail is 0; it must be above 0 and at most 4"),
    ],
)
def test_bad_options(options, sentence):
    with pytest.raises(ParameterError, match=f"^{re.escape(sentence)}$"):
        Options(**options)
