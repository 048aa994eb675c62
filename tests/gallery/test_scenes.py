"""All scenes load and render, with networks or the walk, from Python and from XML."""

import re

import mitsuba as mi
import numpy as np
import pytest
from gallery import export
from gallery.options import COATS, Options
from gallery.scenes import SCENES

from urushi.app.render import DEMO_SCENE, load_scene

pytestmark = pytest.mark.usefixtures("rgb")

TINY = {"width": 64, "height": 48, "spp": 32, "detail": 0.05}


def unfiltered(node: dict) -> dict:
    """A description whose textures have no filter."""
    result = {k: unfiltered(v) if isinstance(v, dict) else v for k, v in node.items()}
    return result | ({"filter_type": "nearest"} if node.get("type") == "bitmap" else {})


@pytest.fixture(scope="module", params=SCENES)
def rendered(request, tmp_path_factory):
    """A scene's name, and by coat two renders (2, 48, 64, 3) of it with the seeds 0 and 1.

    Textures are not filtered: between texels, the walk takes the mean of parameters and the
    networks that of f.
    """
    mi.set_variant("llvm_ad_rgb")
    images = {}
    for coat in COATS:
        folder = tmp_path_factory.mktemp(f"{request.param}-{coat}")
        options = Options(coat=coat, **TINY)
        scene = mi.load_dict(unfiltered(export.build(SCENES[request.param], folder, options)))
        images[coat] = np.array([mi.render(scene, seed=seed).numpy() for seed in range(2)])
    return request.param, images


def mean_and_error(images: np.ndarray) -> tuple[float, float]:
    """Mean radiance and its standard error, from the differences of two renders (2, H, W, 3).

    They are computed from blocks of 8 x 8 pixels, because the film's filter correlates neighbours.
    A block's three channels count as one observation.
    """
    _, height, width, _ = images.shape
    blocks = images.reshape(2, height // 8, 8, width // 8, 8, 3).mean(axis=(2, 4, 5))
    difference = blocks[0] - blocks[1]
    return float(images.mean()), float(np.sqrt((difference**2).sum() / 4) / difference.size)


def test_networks_and_walk_give_a_scene_the_same_light(rendered):
    """Mean radiances differ by less than 2 % and three standard errors.

    The networks' own error is a percent of energy on average, and more for some materials.
    """
    _, images = rendered
    for pair in images.values():
        assert pair.shape[1:] == (48, 64, 3)
        assert np.isfinite(pair).all()
        assert pair.min() >= 0
        assert (pair.mean(axis=0) > 0).all(), "nothing is in total darkness"
    (networks, networks_error), (walk, walk_error) = map(mean_and_error, images.values())
    assert abs(networks - walk) < 0.02 * walk + 3 * np.hypot(networks_error, walk_error)


#: A number in what an object prints.
NUMBER = re.compile(r"-?\d+(?:\.\d*)?(?:e[+-]?\d+)?")


@pytest.fixture
def printed(tmp_path):
    """A function: what the objects of a scene print, without numbers; numbers, and vertices.

    Threads load shapes in any order, and boxes do not show how a mesh is turned.
    """

    def of(scene):
        shapes, name = sorted(scene.shapes(), key=str), "vertex_positions"
        vertices = [own[name].numpy() for own in map(mi.traverse, shapes) if name in own]
        objects = [scene.integrator(), *scene.sensors(), scene.environment(), *shapes]
        text = "\n".join(map(str, objects)).replace(f"{tmp_path / 'a'}/", "")
        return NUMBER.sub("", text), np.concatenate([np.float64(NUMBER.findall(text)), *vertices])

    return of


@pytest.mark.parametrize("name", SCENES)
def test_the_exported_file_describes_the_scene(name, printed, tmp_path):
    """The files are equal, and all objects print the same, to single precision.

    Transforms lose last bits when they are written as steps. There walks draw other random numbers,
    so that pictures, which are noise, are not compared.
    """
    options = Options(coat="layered", **TINY)
    scene = mi.load_dict(export.build(SCENES[name], tmp_path / "a", options))
    path = export.export(SCENES[name], tmp_path / "b" / "c", options)
    assert str(tmp_path) not in path.read_text(), "the folder can be moved"
    written, exported = (
        {file.name: file.read_bytes() for file in folder.iterdir() if file != path}
        for folder in (tmp_path / "a", path.parent)
    )
    assert written == exported
    (objects, numbers), (others, expected) = map(printed, (load_scene(path, {}), scene))
    assert objects == others
    np.testing.assert_allclose(numbers, expected, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize(
    ("name", "parameter", "count"),
    [("globe", 'type="$coat"', 2), ("car", 'name="reference" value="$coat"', 6)],
)
def test_coat_size_and_samples_are_parameters_of_the_file(
    name, parameter, count, printed, tmp_path
):
    """Of files with other defaults the scenes are the same."""
    small = {"width": 8, "height": 6, "spp": 2}
    path = export.export(SCENES[name], tmp_path / "a", Options(**TINY))
    assert '<default name="coat" value="neural_layered"/>' in path.read_text()
    assert path.read_text().count(parameter) == count
    walks = export.export(SCENES[name], tmp_path, Options(coat="layered", **TINY | small))
    given = {"coat": "layered"} | {key: str(value) for key, value in small.items()}
    (objects, numbers), (others, expected) = map(
        printed, (load_scene(path, given), load_scene(walks, {}))
    )
    assert objects == others and objects != printed(load_scene(path, {}))[0]
    np.testing.assert_array_equal(numbers, expected)


def test_the_demos_scene_is_the_gallerys(tmp_path):
    """The files in the package are those that `python -m gallery caddy` writes."""
    written = export.export(SCENES["caddy"], tmp_path)
    assert {x.name for x in tmp_path.iterdir()} == {x.name for x in DEMO_SCENE.parent.iterdir()}
    texts = (re.sub(r'version="[0-9.]+"', "", x.read_text()) for x in (written, DEMO_SCENE))
    assert len(set(texts)) == 1
    for file in (*tmp_path.glob("*.ply"), *tmp_path.glob("*.exr")):
        shipped = DEMO_SCENE.parent / file.name
        if file.suffix == ".exr":
            pictures = (np.array(mi.Bitmap(str(x)), np.float32) for x in (file, shipped))
            np.testing.assert_allclose(*pictures, rtol=1e-3, atol=1e-6)  # half floats
        else:
            assert file.stat().st_size == shipped.stat().st_size
