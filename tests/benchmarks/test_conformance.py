"""Reference values of coated materials of OpenPBR, and errors against them."""

import numpy as np
import pytest
from benchmarks.quality import conformance

from urushi.errors import FileError, ParameterError


@pytest.fixture(scope="module")
def reference():
    return conformance.read()


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


def test_a_foreign_file_is_refused(tmp_path):
    (tmp_path / "x.safetensors").write_bytes(b"no")
    with pytest.raises(FileError, match="is not a valid conformance file"):
        conformance.read(tmp_path / "x.safetensors")


def test_a_rough_slab_below_total_reflection_has_bounded_values(rgb, reference):
    """The coat's index exceeds the base's: light at grazing in the coat does not gain energy."""
    f = conformance.model(reference.parameters["clay, clear"], walks=64)(reference.wi, reference.wo)
    assert np.pi * f.mean() < 0.8  # base_color is 0.38 in the mean; the rest is the coat's


def test_values_of_another_renderer_are_compared(tmp_path, capsys):
    """All 25 % too bright: every line has an E and an albedo's error of 25 %."""
    path = tmp_path / "mine.npz"
    np.savez(path, f=1.25 * conformance.read().f)
    conformance.main(["--values", str(path)])
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].split()[0] == "mine"
    assert len(lines) == 2 + 40 + 2
    assert all("25.00   +25.0" in line for line in lines[2:42])


def test_bad_files_get_one_sentence(tmp_path):
    np.savez(tmp_path / "other.npz", g=np.zeros(3))
    for name, message in (("none.npz", "does not exist"), ("other.npz", "must hold the array f")):
        with pytest.raises(FileError, match=message):
            conformance.main(["--values", str(tmp_path / name)])
