"""`openpbr` in the variants: the same material in RGB, monochromatic and spectral."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from tests.mitsuba.probes import in_white_world
from tests.openpbr_surface.probes import WALKS, anywhere, loaded, pairs, values

import urushi
from urushi.measured.rgl import srgb_weights
from urushi.openpbr_surface.inputs import Inputs
from urushi.openpbr_surface.parts import tint_of

VARIANTS = ("llvm_ad_rgb", "llvm_ad_mono", "llvm_ad_spectral")

GREY, COLOR, GREEN = (0.5, 0.5, 0.5), (0.7, 0.5, 0.3), (0.2, 0.8, 0.3)

BODY = {"interior": True, "specular_roughness": 0.5}

COAT = {"coat_weight": 0.5, "coat_color": GREY, "fuzz_weight": 0.5}
MATERIALS = {
    "mixture": {"base_metalness": 0.5, "base_diffuse_roughness": 0.5} | COAT,
    "walks": {"coat_weight": 1.0, "coat_roughness": 0.4} | WALKS,
    "glass": BODY | {"transmission_weight": 1.0},
    "skin": BODY | {"subsurface_weight": 1.0, "specular_ior": 1.4},
    "half": BODY | {"transmission_weight": 0.5},
    "leaf": {"geometry_thin_walled": True, "subsurface_weight": 1.0, "subsurface_color": GREY},
}


def in_variants(function):
    """The value of a function in each variant."""
    found = {}
    for variant in VARIANTS:
        mi.set_variant(variant)
        found[variant] = function()
    mi.set_variant("llvm_ad_rgb")
    return found


@pytest.mark.parametrize("name", MATERIALS)
def test_grey_is_the_same_in_all_variants(name):
    """The walks of all variants draw the same random numbers."""
    wi, wo = (pairs if name in ("mixture", "walks") else anywhere)(100, 7)
    material = MATERIALS[name] | {"base_color": GREY}
    found = in_variants(lambda: values(loaded(**material), wi, wo)[:, :1])
    for f in found.values():
        np.testing.assert_allclose(f, found["llvm_ad_rgb"], rtol=2e-3, atol=1e-5)


@pytest.mark.parametrize(
    "material",
    [
        {"base_color": COLOR},
        pytest.param(
            {"transmission_weight": 1.0, "transmission_color": GREEN, "geometry_thin_walled": True},
            marks=pytest.mark.slow,
        ),
    ],
    ids=["base", "pane"],
)
def test_a_colour_has_the_same_picture_in_all_variants(few_paths, material):
    """Along the normal: elsewhere paths in panes differ, of which colours are powers.

    Coated ones are compared with the walk by `tests.mitsuba.plugins.test_spectral`.
    """
    found = in_variants(lambda: in_white_world(loaded(**material), aside=0.0))
    rgb = found["llvm_ad_rgb"]
    luminance = rgb @ [0.2126, 0.7152, 0.0722]
    assert found["llvm_ad_mono"][0] == pytest.approx(luminance, rel=0.01)
    np.testing.assert_allclose(found["llvm_ad_spectral"], rgb, rtol=0.02)


@pytest.mark.parametrize("depth", [0.0, 0.7])
def test_light_through_tinted_glass_has_the_same_colour_in_spectral_variants(spectral, depth):
    """Light crosses the surface of a body twice, or transmission_depth of its medium; the spectra
    have nodes every 2 nm."""
    nm = np.arange(360, 832, 1.0)
    glass = {"transmission_weight": 1.0, "transmission_color": GREEN, "transmission_depth": depth}
    si = dr.zeros(mi.MediumInteraction3f if depth else mi.SurfaceInteraction3f, len(nm) // 4)
    si.wavelengths = mi.Spectrum(nm.reshape(-1, 4).T)
    si.wi = mi.Vector3f(0, 0, 1)
    if depth:
        medium = mi.load_dict(urushi.openpbr(**glass).on({"type": "sphere"})).interior_medium()
        found = np.exp(-depth * medium.get_scattering_coefficients(si)[2].numpy())
    else:
        inputs = Inputs.of(glass, "openpbr")
        found = tint_of(inputs, inputs.at(si, mi.Bool(True))).numpy() ** 2
    expected = np.array(GREEN) ** (1 if depth else 2)
    np.testing.assert_allclose(found.T.ravel() @ srgb_weights(nm), expected, atol=1e-3)
