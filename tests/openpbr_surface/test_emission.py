"""The emitter `openpbr_emission`: closed forms, and a scene that it lights."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from tests.mitsuba.probes import interaction
from tests.openpbr_surface.probes import WALKS, toward
from tests.oracles.slab import interface_reflectance

import urushi

pytestmark = pytest.mark.usefixtures("rgb")

COLOR = (1.0, 0.5, 2.0)  # an emission colour may exceed one
LIGHT = {"emission_luminance": 3.0, "emission_color": COLOR}
SQUARE = {"type": "rectangle"}
BLACK = dict(base_weight=0.0, specular_weight=0.0)


def radiance(cosine, **parameters):
    """What a square emits at an angle to its normal, (3,)."""
    square = mi.load_dict(urushi.openpbr(**LIGHT, **parameters).on(SQUARE))
    return square.emitter().eval(interaction(toward(cosine)[None])).numpy().ravel()


@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.2])
def test_the_base_emits_evenly(cosine):
    assert np.allclose(radiance(cosine), 3 * np.array(COLOR))
    assert np.allclose(radiance(cosine, geometry_opacity=0.25), 0.75 * np.array(COLOR))


@pytest.mark.parametrize("cosine", [1.0, 0.5, 0.2])
def test_a_smooth_coat_passes_what_it_does_not_reflect(cosine):
    """One crossing along the refracted path: half of the optical depth of coat_color."""
    color, eta = np.array([0.9, 0.4, 0.1]), 1.6
    inside = (1 - (1 - cosine**2) / eta**2) ** 0.5
    coated = (1 - interface_reflectance(cosine, eta)) * color ** (0.5 / inside)
    # The light passes either coat alike.
    coat = dict(coat_color=tuple(color)) | WALKS
    found = radiance(cosine, coat_weight=1.0, **coat)
    assert np.allclose(found, 3 * np.array(COLOR) * coated, rtol=0.01)
    half = radiance(cosine, coat_weight=0.5, **coat)
    assert np.allclose(half, 0.5 * (radiance(cosine) + found), rtol=1e-4)


def test_only_a_thin_wall_emits_on_its_back():
    """A thin wall is the same from either side (OpenPBR Surface 1.1.1, thin-walled case)."""
    layers = dict(coat_weight=0.7, coat_color=(0.9, 0.4, 0.1), fuzz_weight=0.5) | WALKS
    assert not radiance(-0.5, **layers).any()
    both = [radiance(c, geometry_thin_walled=True, **layers) for c in (0.5, -0.5)]
    assert np.allclose(both, radiance(0.5, **layers))


def picture(integrator, samples, material):
    """A square that lights a screen, both seen by a camera: means and errors over 2 x 4 blocks."""
    turn = mi.ScalarTransform4f().translate([0, 0.6, 1]).rotate([1, 0, 0], 120).scale(0.5)
    to_world = mi.ScalarTransform4f().look_at([0, -4, 1], [0, 0, 0.5], [0, 0, 1])
    film = {"type": "hdrfilm", "width": 16, "height": 8, "rfilter": {"type": "box"}}
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": integrator, "max_depth": 2},
            "light": material.on(SQUARE | {"to_world": turn}),
            "screen": {"type": "rectangle", "bsdf": {"type": "diffuse"}},
            "sensor": {"type": "perspective", "fov": 35, "to_world": to_world, "film": film},
        }
    )
    parts = [mi.render(scene, spp=samples, seed=i).numpy() for i in range(6)]
    blocks = np.stack(parts).reshape(6, 2, 4, 4, 4, 3).mean(axis=(2, 4))
    return blocks.mean(axis=0), blocks.std(axis=0, ddof=1) / 6**0.5


@pytest.mark.parametrize("thin", [False, True])
def test_particles_light_as_much_as_paths(thin):
    """Two integrators of Mitsuba: one follows light from emitters, the other from the camera."""
    layers = dict(fuzz_weight=0.7, coat_weight=0.8, coat_color=(0.9, 0.4, 0.1))
    layers = {"geometry_thin_walled": True} if thin else layers
    material = urushi.openpbr(**LIGHT, **BLACK, **layers, reference=True)
    (paths, error), (particles, other) = (
        picture(*x, material) for x in (("path", 256), ("ptracer", 1024))
    )
    assert (paths.mean(axis=(0, 1)) > 0.05).all()
    assert (np.abs(paths - particles) <= 5 * np.hypot(error, other) + 0.01 * paths).all()


@pytest.mark.parametrize("light", [1.0, {"type": "blackbody", "temperature": 2700}])
def test_white_light_is_that_of_mitsubas_emitters_in_spectral_variants(spectral, light):
    """Numbers and colours are relative to D65; a spectrum is the light's own."""
    lamp = urushi.openpbr(emission_luminance=3.0, emission_color=light)
    theirs = {"type": "area", "radiance": light if isinstance(light, dict) else 3.0}
    si = dr.zeros(mi.SurfaceInteraction3f, 1)
    si.wi, si.wavelengths = mi.Vector3f(0.6, 0, 0.8), mi.Spectrum(420, 500, 560, 640)
    ours, theirs = (
        mi.load_dict(shape).emitter().eval(si).numpy()
        for shape in (lamp.on(SQUARE), SQUARE | {"emitter": theirs})
    )
    factor = 3.0 if isinstance(light, dict) else 1.0
    np.testing.assert_allclose(ours, factor * theirs, rtol=1e-5)


def test_a_material_without_light_has_no_emitter():
    assert urushi.openpbr().emitter() is None
    assert "emitter" not in urushi.openpbr(emission_luminance=0.0).on(SQUARE)
    assert "emission_color" not in urushi.openpbr(**LIGHT).description()
