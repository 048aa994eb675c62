"""Reference values of coated materials of OpenPBR, and errors against them."""

import numpy as np
import pytest

from urushi.errors import FileError, ParameterError
from urushi.openpbr_surface import conformance


@pytest.fixture(scope="module")
def reference():
    return conformance.read()


def test_the_shipped_file_has_the_materials_and_pairs(reference):
    assert list(reference.parameters) == list(conformance.MATERIALS)
    assert len(reference.parameters) == 40
    for name, parameters in reference.parameters.items():
        known = conformance.MATERIALS[name]
        assert parameters == {k: list(v) if isinstance(v, tuple) else v for k, v in known.items()}
    for stored, drawn in zip((reference.wi, reference.wo), conformance.pairs(), strict=True):
        assert np.array_equal(stored, drawn)
    assert conformance.default_path().stat().st_size < 1e6


def test_the_shipped_values_have_the_noise_that_the_page_states(reference):
    assert (reference.f > 0).all() and (reference.se >= 0).all()
    assert conformance.noise(reference).max() < 0.006


def test_errors_of_scaled_values(reference):
    """All values 10 % too bright: E is 0.1, and the albedo's error as well."""
    errors = conformance.errors(1.1 * reference.f, reference)
    assert np.allclose(errors.error, 0.1, atol=1e-6) and np.allclose(errors.albedo, 0.1, atol=1e-6)


def test_the_albedo_is_that_of_even_light(reference):
    """A white Lambertian surface in place of all: pi mean(f) is its albedo, one."""
    white = np.full(reference.f.shape, 1 / np.pi)
    albedo = 1 / (np.pi * reference.f.mean(1, dtype=np.float64)) - 1
    assert np.allclose(conformance.errors(white, reference).albedo, albedo.mean(1))
    # No material reflects more light than it receives. The mean of 300 pairs has a few per cent
    # of error, more for sharp lobes.
    assert (np.pi * reference.f.mean(1) < 1.15).all()


def test_wrong_values_are_refused(reference):
    with pytest.raises(ParameterError, match="give one of \\(40, 300, 3\\)"):
        conformance.errors(reference.f[:3], reference)
    with pytest.raises(ParameterError, match="must be finite"):
        conformance.errors(np.full(reference.f.shape, np.nan), reference)


def test_new_walks_agree_with_the_shipped_ones(reference):
    """Normalised differences of two independent estimates have a standard deviation of one.

    512 walks: a standard error of few walks is itself uncertain, and tails are not normal, so that
    the root mean square may be between 0.8 and 1.3.
    """
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("llvm_ad_rgb")
    index = list(reference.parameters).index("white paint, varnish")
    parameters = reference.parameters["white paint, varnish"]
    f, se = conformance.simulate(parameters, walks=512, rounds=1)
    z = (f - reference.f[index]) / np.hypot(se, reference.se[index])
    assert 0.8 < np.sqrt((z**2).mean()) < 1.3


def test_a_file_is_continued(tmp_path, monkeypatch):
    """What is there is kept to the bit; a material of other parameters is made again."""
    path, calls = tmp_path / "reference.safetensors", []

    def simulate(parameters):
        calls.append(parameters)
        value = np.full((conformance.PAIRS, 3), len(calls), np.float32)
        return value, np.zeros_like(value)

    monkeypatch.setattr(conformance, "simulate", simulate)
    some = dict(list(conformance.MATERIALS.items())[:3])
    monkeypatch.setattr(conformance, "MATERIALS", some)
    conformance.make(path, lambda _: None)
    assert len(calls) == 3
    changed = some | {next(iter(some)): {"coat_weight": 0.25}}
    monkeypatch.setattr(conformance, "MATERIALS", changed)
    conformance.make(path, lambda _: None)
    assert calls[3:] == [{"coat_weight": 0.25}]
    assert conformance.read(path).f[:, 0, 0].tolist() == [4, 2, 3]


def test_a_foreign_file_is_refused(tmp_path):
    (tmp_path / "x.safetensors").write_bytes(b"no")
    with pytest.raises(FileError, match="is not a valid conformance file"):
        conformance.read(tmp_path / "x.safetensors")


def test_a_rough_slab_below_total_reflection_has_bounded_values():
    """The coat's index exceeds the base's: light at grazing in the coat does not gain energy."""
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("llvm_ad_rgb")
    wi, wo = conformance.pairs()
    f = conformance.model(conformance.MATERIALS["clay, clear"], walks=64)(wi, wo)
    assert np.pi * f.mean() < 0.8  # base_color is 0.38 in the mean; the rest is the coat's
