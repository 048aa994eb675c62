"""`urushi openpbr-check` with the values of another renderer."""

import numpy as np

from urushi.app.cli import main
from urushi.openpbr_surface import conformance


def test_values_of_another_renderer_are_compared(tmp_path, capsys):
    """All 25 % too bright: every line has an E and an albedo's error of 25 %."""
    path = tmp_path / "mine.npz"
    np.savez(path, f=1.25 * conformance.read().f)
    assert main(["openpbr-check", "--values", str(path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].split()[0] == "mine"
    assert len(lines) == 2 + 40 + 2
    assert all("25.00   +25.0" in line for line in lines[2:42])


def test_bad_files_get_one_sentence(tmp_path, capsys):
    np.savez(tmp_path / "other.npz", g=np.zeros(3))
    for name, message in (("none.npz", "does not exist"), ("other.npz", "must hold the array f")):
        assert main(["openpbr-check", "--values", str(tmp_path / name)]) == 2
        error = capsys.readouterr().err
        assert message in error and error.count("\n") == 1
