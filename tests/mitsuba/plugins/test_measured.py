"""Values and colours of the plugin `measured_brdf`, and spectra of its files."""

import numpy as np
import pytest
from tests.directions import pairs_above
from tests.measured import writers
from tests.mitsuba.probes import f

import urushi
from urushi.measured import rgl
from urushi.measured.rgl import srgb_weights


def test_values_are_those_of_the_reader(rgb, merl_file):
    wi, wo = pairs_above(2000, 0, 0.1)
    bsdf = rgb.load_dict({"type": "measured_brdf", "filename": str(merl_file)})
    expected = urushi.load_measured(merl_file).f(wi, wo)
    np.testing.assert_allclose(f(bsdf, wi, wo), expected, rtol=1e-3)


@pytest.fixture
def ggx_file(tmp_path, monkeypatch):
    """Writes an RGL file of a rough GGX conductor of Schlick's reflectances (channels,)."""
    monkeypatch.setattr(rgl, "TABLE_SHAPE", (64, 64, 16))  # enough for a wide lobe

    def write(r0, **options):
        fields = writers.rgl_ggx_fields(0.5, r0, size=32, elevations=12, **options)
        for name in ("vndf", "luminance"):  # Mitsuba wants the size of the measured values
            fields[name] = np.ones((1, 12, 32, 32), np.float32)
        path = tmp_path / "ggx.bsdf"
        path.write_bytes(writers.tensor_file(fields))
        return str(path)

    return write


def f_at(mi, bsdf, wi, wo, nm):
    """f (N, W) [1/sr] at wavelengths, a multiple of four."""
    pairs, groups = len(wi), len(nm) // 4
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(np.repeat(wi, groups, axis=0).T)
    si.wavelengths = mi.Spectrum(np.tile(np.reshape(nm, (groups, 4)).T, (1, pairs)))
    out = np.repeat(wo, groups, axis=0)
    f_cos = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(out.T)).numpy()
    return (f_cos / out[:, 2]).T.reshape(pairs, -1)


def test_a_spectral_file_has_its_own_spectra(spectral, ggx_file):
    """Those of Mitsuba's plugin `measured`, averaged over the exchange of wi and wo.

    1 %: the table of 64 x 64 x 16 bins, away from grazing angles.
    """
    nm, (wi, wo) = np.linspace(380, 780, 41), pairs_above(600, 2, 0.1)
    wi, wo = (w[(wi[:, 2] > 0.3) & (wo[:, 2] > 0.3)] for w in (wi, wo))
    narrow = 0.1 + 0.6 * np.exp(-(((nm - 560) / 25) ** 2))  # as of no colour of three channels
    path = ggx_file(narrow, wavelengths=nm)
    ours, theirs = (
        spectral.load_dict({"type": x, "filename": path}) for x in ("measured_brdf", "measured")
    )
    ours = f_at(spectral, ours, wi, wo, nm[:40])
    theirs = sum(f_at(spectral, theirs, *w, nm[:40]) for w in ((wi, wo), (wo, wi))) / 2
    np.testing.assert_allclose(ours.sum(axis=0), theirs.sum(axis=0), rtol=0.01)
    assert np.abs(ours - theirs).sum() < 0.03 * theirs.sum()


@pytest.mark.parametrize("plugin", ["measured_brdf", "neural_brdf"])
def test_colours_of_a_file_are_the_same_in_spectral_variants(spectral, ggx_file, tmp_path, plugin):
    """The colour of the spectra under D65 is the file's; 0.2 %: the sum over 2 nm."""
    wi, wo = pairs_above(100, 3, 0.1)
    if plugin == "measured_brdf":
        path = ggx_file((0.9, 0.1, 0.02))
        expected = urushi.load_measured(path).tabulated.f_pdf
        channels, _ = expected(spectral.Vector3f(wi.T), spectral.Vector3f(wo.T))
        expected = channels.numpy().T
    else:
        material = urushi.encode(urushi.conductor(alpha=0.5, r0=(0.9, 0.1, 0.02)))
        path = str(tmp_path / "red.safetensors")
        material.save(path)
        expected = material.f(wi, wo)
    nm = np.arange(362, 830, 2.0)[:232]
    bsdf = spectral.load_dict({"type": plugin, "filename": path})
    found = f_at(spectral, bsdf, wi, wo, nm) @ srgb_weights(nm)
    np.testing.assert_allclose(found.mean(axis=0), expected.mean(axis=0), rtol=2e-3, atol=1e-4)
