"""Damaged, foreign and inconsistent files: one error sentence each, and bounded memory."""

import os

import numpy as np
import pytest
from tests.directions import above
from tests.fuzzing import bounded, fuzz
from tests.measured import writers

from urushi.errors import FileError, ParameterError
from urushi.measured import Merl, Rgl, load_measured

BINS = 90 * 90 * 180
HUGE = 1 << 30
TWICE = writers.tensor_file({"phi_i": np.ones(2), "phi_j": np.ones(2)}).replace(b"phi_j", b"phi_i")


def merl_header(*dimensions):
    return np.array(dimensions, "<i4").tobytes()


@pytest.fixture(scope="module")
def fields():
    return writers.rgl_fields(np.random.default_rng(0))


@pytest.mark.parametrize(
    ("content", "size", "message"),
    [
        (b"", 0, r"\(0 bytes\) is neither a MERL table .* nor an RGL tensor file"),
        (b"BRDF, I swear", 13, r"\(13 bytes\) is neither"),
        (b"\n<!DOCTYPE html><html>404</html>", 80, "is a web page"),
        (b"<html><body>Not found</body></html>", 80, "is a web page"),
        (b"<?xml version='1.0'?>", 80, "is an XML file, .* urushi convert reads MaterialX"),
        (merl_header(90, 90, 360), 92, "has dimensions 90 x 90 x 360"),
        (merl_header(90, 90, -180), 92, "has dimensions 90 x 90 x -180"),
        (merl_header(180, 90, 90), 12 + 24 * BINS, "has dimensions 180 x 90 x 90"),
        (merl_header(2**31 - 1, 1, 1), 92, "is neither"),
        (merl_header(90, 90, 180), 12, r"is truncated \(12 bytes, not 34992012\)"),
        (merl_header(90, 90, 180), 12 + 24 * BINS + 1, "is too long"),
        (b"tensor_file\0", 12, "its header is truncated"),
        (b"tensor_file\0\2\0", 19, "has version 2.0"),
        (b"tensor_file\0\1\0\xff\xff\xff\xff", 18, "claims 4294967295 fields"),
        (b"tensor_file\0\1\0", 19, "has no tensor 'description'"),
        (b"tensor_file\0\1\0\1\0\0\0\xff\xff", 25, "its header is truncated"),
        (TWICE, len(TWICE), "two of its tensors have the name 'phi_i'"),
    ],
)
def test_a_bad_beginning_or_size_gets_one_sentence(tmp_path, content, size, message):
    path = tmp_path / "any.binary"
    path.write_bytes(content)
    os.truncate(path, size)  # or zeros that follow
    with pytest.raises(FileError, match=message) as caught:
        load_measured(path)
    assert "any.binary" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("forged", "message"),
    [
        ({"rgb": ((1, 4, 3, HUGE, 1), None, None)}, "'rgb' ends at byte .*, outside the file"),
        ({"rgb": ((2**63, 2**63), None, None)}, "outside the file"),
        ({"rgb": (None, None, 2**64 - 1)}, "outside the file"),
        ({"vndf": (None, None, 20)}, "'vndf' overlaps the header"),
        ({"sigma": (None, None, 500)}, "overlaps"),
        ({"rgb": (None, 0, None)}, "'rgb' has the unknown type 0"),
        ({"rgb": (None, 9, None)}, "'rgb' is float16 of shape .* not float32 with 5 dimensions"),
        ({"rgb": ((1,) * 20, None, None)}, "claims 20 dimensions"),
        ({"rgb": ((0, 2**64 - 1), None, None)}, "'rgb' (has the|is float32 of) shape"),
        ({"theta_i": ((2, 2), None, None)}, "'theta_i' is float32 of shape"),
        ({"theta_i": ((3,), None, None)}, "shapes of its tensors do not match"),
        ({"ndf": ((1, 8), None, None)}, "shapes of its tensors do not match"),
        ({"jacobian": ((0,), None, None)}, "shapes of its tensors do not match"),
    ],
)
def test_an_inconsistent_tensor_header_gets_one_sentence(fields, tmp_path, forged, message):
    path = tmp_path / "lies.bsdf"
    path.write_bytes(writers.tensor_file(fields, forge=forged))
    with pytest.raises(FileError, match=message), bounded(1 << 20):
        load_measured(path)


@pytest.mark.parametrize(
    ("options", "changed", "message"),
    [
        ({}, {"rgb": None}, "no tensor 'wavelengths'|no tensor 'spectra'"),
        ({}, {"vndf": None}, "no tensor 'vndf'"),
        ({}, {"rgb": np.nan}, "'rgb' has numbers that are not finite"),
        ({}, {"sigma": 0}, "'sigma', a projected area, is not positive"),
        ({}, {"ndf": -1}, "'ndf', a density, is negative"),
        ({}, {"vndf": 0}, "'vndf' has no density at all"),
        ({}, {"theta_i": 1}, "'theta_i' does not increase"),
        ({}, {"phi_i": np.zeros(8, np.float32)}, "shapes of its tensors do not match"),
        ({}, {"sigma": np.float32(np.arange(1, 17)).reshape(2, 8)}, "depends on the azimuth"),
        ({}, {"spectra": np.ones((1, 4, 3, 8, 8), np.float32)}, "no tensor 'wavelengths'"),
        ({"azimuths": np.zeros(5)}, {}, "'phi_i' does not increase"),
        ({"wavelengths": [500.0, 400.0]}, {}, "'wavelengths' does not increase"),
        ({"wavelengths": [800.0, 900.0]}, {}, "800 to 900 nm, are outside the visible spectrum"),
    ],
)
def test_tensors_out_of_range_get_one_sentence(options, changed, message):
    wrong = writers.rgl_fields(np.random.default_rng(0), **options)
    for name, value in changed.items():
        wrong[name] = np.full_like(wrong[name], value) if np.isscalar(value) else value
    with pytest.raises(FileError, match=message):
        Rgl({name: value for name, value in wrong.items() if value is not None})


@pytest.mark.parametrize(
    ("number", "message"),
    [
        (np.nan, "has 1458000 bins that are not finite"),
        (1e300, "not finite"),  # beyond float32
        (-1.0, "has no valid bin: above the horizon, each has a negative channel"),
    ],
)
def test_tables_without_numbers_are_refused(tmp_path, number, message):
    path = writers.write_merl(tmp_path / "bad", np.full((BINS, 3), number))
    with pytest.raises(FileError, match=message):
        load_measured(path)
    path.unlink()  # 35 MB
    with pytest.raises(FileError, match=r"has shape \(90, 90, 180, 3\), not \(2,\)"):
        Merl([1, 2])


def test_the_largest_numbers_stay_finite(fields):
    largest = np.finfo(np.float32).max
    wi, wo = above(1000, 1), above(1000, 2)
    signs = np.random.default_rng(3).choice(np.float32([-1, 0, 1]), (90, 90, 180, 3))
    high = {name: fields[name] * 0 + largest for name in ("ndf", "rgb", "vndf")}
    for brdf in (Merl(signs * largest), Rgl(fields | high)):
        f = brdf.f(wi, wo)
        assert np.isfinite(f).all() and (f >= 0).all()


def test_memory_is_in_proportion_to_the_file(tmp_path):
    path = tmp_path / "large.bsdf"
    large = writers.rgl_fields(np.random.default_rng(1), size=64, elevations=16)
    path.write_bytes(writers.tensor_file(large))
    # The integrals of the densities are in float64: a few times the file's size.
    with bounded(10 * path.stat().st_size):
        load_measured(path)


def test_paths_that_are_not_files(tmp_path):
    with pytest.raises(FileError, match="there is no file '.*missing'; check the path"):
        load_measured(tmp_path / "missing")
    with pytest.raises(FileError, match="cannot read"):
        load_measured(tmp_path)
    with pytest.raises(ParameterError, match="path must be the path of a file, not "):
        load_measured(5)


def test_mutants_are_refused_in_one_sentence(tmp_path):
    """Cut anywhere, among others."""
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(2, 16, 3))
    directions[:, 0], directions[0, 1] = (0, 0, 1), directions[1, 1]
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)

    def read(path):
        f = load_measured(path).f(*directions)
        assert np.isfinite(f).all() and (f >= 0).all()

    fields = {"size": 2, "elevations": 2}
    seeds = [
        writers.tensor_file(writers.rgl_fields(rng, **fields)),
        writers.tensor_file(writers.rgl_fields(rng, wavelengths=[400, 500, 600], **fields)),
        merl_header(90, 90, 180) + bytes(24),
        b"<html></html>",
    ]
    assert 10 < fuzz(read, tmp_path / "mutant", seeds, 400, memory=1 << 20) < 400
