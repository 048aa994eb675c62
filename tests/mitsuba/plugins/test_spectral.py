"""Coats in spectral variants against the walk of the same variant, and what their bands keep."""

import mitsuba as mi
import numpy as np
import pytest

import urushi  # noqa: F401  (registers the plugins)
from urushi.core.namespace import NUMPY
from urushi.measured.rgl import srgb_weights
from urushi.mitsuba import spectrum

SATURATED = [(0.9, 0.05, 0.02), (0.05, 0.9, 0.02), (0.1, 0.5, 0.3)]


@pytest.fixture(autouse=True)
def spectral():
    mi.set_variant("llvm_ad_spectral")
    yield
    mi.set_variant("llvm_ad_rgb")


def coated(plugin: str, **bottom) -> dict:
    return {"type": plugin, "alpha": 0.1, "base": bottom}


def lambertian(color, plugin: str) -> dict:
    return coated(plugin, type="diffuse", reflectance={"type": "rgb", "value": color})


def openpbr(color, plugin: str) -> dict:
    return {
        "type": "openpbr",
        "base_color": {"type": "rgb", "value": color},
        "coat_weight": 1.0,
        "reference": plugin == "layered",
    }


def furnace(bsdf: dict, spp: int = 1024) -> np.ndarray:
    """Linear sRGB of a plane in a white world, seen at 40 degrees."""
    transform = mi.ScalarTransform4f().look_at([0, 2.5, 3], [0, 0, 0], [0, 1, 0])
    film = {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}}
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "sensor": {"type": "perspective", "fov": 15, "to_world": transform, "film": film},
        "light": {"type": "constant", "radiance": {"type": "d65"}},
        "shape": {"type": "rectangle", "bsdf": bsdf},
    }
    return np.array(mi.render(mi.load_dict(scene), spp=spp)).mean(axis=(0, 1))[:3]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("material", "color"), [(lambertian, SATURATED[1]), (openpbr, SATURATED[0])]
)
def test_saturated_colours_are_those_of_the_walk(material, color):
    """3 %, and 0.3 % of the largest channel: the noise of the difference of positive and negative
    wavelengths in channels that are nearly black."""
    walk, coat = (furnace(material(color, plugin)) for plugin in ("layered", "neural_layered"))
    np.testing.assert_array_less(np.abs(coat - walk), 0.03 * np.abs(walk) + 0.003 * walk.max())


def texture(*color: float) -> dict:
    """Two saturated shades in turn; each load needs a bitmap of its own."""
    shades = np.array([color, 0.7 * np.array(color)])[[[0, 1], [1, 0]]]
    bitmap = mi.Bitmap(shades.astype(np.float32))
    return {"type": "bitmap", "bitmap": bitmap, "filter_type": "nearest"}


def textured_lambertian(color, plugin: str) -> dict:
    return coated(plugin, type="diffuse", reflectance=texture(*color))


def textured_depth(color, plugin: str) -> dict:
    return lambertian((0.8, 0.8, 0.8), plugin) | {"sigma_t": texture(*color)}


def textured_medium(color, plugin: str) -> dict:
    return lambertian((0.8, 0.8, 0.8), plugin) | {"sigma_t": 0.7, "albedo": texture(*color)}


def textured_metal(color, plugin: str) -> dict:
    metal = {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": 0.3}
    return coated(plugin, **metal, specular_reflectance=texture(*color))


@pytest.mark.parametrize(
    "material", [textured_lambertian, textured_depth, textured_medium, textured_metal]
)
def test_saturated_textures_are_those_of_the_walk(material):
    """As for constants, with 1 % of the largest channel where codes of dark metals are coarse."""
    color = SATURATED[1]
    walk, coat = (furnace(material(color, plugin)) for plugin in ("layered", "neural_layered"))
    least = 0.01 if material is textured_metal else 0.003
    np.testing.assert_array_less(np.abs(coat - walk), 0.03 * np.abs(walk) + least * walk.max())


@pytest.mark.slow
def test_a_textured_openpbr_is_as_near_as_in_rgb_variants():
    """Its codes err by 5 %; three bands alone would by 25 %."""

    def surface(plugin: str) -> dict:
        color = {"base_color": texture(0.9, 0.3, 0.02), "coat_weight": 1.0}
        return {"type": "openpbr", "reference": plugin == "layered"} | color

    walk, coat = (furnace(surface(plugin)) for plugin in ("layered", "neural_layered"))
    np.testing.assert_array_less(np.abs(coat - walk), 0.05 * np.abs(walk) + 0.003 * walk.max())


def test_a_metals_index_is_that_of_each_wavelength():
    """3 %: that of the networks over gold."""
    gold = {"type": "roughconductor", "material": "Au", "alpha": 0.2, "distribution": "ggx"}
    walk, coat = (furnace(coated(plugin, **gold)) for plugin in ("layered", "neural_layered"))
    np.testing.assert_allclose(coat, walk, rtol=0.03)


def test_grey_is_grey_and_white_returns_no_more_than_one():
    """A grey coat has one value at all wavelengths, and the integral of f cos is at most one.

    Bands of single precision may round to neighbouring numbers of the table at some of its nodes.
    """
    bsdf = mi.load_dict(coated("neural_layered", type="diffuse", reflectance=1.0))
    si = mi.SurfaceInteraction3f()
    si.wi, si.wavelengths = mi.Vector3f(0.6, 0, 0.8), mi.Spectrum(400, 500, 600, 700)
    grid = (np.arange(256) + 0.5) / 256
    radius, azimuth = (x.ravel() for x in np.meshgrid(np.sqrt(grid), 2 * np.pi * grid))
    wo = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), np.sqrt(1 - radius**2)])
    f_cos = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(wo)).numpy()
    albedo = np.pi * (f_cos / wo[2]).mean(axis=-1)
    np.testing.assert_allclose(albedo, albedo[0], rtol=1e-4)
    assert albedo.max() <= 1.001  # the rule at the coat's peak


def test_a_colour_becomes_a_spectrum_of_that_colour():
    """By the CIE observer under D65; between the least channel and the largest (convex)."""
    nm = np.arange(360, 831.0)
    red, green, blue = (spectrum.of_rgb(color, nm, NUMPY) for color in np.eye(3))
    assert min(x.min() for x in (red, green, blue)) > -1e-6
    np.testing.assert_allclose(red + green + blue, 1, rtol=1e-12)
    found = np.stack([red, green, blue]) @ srgb_weights(nm)
    np.testing.assert_allclose(found, np.eye(3), atol=1e-6)


@pytest.mark.parametrize("color", [SATURATED[0], SATURATED[2], (0.0, 0.0, 0.0)])
def test_colours_of_media_keep_their_colour(color):
    """sigma_t is exact for light that crosses an absorbing medium twice; 0.2 %: nodes of 2 nm."""
    nm = np.arange(360, 831.0)

    def colour_of(found: dict, of=lambda x: x) -> np.ndarray:
        values = np.full(len(nm), found.get("value", 0.0))
        if found["type"] == "irregular":
            at, given = (np.fromstring(found[x], sep=",") for x in ("wavelengths", "values"))
            values = np.interp(nm, at, given)
        mi.load_dict(found)
        return of(values) @ srgb_weights(nm)

    rgb = np.array(color)
    np.testing.assert_allclose(colour_of(spectrum.from_color(color)), rgb, atol=2e-3)
    squared = colour_of(spectrum.from_color(color, power=2), np.square)
    np.testing.assert_allclose(squared, rgb**2, atol=2e-3)
    passed = colour_of(spectrum.from_depth(color), lambda depth: np.exp(-2 * depth))
    np.testing.assert_allclose(passed, np.exp(-2 * rgb), atol=2e-3)


def test_wavelengths_have_the_bands_that_they_lie_in():
    """Of Mitsuba's wavelengths as many lie in each band, but for those beyond the ends."""
    u = (np.arange(1 << 12) + 0.5) / (1 << 12)
    wavelengths, _ = mi.sample_rgb_spectrum(mi.Spectrum(mi.Float(u)))
    inside = np.abs(wavelengths[0].numpy() - np.mean(spectrum.ENDS)) < np.ptp(spectrum.ENDS) / 2
    bands = spectrum.band_at(wavelengths)[0].numpy()[inside]
    count = np.bincount(bands, minlength=spectrum.COUNT)
    np.testing.assert_allclose(count, inside.sum() / spectrum.COUNT, atol=2)
