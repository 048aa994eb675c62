"""Reference values of coated materials of OpenPBR, and errors against them."""

import numpy as np
import pytest
from benchmarks import conformance

from urushi.errors import ParameterError


def test_wrong_values_are_refused():
    reference = conformance.read()
    with pytest.raises(ParameterError, match="give one of \\(40, 300, 3\\)"):
        conformance.errors(reference.f[:3], reference)
    with pytest.raises(ParameterError, match="must be finite"):
        conformance.errors(np.full(reference.f.shape, np.nan), reference)


def test_values_of_another_renderer_are_compared(tmp_path, capsys):
    """All 25 % too bright: every line has an E and an albedo's error of 25 %."""
    path = tmp_path / "mine.npz"
    np.savez(path, f=1.25 * conformance.read().f)
    conformance.main(["--values", str(path)])
    lines = capsys.readouterr().out.splitlines()
    assert " mine " in lines[0] and len(lines) == 2 + 40 + 2
    assert all("| 25.00 / +25.0 |" in line for line in lines[2:42])
