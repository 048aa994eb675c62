"""The doctor finds what is wrong, returns it in its exit code, and survives crashes."""

import os
import re
import subprocess
import sys

import pytest

from urushi import platform
from urushi.app import doctor
from urushi.app.doctor import Doctor, Finding


@pytest.mark.parametrize(
    ("findings", "code", "closing"),
    [
        ([Finding("LLVM", "19", None, True)], 0, "All essential parts work."),
        ([Finding("GPU", "none", "no driver")], 0, "All essential parts work."),
        ([Finding("LLVM", "14", "too old", True)], 1, "Problems: LLVM."),
    ],
)
def test_the_exit_code_states_the_result(monkeypatch, capsys, findings, code, closing):
    monkeypatch.setattr(doctor, "examine", lambda: findings)
    assert Doctor().run() == code
    text = capsys.readouterr().out
    assert text.rstrip().endswith(closing)
    for finding in findings:
        assert finding.found in text
        assert finding.problem is None or finding.problem in text


def test_packages_are_judged_by_their_range(monkeypatch):
    """Missing optional ones are notes with their purpose and cure."""
    assert "pip install" in doctor._package("a-package-that-nobody-has").problem
    monkeypatch.setattr(doctor, "_version", lambda name: None)
    missing = {finding.name: finding for finding in doctor._extras()}["extra materialx: materialx"]
    assert missing.found == "missing (MaterialX documents)"
    assert "pip install 'materialx" in missing.problem and not missing.essential
    monkeypatch.undo()
    monkeypatch.setattr("importlib.metadata.version", lambda name: "3.10.0")
    finding = doctor._package("mitsuba", (3, 9), (3, 10))
    assert finding.essential
    assert "pip install 'mitsuba>=3.9,<3.10'" in finding.problem
    monkeypatch.setattr("importlib.metadata.version", lambda name: "3.9.12")
    assert doctor._package("mitsuba", (3, 9), (3, 10)).problem is None


def test_a_variant_that_kills_its_process(monkeypatch):
    monkeypatch.setattr(doctor, "_PROBE", "import os; os.abort()")
    finding = doctor._variant("llvm_ad_rgb")
    assert finding.found == "not usable"
    assert finding.problem
    assert finding.essential


def test_weights_that_are_missing_or_cannot_be_read(monkeypatch, tmp_path):
    monkeypatch.setattr("urushi.nets.weights.SHIPPED", tmp_path)
    (finding,) = doctor._weights()
    assert finding.found == "missing" and finding.essential
    (tmp_path / "broken.safetensors").write_bytes(b"no weights")
    (finding,) = doctor._weights()
    assert finding.name == "weights broken" and finding.essential
    assert "broken.safetensors" in finding.problem


def test_everything_is_examined_even_without_a_library():
    """Without any libLLVM the doctor still runs, and names it."""
    run = subprocess.run(
        [sys.executable, "-m", "urushi.app.cli", "doctor"],
        env={**os.environ, platform.LLVM_VARIABLE: "/nowhere/libLLVM.so"},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert run.returncode == 1, run.stderr
    assert "'/nowhere/libLLVM.so' is missing" in run.stdout
    assert "Problems: LLVM, variant llvm_ad_rgb" in run.stdout
    extras = (f"extra {e}: {p.name}" for e, packages in platform.EXTRAS.items() for p in packages)
    for name in (
        *["Python", "mitsuba", "drjit", "LLVM", "GPU", "weights"],
        "variant scalar_rgb",
        *extras,
    ):
        assert re.search(rf"^{re.escape(name)}\b", run.stdout, re.MULTILINE), name
