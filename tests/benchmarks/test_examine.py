"""The report on an encoded material states its errors."""

import json

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="the extra 'eval' is not installed")
from benchmarks.quality import examine
from benchmarks.quality.examine import ALBEDO_ANGLES, INCIDENT, OUTGOING
from benchmarks.quality.pictures import BEST_PSNR
from tests.untrained import untrained

from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import stack_error
from urushi.errors import ParameterError
from urushi.material import Material, encode
from urushi.nets import lobe
from urushi.walk import coat, conductor, diffuse, simulate
from urushi.walk.simulate import albedo

pytestmark = pytest.mark.usefixtures("small_spheres")


@pytest.fixture(scope="module")
def material():
    """Of three unlike channels, by smooth random functions."""
    model = untrained(2)
    rng, top = np.random.default_rng(0), lobe.of_coat(np.array([0.1, 0.2, 0.4]), np.full(3, 1.5))
    rest = rng.normal(size=(3, model.arch.rest))
    return Material(np.concatenate([top, rest], axis=1, dtype=np.float32), model)


@pytest.fixture(scope="module")
def itself(material, small_spheres):
    return examine.examine(material, material)


def test_a_material_is_exactly_like_itself(itself):
    figures = itself.figures
    assert figures["E"] == figures["P median"] == [0, 0, 0]
    assert figures["anisotropy"] == figures["reciprocity"] == figures["transmitted"] == 0
    assert figures["albedo"]["source"] == figures["albedo"]["material"]
    assert figures["sphere"]["psnr"] == BEST_PSNR
    assert np.array_equal(*itself.slices) and np.array_equal(*itself.pictures)
    json.dumps(figures)  # all values are JSON values


def test_errors_are_those_that_were_made(material):
    factors = np.array([1.25, 0.5, 0.0])
    found = examine.examine(lambda wi, wo: material.f(wi, wo) * factors, material)
    # |f - k f| / k f; there is no relative error where the source is black.
    assert found.figures["E"][:2] == pytest.approx([0.2, 1.0], rel=1e-5)
    assert found.figures["E"][2] is None
    assert examine.mean_error(found.figures) == pytest.approx(0.6, rel=1e-5)
    albedo = found.figures["albedo"]
    np.testing.assert_allclose(albedo["source"], factors * albedo["material"], rtol=1e-5)
    np.testing.assert_allclose(found.slices[0], factors * found.slices[1], rtol=1e-5)
    difference = found.pictures[0] - found.pictures[1] * factors
    np.testing.assert_allclose(difference, 0, atol=1e-5)


def test_a_slice_holds_the_mirror_direction_on_the_positive_side(material):
    rough = conductor(0.05, (0.9, 0.5, 0.2))
    slices = examine.examine(rough, material).slices
    assert slices.shape == (2, len(INCIDENT), len(OUTGOING), 3)
    brightest = OUTGOING[slices[0, :2, :, 0].argmax(axis=1)]
    np.testing.assert_allclose(brightest, INCIDENT[:2], atol=2)  # off-specular peaks are small


def test_albedo_of_a_lambertian_surface(material):
    figures = examine.examine(diffuse((0.2, 0.5, 0.8)), material).figures
    expected = np.tile([0.2, 0.5, 0.8], (len(ALBEDO_ANGLES), 1))
    # The rule leaves out only the energy below the first node.
    np.testing.assert_allclose(figures["albedo"]["source"], expected, rtol=2e-3)


@pytest.mark.slow
def test_asymmetry_is_apart_from_the_error(material, monkeypatch):
    monkeypatch.setattr("urushi.material.symmetry.AZIMUTHS", 6)  # enough for cos(2 phi)

    def brushed(wi, wo):
        """The material, brighter across than along: its mean over the azimuth is the material."""
        h = wi + wo
        h = h / np.linalg.norm(h, axis=1, keepdims=True)
        return material.f(wi, wo) * (1 + 0.8 * (h[:, :1] ** 2 - h[:, 1:2] ** 2))

    found = examine.examine(brushed, material)
    assert found.figures["anisotropy"] > 0.02
    assert found.figures["E"] == pytest.approx([0, 0, 0], abs=1e-5)
    np.testing.assert_allclose(*found.pictures, rtol=1e-4, atol=1e-6)  # both are isotropic


def test_simulated_stacks_can_be_examined(material, monkeypatch):
    monkeypatch.setattr(examine, "WALKS", 1 << 20)
    stack = coat(diffuse(0.5), alpha=0.3, eta=1.5, sigma_t=1.0, albedo=0.5)
    figures = examine.examine(stack, material).figures
    wi, wo = cosine_pairs(np.random.default_rng(5), 1000)
    f = simulate(stack, wi, wo, walks=256)[0]
    error = stack_error(material.f(wi, wo).T, f.T, wi[:, 2], wo[:, 2])
    np.testing.assert_allclose(figures["E"], error, rtol=0.1)  # of other pairs and other walks
    angles = np.radians(ALBEDO_ANGLES)
    up = np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=-1)
    expected = albedo(stack, up, walks=1 << 15)[0]
    np.testing.assert_allclose(figures["albedo"]["source"], expected, rtol=0.03)


def test_a_material_of_two_channels_is_refused(material):
    two = encode(lambda wi, wo: np.ones((len(wi), 2)), material.model)
    with pytest.raises(ParameterError, match="2 channels"):
        examine.examine(two, two)


def test_the_report_is_written(itself, tmp_path):
    examine.write_report(tmp_path / "new" / "report", {"a b": itself})
    folder = tmp_path / "new" / "report"
    assert sorted(file.name for file in folder.iterdir()) == ["a b.png", "report.json", "report.md"]
    assert json.loads((folder / "report.json").read_text())["a b"] == itself.figures
    text = (folder / "report.md").read_text()
    assert "| a b | 0.0% |" in text and "(<a b.png>)" in text
