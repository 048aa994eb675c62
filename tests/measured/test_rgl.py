"""RGL materials: parity with Mitsuba's own plugin, isotropy, near reciprocity, colour."""

from functools import partial

import numpy as np
import pytest
from tests.directions import above
from tests.measured import writers

import urushi
from urushi.errors import ParameterError
from urushi.measured import Rgl, load_measured
from urushi.measured.rgl import MIN_COSINE, srgb_weights
from urushi.measured.tabulated import evaluate, interpolated


@pytest.fixture(params=["aurora_white", "chm_mint", "irid_flake_paint1", "vch_silk_blue"])
def material(request, stored):
    return stored(f"data/rgl/{request.param}_rgb.bsdf")


def mitsuba_f_cos(path, wi, wo, wavelengths=None):
    """Evaluate Mitsuba's plugin `measured`; (N, channels)."""
    import mitsuba as mi

    bsdf = mi.load_dict({"type": "measured", "filename": str(path)})
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(*wi.T)
    if wavelengths is not None:
        si.wavelengths = mi.Spectrum(*wavelengths)
    return np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(*wo.T))).T


def in_channels(brdf, wi, wo):
    """f in the channels of the file, before they become a colour."""
    lookup = partial(brdf._interpolated, brdf._measured)
    return evaluate(lookup, brdf._measured.shape[-1], wi, wo)


def assert_close(f, wo, expected):
    """Compare f cos theta_o, where the cosine is not clamped."""
    cosine = wo[:, 2:]
    ours, expected = (a[cosine[:, 0] > MIN_COSINE] for a in (f * cosine, expected))
    # Mitsuba computes in float32: its warps are known to about 1e-6 of the square, in which the
    # mirror-like materials vary by their full range over a 32nd: by up to 1e-2 on a cell's border.
    atol = 1e-5 * np.abs(expected).mean()
    np.testing.assert_allclose(ours, expected, rtol=1e-2, atol=atol)
    assert np.abs(ours - expected).sum() < 1e-4 * np.abs(expected).sum()


def test_rgb_agrees_with_mitsuba(rgb, material):
    wi, wo = above(5000, 1), above(5000, 2)
    brdf = load_measured(material)
    assert_close(in_channels(brdf, wi, wo), wo, mitsuba_f_cos(material, wi, wo))


@pytest.mark.parametrize("turn", [None, 1.0, 0.5, 0.25])
def test_spectra_agree_with_mitsuba(spectral, tmp_path, turn):
    """Of isotropic materials, and of those of a whole turn of wi, half of one, and a quarter.

    Their colours are the spectra's; negative channels are zero.
    """
    nm = [400.0, 450.0, 520.0, 650.0]
    path = tmp_path / "made_up.bsdf"
    measured = {} if turn is None else {"azimuths": np.linspace(-np.pi, (2 * turn - 1) * np.pi, 7)}
    fields = writers.rgl_fields(np.random.default_rng(6), wavelengths=nm, **measured)
    path.write_bytes(writers.tensor_file(fields))
    brdf = load_measured(path)
    assert list(brdf.wavelengths) == nm and brdf.isotropic == (turn is None)
    wi, wo = above(4000, 7), above(4000, 8)
    spectra = in_channels(brdf, wi, wo)
    assert_close(spectra, wo, mitsuba_f_cos(path, wi, wo, nm))
    expected = np.maximum(spectra @ srgb_weights(brdf.wavelengths), 0)
    np.testing.assert_allclose(brdf.f(wi, wo), expected, rtol=1e-5, atol=1e-6)


@pytest.mark.filterwarnings("ignore:encode Rgl")  # made-up values are not reciprocal
def test_an_anisotropic_file_is_encoded_by_its_networks(tmp_path):
    for azimuths, widths in ((np.linspace(-np.pi, -np.pi / 2, 6), 2), (None, 1)):
        fields = writers.rgl_fields(np.random.default_rng(0), azimuths=azimuths)
        path = tmp_path / "made_up.bsdf"
        path.write_bytes(writers.tensor_file(fields))
        assert urushi.encode(load_measured(path)).model.widths == widths


def test_the_walk_takes_isotropic_materials():
    fields = writers.rgl_fields(np.random.default_rng(0), azimuths=np.linspace(-3, 0, 5))
    with pytest.raises(ParameterError, match="put Mitsuba's 'measured' under the coat"):
        Rgl(fields).table()


def test_the_walks_table_is_the_mean_over_the_exchange(stored):
    material = load_measured(stored("data/rgl/chm_mint_rgb.bsdf"))
    wi, wo = above(4000, 9, 0.1), above(4000, 10, 0.1)
    expected = 0.5 * (material.f(wi, wo) + material.f(wo, wi))
    f = interpolated(material.table(), wi.astype(float), wo.astype(float))
    weight = (wi[:, 2] * wo[:, 2])[:, None]
    # Files have few elevations with linear interpolation between; the table smooths the kinks.
    assert (np.abs(f - expected) * weight).sum() < 0.02 * (expected * weight).sum()


def test_f_is_finite_not_negative_and_isotropic(material):
    brdf = load_measured(material)
    wi, wo = above(2000, 6, 0.02), above(2000, 7, 0.02)
    f = brdf.f(wi, wo)
    assert f.dtype == np.float32
    assert np.isfinite(f).all() and (f >= 0).all()
    turn = np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]])
    # Rounding of the turned float32 directions, in the steepest places (see `assert_close`).
    np.testing.assert_allclose(brdf.f(wi @ turn, wo @ turn), f, rtol=1e-2, atol=1e-3 * f.mean())
    # Along the normal, whatever the signs of zeros: in a file, values vary with the azimuth.
    normals = np.tile([[0.0, 0, 1], [-0.0, 0, 1], [0, -0.0, 1], [-0.0, -0.0, 1]], (16, 1))
    along = brdf.f(normals, np.repeat(wo[:16], 4, axis=0)).reshape(16, 4, 3)
    np.testing.assert_array_equal(along, np.broadcast_to(along[:, :1], along.shape))


def test_spectra_are_converted_by_the_cie_observer_under_d65(rgb):
    """Mitsuba's observer and light, at every nanometre."""
    rgb.set_variant("scalar_spectral")
    nm = np.arange(360.0, 831.0)
    spectra = 0.4 + 0.3 * np.sin(np.outer([1, 2, 3, 4], nm / 60))
    d65, si = rgb.load_dict({"type": "d65"}), rgb.SurfaceInteraction3f()
    light = np.zeros(len(nm))
    for i, wavelength in enumerate(nm):
        si.wavelengths = [wavelength] * 4
        light[i] = d65.eval(si)[0]
    observer = np.array([rgb.cie1931_xyz(float(x)) for x in nm])
    xyz = (spectra * light) @ observer / (light @ observer[:, 1])
    expected = [rgb.xyz_to_srgb(rgb.Color3f(*row)) for row in xyz]
    # Tables every 5 nm on both sides; the matrix has four digits, and its white is off by 1e-3.
    np.testing.assert_allclose(spectra @ srgb_weights(nm), expected, atol=3e-3)
    nm = np.linspace(360, 1000, 30)  # also beyond visible light; a constant spectrum is neutral
    np.testing.assert_allclose(srgb_weights(nm).sum(0), 1, rtol=1e-12)
    np.testing.assert_allclose(srgb_weights(nm)[nm > 820], 0)
