"""Pictures of spheres: furnaces, symmetry, and Mitsuba's renderer as an independent method."""

import mitsuba as mi
import numpy as np
import pytest
from benchmarks.quality import environment_maps, sphere
from benchmarks.quality.sphere import AZIMUTHS, ELEVATIONS, Environment

from urushi.errors import FileError

SHAPE = ELEVATIONS, AZIMUTHS, 3


def lambertian(wi, wo):
    return np.full((len(wi), 1), 1 / np.pi)


def ggx(alpha):
    """A lobe (Walter et al. 2007) without masking, whose projected area is that of the plane."""

    def f(wi, wo):
        wi, wo = wi.astype(np.float64), wo.astype(np.float64)
        half = (wi + wo) / np.linalg.norm(wi + wo, axis=1, keepdims=True)
        tangent2 = half[:, 0] ** 2 + half[:, 1] ** 2
        d = alpha**2 / (np.pi * (alpha**2 * half[:, 2] ** 2 + tangent2) ** 2)
        return d[:, None] / (4 * (half * wi).sum(1) * wo[:, 2])[:, None]

    return f


def test_a_white_sphere_vanishes_in_a_white_furnace():
    (picture,) = sphere.render(lambertian, [Environment("white", np.ones(SHAPE))])
    inside = sphere.mask()
    np.testing.assert_allclose(picture[inside], 1, atol=1e-3)
    assert (picture[~inside] == 0).all()


@pytest.mark.parametrize("alpha", [0.005, 0.03, 0.1])
def test_narrow_lobes_are_integrated_whole(alpha):
    # In front, where no normal that matters is cut off, the integral of D(h) h.n is 1, and that of
    # this lobe with it: dh = dwo / 4 (wi.h), and h.n is within 1 % of 1 for these widths.
    (picture,) = sphere.render(ggx(alpha), [Environment("white", np.ones(SHAPE))])
    middle = picture[sphere.RINGS, sphere.RINGS]
    np.testing.assert_allclose(middle, 1, atol=0.015)


def test_light_turned_about_the_view_turns_the_picture():
    radiance = np.random.default_rng(1).random(SHAPE)
    turned = np.roll(radiance, AZIMUTHS // 4, axis=1)
    before, after = sphere.render(
        ggx(0.1), [Environment("before", radiance), Environment("after", turned)]
    )
    np.testing.assert_allclose(after, np.rot90(before), rtol=1e-4, atol=1e-5)


def test_channels_do_not_mix():
    radiance = np.random.default_rng(2).random(SHAPE)
    colour = np.array([0.2, 0.5, 1.0])
    light = [Environment("any", radiance)]
    (grey,) = sphere.render(lambertian, light)
    (coloured,) = sphere.render(lambda wi, wo: lambertian(wi, wo) * colour, light)
    np.testing.assert_allclose(coloured, grey * colour, rtol=1e-4, atol=1e-6)


def test_exposure_shows_a_white_sphere_in_middle_grey():
    exposed = sphere.exposed(sphere.own_environments()[1])
    (picture,) = sphere.render(lambertian, [exposed])
    luminance = picture[sphere.mask()].mean(0) @ [0.2126, 0.7152, 0.0722]
    assert luminance == pytest.approx(sphere.WHITE, rel=1e-6)


@pytest.fixture(scope="module")
def map_file(tmp_path_factory):
    """A map without symmetry: a sky, a bright patch beside the camera, a colour on one side."""
    rows, columns = 256, 512
    theta = np.pi * (np.arange(rows) + 0.5)[:, None] / rows
    phi = 2 * np.pi * (np.arange(columns) + 0.5) / columns
    radiance = np.ones((rows, columns, 3)) * (0.3 + 0.7 * np.cos(theta)[..., None] ** 2)
    patch = np.exp(-(((theta - 1.0) / 0.12) ** 2) - ((phi - 3.6) / 0.12) ** 2)
    radiance += 30 * patch[..., None]
    radiance[..., 0] += 0.5 * np.sin(theta) * (1 + np.sin(phi))
    path = tmp_path_factory.mktemp("map") / "map.exr"
    mi.Bitmap(radiance.astype(np.float32)).write(str(path))
    return path


def test_pictures_agree_with_mitsuba(map_file, variant):
    material = {"type": "roughconductor", "distribution": "ggx", "material": "none", "alpha": 0.15}
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "direct"},
            "light": {"type": "envmap", "filename": str(map_file)},
            "sphere": {"type": "sphere", "bsdf": material},
            "sensor": {
                "type": "orthographic",
                "to_world": mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]),
                "film": {
                    "type": "hdrfilm",
                    "width": 128,
                    "height": 128,
                    "rfilter": {"type": "box"},
                    "pixel_format": "rgb",
                },
            },
        }
    )
    reference = np.array(mi.render(scene, spp=256))
    bsdf = mi.load_dict(material)

    def f(wi, wo):
        si = mi.SurfaceInteraction3f()
        si.wi = mi.Vector3f(wi.T)
        value = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(wo.T))
        return np.array(value).T / wo[:, 2:]

    (picture,) = sphere.render(f, [environment_maps.read(map_file)])
    inside = sphere.mask().reshape(16, 8, 16, 8).all(axis=(1, 3))
    found, wanted = (
        x.reshape(16, 8, 16, 8, 3).mean(axis=(1, 3))[inside] for x in (picture, reference)
    )
    # Two renders differ by 0.5 % in the mean of squares, by 2 % where noise is worst.
    np.testing.assert_allclose(found, wanted, rtol=0.035)
    assert np.mean(found / wanted) == pytest.approx(1, abs=0.005)


def test_a_small_sun_keeps_its_light(tmp_path):
    rows, columns = 600, 1200  # read in blocks of 2 x 2
    radiance = np.zeros((rows, columns, 3), np.float32)
    radiance[200:203, 700:703] = 1e4
    mi.Bitmap(radiance).write(str(tmp_path / "sun.exr"))
    read = environment_maps.read(tmp_path / "sun.exr").radiance[..., 0]
    elevation = np.cos(np.pi * np.arange(rows + 1) / rows)
    wanted = 1e4 * 3 * (elevation[200] - elevation[203]) * 2 * np.pi / columns
    edges = np.cos(np.pi * np.arange(ELEVATIONS + 1) / ELEVATIONS)
    solid_angle = (edges[:-1] - edges[1:]) * 2 * np.pi / AZIMUTHS
    assert (read * solid_angle[:, None]).sum() == pytest.approx(wanted, rel=0.05)


def test_own_environments_have_light_on_every_side():
    for own in sphere.own_environments():
        assert own.radiance.shape == SHAPE
        assert (own.radiance > 0).all()


def test_files_that_are_no_maps(tmp_path):
    with pytest.raises(FileError, match="there is no file"):
        environment_maps.read(tmp_path / "missing.exr")
    (tmp_path / "page.hdr").write_text("<html></html>")
    with pytest.raises(FileError, match="cannot read the environment map"):
        environment_maps.read(tmp_path / "page.hdr")
    mi.Bitmap(np.full((8, 16, 3), np.inf, np.float32)).write(str(tmp_path / "bright.exr"))
    with pytest.raises(FileError, match="not finite"):
        environment_maps.read(tmp_path / "bright.exr")
