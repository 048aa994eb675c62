"""Baked materials and textures that are saved and loaded again."""

import re
import shutil
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest
from tests.mitsuba.probes import bitmap

import urushi
from urushi import files
from urushi.errors import FileError, UrushiWarning
from urushi.mitsuba.reading import probing
from urushi.nets import weights
from urushi.textures.store import TexelGrid, read_texture, write_texture

PIXELS = np.random.default_rng(0).uniform(0.1, 0.9, (5, 6, 3)).astype(np.float32)


def described(shipped, **properties) -> dict:
    return {
        "type": "neural_layered",
        "weights": str(shipped),
        "sigma_t": 0.8,
        "albedo": bitmap(PIXELS, **properties),
        "base": {"type": "roughconductor", "alpha": 0.3},
    }


def loaded(path, shipped):
    return mi.load_dict({"type": "neural_brdf", "filename": str(path), "weights": str(shipped)})


@pytest.fixture(scope="module")
def shipped():
    """The shipped weights, whose codes are near f of the plugin, which has functions of its own."""
    return weights.SHIPPED / "default.safetensors"


@pytest.fixture(scope="module")
def baked(shipped, tmp_path_factory):
    """A baked texture and its file, for all tests."""
    mi.set_variant("llvm_ad_rgb")
    path = tmp_path_factory.mktemp("saved") / "coat.safetensors"
    shear = mi.ScalarTransform3f(np.float32([[1.5, 0.25, 0.1], [-0.5, 2.2, 0.3], [0, 0, 1]]))
    coat = described(shipped, to_uv=shear, wrap_mode="mirror")
    # A file keeps its ratios: a coat of the plugin does, too, where `ext_ior` is given.
    bsdf = mi.load_dict(coat | {"ext_ior": "air", "resolution": 9})
    bsdf.save(path)
    return bsdf, path


@pytest.fixture
def saved(rgb, baked, tmp_path):
    """The texture and a copy of its file."""
    bsdf, path = baked
    return bsdf, Path(shutil.copy(path, tmp_path))


def test_texels_have_the_codes_of_the_places_and_are_written_again(shipped, saved, tmp_path):
    bsdf, path = saved
    again = loaded(path, shipped)
    grid = again.latents.baked.grid
    assert grid == TexelGrid(9, 9)
    expected = bsdf.latents.at(grid.uv())
    # 8 bits of a number's range
    tolerance = 0.01 * np.ptp(expected, axis=(0, 1)) + 1e-4
    assert (np.abs(again.latents.at(grid.uv()) - expected) <= tolerance).all()
    again.save(tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == path.read_bytes()


def test_a_constant_coat_is_saved_as_a_material(rgb, shipped, tmp_path):
    path = tmp_path / "coat.safetensors"
    bsdf = rgb.load_dict(described(shipped) | {"albedo": 0.5})
    bsdf.save(path)
    material = urushi.load(path, shipped)
    np.testing.assert_array_equal(material.latents, bsdf.latents.at(np.zeros((1, 2)))[0])
    assert str(loaded(path, shipped))


def test_a_saved_texture_can_be_coated(rgb, shipped, saved):
    """At the centres of texels, f is that of the coat over the plugin that was saved."""
    bsdf, path = saved
    grid = loaded(path, shipped).latents.baked.grid
    coat = {"type": "neural_layered", "weights": str(shipped), "alpha": 0.05, "resolution": 9}
    wi, wo = (np.tile(w, (grid.texels, 1)) for w in ([0.6, 0, 0.8], [0, 0.28, 0.96]))
    found, expected = (
        probing.bsdf_values(rgb.load_dict(coat | {"base": base}), wi, wo, grid.uv())
        for base in (loaded(path, shipped), bsdf)
    )
    np.testing.assert_allclose(found, expected, rtol=0.02)


@pytest.mark.slow
def test_a_saved_texture_under_unusual_coats_warns_once(rgb, shipped, saved):
    """Not for every texel, of which the coat has a whole number in each of the saved ones."""
    texture = bitmap(np.linspace(1, 20, 16).reshape(4, 4, 1))
    coat = {"type": "neural_layered", "weights": str(shipped), "albedo": 1.0, "g": 0.95}
    with pytest.warns(UrushiWarning) as caught:
        base = loaded(saved[1], shipped)
        grid = rgb.load_dict(coat | {"sigma_t": texture, "base": base}).latents.baked.grid
    below = base.latents.baked.grid
    assert grid.width % below.width == grid.height % below.height == 0
    (warning,) = caught
    sentence = r"^neural_layered: g is outside \[-0.8, 0.9\] and sigma_t is above 8"
    assert re.match(sentence, str(warning.message))


#: Changes of a file's description and arrays that damage it.
DAMAGES = [
    lambda description, arrays: arrays.pop("texels"),
    lambda description, arrays: arrays.update(texels=arrays["texels"][:-1]),
    lambda description, arrays: arrays.update(step=arrays["step"] * np.float32(np.nan)),
    lambda description, arrays: description.update(width=7),
    lambda description, arrays: description.update(height=0),
    lambda description, arrays: description["layout"].update(stride=400),
    lambda description, arrays: description["layout"].update(low=[0] * 32),
    lambda description, arrays: description["layout"].pop("size"),
    lambda description, arrays: description["place"].update(wrap="around"),
    lambda description, arrays: description["place"].update(to_texture=[1, 2]),
    lambda description, arrays: description.pop("place"),
    lambda description, arrays: description.pop("width"),
]
OTHERS = [lambda description, arrays, x=x: description.update(version=x) for x in (1, 2, 3, 5)]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        *((x, "the texture file .* is damaged") for x in DAMAGES),
        *((x, "version . of the texture") for x in OTHERS),
    ],
)
def test_a_damaged_file_and_other_versions_are_refused(rgb, shipped, saved, change, sentence):
    _, path = saved
    description, arrays = files.read_tensors(path, "texture")
    change(description, arrays)
    description.pop("kind")
    files.write_tensors(path, "texture", description, arrays)
    with pytest.raises(RuntimeError, match=f"FileError: .*{sentence}"):
        loaded(path, shipped)


@pytest.mark.parametrize("size", [{"width": 7}, {"width": -9, "height": -9}])
def test_a_whole_file_whose_texels_do_not_fill_its_grid_is_refused(rgb, shipped, saved, size):
    _, path = saved
    texture, grid, model = read_texture(path, weights.find(shipped))
    write_texture(path, texture, grid._replace(**size), model.fingerprint)
    with pytest.raises(RuntimeError, match="FileError: .* is damaged .*do not fill its grid"):
        loaded(path, shipped)


@pytest.mark.parametrize(
    "change",
    [
        lambda whole: {"bytes": whole.bytes[:, :-1]},
        lambda whole: {"bytes": whole.bytes.astype(np.float32)},
        lambda whole: {"lowest": whole.lowest[:-1]},
        lambda whole: {"step": whole.step * np.float32(np.nan)},
        lambda whole: {"layout": whole.layout._replace(stride=400)},
        lambda whole: {"layout": whole.layout._replace(low=(1000,) * whole.layout.size)},
        lambda whole: {"layout": whole.layout._replace(high=whole.layout.high[1:])},
        lambda whole: {"layout": whole.layout._replace(same=("yes",))},
        lambda whole: {"layout": whole.layout._replace(channels=2.5)},
        lambda whole: {"layout": whole.layout._replace(channels=10**9, stride=0)},
        lambda whole: {"layout": whole.layout._replace(high=3)},
    ],
)
def test_a_texture_that_does_not_fit_its_layout_is_refused(rgb, shipped, saved, change):
    """Though the checksum of the file is right."""
    _, path = saved
    texture, grid, model = read_texture(path, weights.find(shipped))
    write_texture(path, texture._replace(**change(texture)), grid, model.fingerprint)
    with pytest.raises(FileError, match="the texture file .* is damaged .*; save it again"):
        read_texture(path, weights.find(shipped))


def test_a_file_of_other_networks_is_refused(rgb, model, saved, tmp_path):
    _, path = saved
    other = tmp_path / "other.safetensors"
    weights.save(other, model.arch, {k: 2 * x for k, x in model.params.items()}, {})
    with pytest.raises(RuntimeError, match="FileError: .* does not match the weights"):
        loaded(path, other)
