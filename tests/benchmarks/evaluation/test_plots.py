"""The plots show every parameter, the worst stacks, and the lobes of networks and reference."""

import numpy as np
import pytest

pytest.importorskip("matplotlib", reason="the extra 'eval' is not installed")

from benchmarks.quality import eval_plots as plots

from urushi.nets import lobe


@pytest.fixture(scope="module")
def group_errors(sets):
    """Errors by group, as `report` gives them."""
    return {"few": np.array([0.01, 0.03, 0.02]), "bare": np.array([0.5, 0.5, 0.0])}


def test_points_are_the_stacks_parameters(sets, group_errors):
    panels = plots.points(sets, group_errors)
    x, y, coats = panels["top coat: eta"]
    np.testing.assert_array_equal(x, sets["few"].table.eta[:, 0])
    np.testing.assert_allclose(y, [1, 3, 2])
    assert (coats == 1).all()
    assert (panels["mixture: diffuse"][1] > 0).all()
    assert next(iter(panels)).startswith("top coat") and "conductor: r0" in panels


def test_running_median_of_a_line_is_the_line():
    x = np.random.default_rng(0).permutation(40.0 * np.arange(60))
    middle, median = plots.running_median(x, 2 * x)
    np.testing.assert_allclose(median, 2 * middle)
    assert len(middle) == 60 - plots.WINDOW + 1
    assert len(plots.running_median(x[:3], x[:3])[0]) == 1


def test_worst_stacks_are_coated_and_in_order(sets, group_errors):
    assert plots.worst_stacks(sets, group_errors) == [("few", 1), ("few", 2), ("few", 0)]


def test_lobes_are_f_cos_of_both(sets, lax, monkeypatch):
    """Networks that answer 1, limited, have a share of cos and the coat's own mirror lobe."""
    monkeypatch.setattr(plots, "WALKS", 64)
    table = sets["few"].table
    smooth = int(np.argmin(table.alpha[:, 0]))
    reference, network = plots.lobe_values(lax, table, smooth)
    assert reference.shape == network.shape == (3, len(plots.OUTGOING))
    cosines = np.cos(plots.OUTGOING)[None].repeat(3, 0)
    wi, wo = (
        np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=-1)
        for angle in (-np.radians(plots.INCIDENT)[:, None], plots.OUTGOING)
    )
    own = lobe.f(lobe.of_coat(table.alpha[smooth, 0], table.eta[smooth, 0]), wi, wo)
    rest = network / cosines - own
    share = np.median(rest)
    assert 0 < share <= 1
    # What the sharp lobe leaves of its peak has the rounding of single precision.
    np.testing.assert_allclose(rest, share, atol=1e-3 * (1 + own.max()))
    assert (reference[:, plots.OUTGOING > 0].sum(1) > reference[:, plots.OUTGOING < 0].sum(1)).all()
    assert len(plots.describe(table, 0).splitlines()) == 2


def test_pictures_are_written(sets, group_errors, tiny, tmp_path, monkeypatch):
    monkeypatch.setattr(plots, "WALKS", 16)
    plots.draw_errors(tmp_path / "e.png", sets, group_errors)
    plots.draw_lobes(tmp_path / "l.png", tiny, sets, group_errors)
    for name in ("e.png", "l.png"):
        assert (tmp_path / name).read_bytes()[:4] == b"\x89PNG"
