"""Damaged, foreign and inconsistent files: one error sentence each, and bounded memory."""

import os
import tracemalloc

import numpy as np
import pytest
from tests.fuzzing import fuzz
from tests.measured import writers

from urushi.errors import FileError, ParameterError
from urushi.measured import Merl, Rgl, load_measured

BINS = 90 * 90 * 180
HUGE = 1 << 30


def merl_header(*dimensions):
    return np.array(dimensions, "<i4").tobytes()


@pytest.fixture(scope="module")
def fields():
    return writers.rgl_fields(np.random.default_rng(0))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", r"\(0 bytes\) is neither a MERL table .* nor an RGL tensor file"),
        (b"BRDF, I swear", r"\(13 bytes\) is neither"),
        (b"\n<!DOCTYPE html><html>404</html>", "is a web page"),
        (b"<html><body>Not found</body></html>", "is a web page"),
        (b"<?xml version='1.0'?><materialx/>", "is an XML file, .* urushi convert reads MaterialX"),
        (merl_header(90, 90, 360) + bytes(80), "has dimensions 90 x 90 x 360"),
        (merl_header(90, 90, -180) + bytes(80), "has dimensions 90 x 90 x -180"),
        (merl_header(2**31 - 1, 1, 1) + bytes(80), "is neither"),
        (merl_header(90, 90, 180), r"is truncated \(12 bytes, not 34992012\)"),
        (b"tensor_file\0", "its header is truncated"),
        (b"tensor_file\0\2\0\0\0\0\0", "has version 2.0"),
        (b"tensor_file\0\1\0\xff\xff\xff\xff", "claims 4294967295 fields"),
        (b"tensor_file\0\1\0\0\0\0\0", "has no tensor 'description'"),
        (b"tensor_file\0\1\0\1\0\0\0\xff\xffshort", "its header is truncated"),
    ],
)
def test_a_bad_beginning_gets_one_sentence(tmp_path, content, message):
    path = tmp_path / "any.binary"
    path.write_bytes(content)
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
        ({"rgb": (None, 12, None)}, "'rgb' has the unknown type 12"),
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
    with pytest.raises(FileError, match=message):
        bounded(path, 1 << 20)


def test_a_tensor_named_twice_is_refused(fields, tmp_path):
    path = tmp_path / "twice.bsdf"
    content = writers.tensor_file(dict(fields, phi_j=fields["phi_i"]))
    path.write_bytes(content.replace(b"phi_j", b"phi_i"))
    with pytest.raises(FileError, match="two of its tensors have the name 'phi_i'"):
        load_measured(path)


def bounded(path, memory):
    """Load a file within this number of bytes."""
    tracemalloc.start()
    try:
        load_measured(path)
    finally:
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < memory


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"rgb": None}, "no tensor 'wavelengths'|no tensor 'spectra'"),
        ({"vndf": None}, "no tensor 'vndf'"),
        ({"rgb": np.nan}, "'rgb' has numbers that are not finite"),
        ({"ndf": np.inf}, "'ndf' has numbers that are not finite"),
        ({"sigma": 0}, "'sigma', a projected area, is not positive"),
        ({"ndf": -1}, "'ndf', a density, is negative"),
        ({"vndf": 0}, "'vndf' has no density at all"),
        ({"theta_i": 1}, "'theta_i' does not increase"),
        ({"phi_i": np.zeros(8, np.float32)}, "shapes of its tensors do not match"),
        ({"sigma": np.arange(1, 17, dtype=np.float32).reshape(2, 8)}, "depends on the azimuth"),
        ({"spectra": np.ones((1, 4, 3, 8, 8), np.float32)}, "no tensor 'wavelengths'"),
    ],
)
def test_tensors_out_of_range_get_one_sentence(fields, changed, message):
    wrong = dict(fields)
    for name, value in changed.items():
        wrong[name] = np.full_like(wrong[name], value) if np.isscalar(value) else value
    with pytest.raises(FileError, match=message):
        Rgl({name: value for name, value in wrong.items() if value is not None})


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"azimuths": np.zeros(5)}, "'phi_i' does not increase"),
        ({"wavelengths": [500.0, 400.0]}, "'wavelengths' does not increase"),
        ({"wavelengths": [800.0, 900.0]}, "wavelengths, 800 to 900 nm, are outside the visible"),
        ({"wavelengths": [np.nan, 500.0]}, "'wavelengths' has numbers that are not finite"),
    ],
)
def test_nodes_must_increase_and_be_visible(how, message):
    with pytest.raises(FileError, match=message):
        Rgl(writers.rgl_fields(np.random.default_rng(0), **how))


@pytest.mark.parametrize(
    ("number", "message"),
    [
        (np.nan, "has 1458000 bins that are not finite"),
        (np.inf, "not finite"),
        (1e300, "not finite"),  # beyond float32
        (-1.0, "has no valid bin: above the horizon, each has a negative channel"),
    ],
)
def test_tables_without_numbers_are_refused(tmp_path, number, message):
    path = writers.write_merl(tmp_path / "bad", np.full((BINS, 3), number))
    with pytest.raises(FileError, match=message):
        load_measured(path)
    path.unlink()  # 35 MB


@pytest.mark.parametrize(
    ("header", "more", "message"),
    [
        ((90, 90, 180), 1, "is too long"),
        ((180, 90, 90), 0, "has dimensions 180 x 90 x 90"),
    ],
)
def test_sizes_are_exact(tmp_path, header, more, message):
    path = tmp_path / "any.binary"
    path.write_bytes(merl_header(*header))
    os.truncate(path, 12 + 24 * BINS + more)
    with pytest.raises(FileError, match=message):
        load_measured(path)
    with pytest.raises(FileError, match=r"has shape \(90, 90, 180, 3\), not \(2,\)"):
        Merl([1, 2])


def test_the_largest_numbers_stay_finite(fields, random_directions):
    largest = np.finfo(np.float32).max
    wi, wo = random_directions(1000, 1), random_directions(1000, 2)
    signs = np.random.default_rng(3).choice(np.float32([-1, 0, 1]), (90, 90, 180, 3))
    brdfs = [Merl(signs * largest)]
    brdfs.append(Rgl(dict(fields, **{n: fields[n] * 0 + largest for n in ("ndf", "rgb", "vndf")})))
    for brdf in brdfs:
        f = brdf.f(wi, wo)
        assert np.isfinite(f).all() and (f >= 0).all()


def test_memory_is_in_proportion_to_the_file(tmp_path):
    path = tmp_path / "large.bsdf"
    large = writers.rgl_fields(np.random.default_rng(1), size=64, elevations=16)
    path.write_bytes(writers.tensor_file(large))
    # The integrals of the densities are in float64: a few times the file's size.
    bounded(path, 10 * path.stat().st_size)


def test_paths_that_are_not_files(tmp_path):
    with pytest.raises(FileError, match="there is no file '.*missing'; check the path"):
        load_measured(tmp_path / "missing")
    with pytest.raises(FileError, match="cannot read"):
        load_measured(tmp_path)
    for path in (5, "a\0b"):
        with pytest.raises(ParameterError, match="path must be the path of a file, not "):
            load_measured(path)


def test_directions_are_checked(fields):
    brdf = Rgl(fields)
    with pytest.raises(ParameterError, match="unit vector"):
        brdf.f([[0, 0, 2]], [[0, 0, 1]])
    with pytest.raises(ParameterError, match="same number"):
        brdf.f([[0, 0, 1]], [[0, 0, 1], [0, 0, 1]])


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
