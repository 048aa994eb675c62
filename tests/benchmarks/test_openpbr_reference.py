"""The maker of OpenPBR's reference values: the shipped file is its, and a stopped run continues."""

import numpy as np
import pytest
from benchmarks.quality import conformance, openpbr_reference


@pytest.fixture(scope="module")
def reference():
    return conformance.read()


def test_the_shipped_file_has_the_materials_and_pairs(reference):
    assert list(reference.parameters) == list(openpbr_reference.MATERIALS)
    assert len(reference.parameters) == 40
    for name, parameters in reference.parameters.items():
        known = openpbr_reference.MATERIALS[name]
        assert parameters == {k: list(v) if isinstance(v, tuple) else v for k, v in known.items()}
    for stored, drawn in zip((reference.wi, reference.wo), openpbr_reference.pairs(), strict=True):
        assert np.array_equal(stored, drawn)
    assert conformance.default_path().stat().st_size < 1e6


def test_new_walks_agree_with_the_shipped_ones(reference):
    """Normalised differences of two independent estimates have a standard deviation of one.

    512 walks: a standard error of few walks is itself uncertain, and tails are not normal, so that
    the root mean square may be between 0.8 and 1.3.
    """
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("llvm_ad_rgb")
    index = list(reference.parameters).index("white paint, varnish")
    parameters = reference.parameters["white paint, varnish"]
    f, se = openpbr_reference.simulate(parameters, walks=512, rounds=1)
    z = (f - reference.f[index]) / np.hypot(se, reference.se[index])
    assert 0.8 < np.sqrt((z**2).mean()) < 1.3


def test_a_file_is_continued(tmp_path, monkeypatch):
    """What is there is kept to the bit; a material of other parameters is made again."""
    path, calls = tmp_path / "reference.safetensors", []

    def simulate(parameters):
        calls.append(parameters)
        value = np.full((conformance.PAIRS, 3), len(calls), np.float32)
        return value, np.zeros_like(value)

    monkeypatch.setattr(openpbr_reference, "simulate", simulate)
    some = dict(list(openpbr_reference.MATERIALS.items())[:3])
    monkeypatch.setattr(openpbr_reference, "MATERIALS", some)
    openpbr_reference.make(path, lambda _: None)
    assert len(calls) == 3
    changed = some | {next(iter(some)): {"coat_weight": 0.25}}
    monkeypatch.setattr(openpbr_reference, "MATERIALS", changed)
    openpbr_reference.make(path, lambda _: None)
    assert calls[3:] == [{"coat_weight": 0.25}]
    assert conformance.read(path).f[:, 0, 0].tolist() == [4, 2, 3]
