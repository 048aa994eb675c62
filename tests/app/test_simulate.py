"""`urushi simulate` prints and saves what `urushi.simulate` returns."""

import numpy as np
import pytest

import urushi
from urushi.app import cli, simulate
from urushi.app.describe import describe

COATED = "coat(conductor(alpha=0.3, r0=(0.9, 0.6, 0.3)), alpha=0.2, eta=1.5, sigma_t=1, albedo=0.5)"


def test_angles_are_those_of_the_plane_of_incidence(tmp_path):
    """The mirror direction's is positive; a plane across the tangent has the widths exchanged."""
    f = []
    for u, v, azimuth in (0.05, 0.4, "0"), (0.4, 0.05, "90"):
        metal, file = f"conductor(alpha_u={u}, alpha_v={v}, r0=0.5)", tmp_path / f"{azimuth}.npz"
        flags = ["--incidence", "40", "--azimuth", azimuth, "-o", str(file)]
        assert cli.main(["simulate", metal, *flags]) == 0
        with np.load(file) as saved:
            f.append(saved["f"])
            assert (saved["se"] == 0).all()  # a surface without a coat needs no walk
    np.testing.assert_allclose(f[0], f[1], rtol=1e-4)
    assert simulate.POLAR_DEGREES[f[0][:, 0].argmax()] == 40


def test_table_of_the_plane_of_incidence(capsys):
    assert cli.main(["simulate", COATED, "--walks", "256", "--incidence", "20"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "20°" in lines[0]
    assert len(lines) == 2 + len(simulate.POLAR_DEGREES)


def test_saved_numbers_are_those_of_python(tmp_path):
    file = tmp_path / "plane.npz"
    flags = ["--walks", "512", "--seed", "3", "-o", str(file)]
    assert cli.main(["simulate", COATED, *flags]) == 0
    with np.load(file) as saved:
        arrays = dict(saved)
    f, se = urushi.simulate(describe(COATED), arrays["wi"], arrays["wo"], walks=512, seed=3)
    np.testing.assert_array_equal(arrays["f"], f)
    np.testing.assert_array_equal(arrays["se"], se)
    assert (f > 0).all()


def test_pairs_of_a_file(tmp_path, capsys):
    pairs, output = tmp_path / "pairs.npz", tmp_path / "values.npz"
    wi, wo = np.array([[0, 0, 1], [0.6, 0, 0.8]]), np.array([[0, 0.6, 0.8], [0, 0, -1]])
    np.savez(pairs, wi=wi, wo=wo)
    assert cli.main(["simulate", "diffuse(0.5)", "--pairs", str(pairs), "-o", str(output)]) == 0
    with np.load(output) as saved:
        np.testing.assert_allclose(saved["f"], [[0.5 / np.pi] * 3, [0] * 3], rtol=1e-6)
    capsys.readouterr()
    assert cli.main(["simulate", "diffuse(0.5)", "--pairs", str(pairs)]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 1 + len(wi)


def test_albedo_of_a_white_stack_is_one(tmp_path):
    """Without absorption only Smith's masking loses light, which is little at alpha = 0.05."""
    file = tmp_path / "albedo.npz"
    white = "coat(diffuse(1), alpha=0.05, eta=1.3)"
    assert cli.main(["simulate", white, "--albedo", "--walks", "20000", "-o", str(file)]) == 0
    with np.load(file) as saved:
        assert saved["wi"].shape == saved["albedo"].shape == (len(simulate.INCIDENCE_DEGREES), 3)
        # 3 % allow for masked light; five standard errors for chance
        np.testing.assert_array_less(np.abs(saved["albedo"] - 1), 0.03 + 5 * saved["se"])


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["lacquer"], "cannot read the description 'lacquer'"),
        (["conductor(alpha=7, r0=0.5)"], "alpha is 7"),
        (["diffuse(0.5)", "--albedo"], "--albedo needs a stack"),
        (["diffuse(0.5)", "--pairs", "/nowhere.npz"], "No such file or directory"),
        (["diffuse(0.5)", "-o", "/nowhere/f.npz"], "cannot write '/nowhere/f.npz'"),
    ],
)
def test_errors(arguments, sentence, capsys):
    assert cli.main(["simulate", *arguments]) == 2
    message = capsys.readouterr().err
    assert sentence in message
    assert message.count("\n") == 1
