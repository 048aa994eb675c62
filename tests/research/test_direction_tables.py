"""The adapter's protocol at a tiny size: symmetric tables, true figures, tables that are reused."""

import json

import numpy as np
import pytest
from benchmarks.quality import pictures
from research import direction_tables
from tests.untrained import untrained

import urushi
from urushi.errors import FileError, ParameterError
from urushi.nets import weights
from urushi.walk import simulate


@pytest.fixture
def tiny() -> weights.Model:
    """Smooth random functions and random networks."""
    return untrained(3)


TINY = direction_tables.Protocol(stacks=2, polar=3, azimuth=4, walks=64)


def test_the_grid_is_that_of_the_publication():
    wi, wo = direction_tables.Protocol().directions()
    assert wi.shape == wo.shape == (40 * 40 * 80, 3)
    np.testing.assert_allclose(np.linalg.norm(wo, axis=1), 1, rtol=1e-6)
    assert (wi[:, 1] == 0).all() and (wi[:, 0] > 0).all() and (wo[:, 2] > 0).all()
    angles = np.degrees(np.arccos(np.unique(wo[:, 2].round(6))))
    np.testing.assert_allclose(angles[::-1], 2.25 * (np.arange(40) + 0.5), atol=1e-3)


def test_entries_that_are_the_same_are_simulated_once():
    """Related entries have the same angles, exchanged or mirrored; others are all kept."""
    protocol = direction_tables.Protocol(stacks=1, polar=5, azimuth=8)
    wi, wo = protocol.directions()
    entries, place = protocol.distinct()
    cosines = np.sort(np.stack([wi[:, 2], wo[:, 2]]), axis=0)
    between = (wi * wo).sum(1)
    angles = np.stack([*cosines, between], axis=-1).round(5)
    assert len(entries) == len(np.unique(angles, axis=0))
    np.testing.assert_allclose(cosines, cosines[:, entries][:, place], atol=1e-6)
    np.testing.assert_allclose(between, between[entries][place], atol=1e-6)


def test_figures_by_hand():
    f, f_hat = np.array([1.0, 2.0, 4.0]), np.array([1.0, 2.0, 5.0])
    mae, psnr, smape, *noise = direction_tables._compare(f_hat, f, np.array([0.1, 0.0, 0.0]))
    assert mae == pytest.approx(1 / 3)
    assert psnr == pytest.approx(10 * np.log10(16 / (1 / 3)))
    assert smape == pytest.approx(2 / 9 / 3)
    mean = 0.1 * np.sqrt(2 / np.pi)
    assert noise == pytest.approx([mean / 3, 10 * np.log10(16 / (0.01 / 3)), mean / 3])
    assert direction_tables._compare(f, f, 0 * f)[1] == np.inf


def test_noise_is_what_an_exact_network_would_show(tiny, monkeypatch):
    """Another simulation in the network's place has the noise of both, sqrt(2) of one's."""
    from benchmarks.evaluation import predict

    protocol = direction_tables.Protocol(stacks=2, polar=6, azimuth=8, walks=1024)
    table = protocol.table()

    class Exact:
        def __init__(self, stack):
            c = {n: float(getattr(table, n)[stack, 0]) for n in ("eta", "albedo", "sigma_t", "g")}
            bottom = urushi.conductor(*(float(table.bottom[n][stack]) for n in ("alpha", "r0")))
            self.stack = urushi.coat(bottom, alpha=float(table.alpha[stack, 0]), **c)

        def f(self, wi, wo):
            return simulate(self.stack, wi, wo, walks=1024, seed=77)[0]

    monkeypatch.setattr(predict, "materials", lambda *_: [Exact(0), Exact(1)])
    outcome = direction_tables.measure(tiny, protocol)
    assert outcome.mae == pytest.approx(np.sqrt(2) * outcome.noise_mae, rel=0.2)
    assert outcome.smape == pytest.approx(np.sqrt(2) * outcome.noise_smape, rel=0.2)
    assert outcome.evaluations == 2 * 6 * 6 * 8


def test_report_keeps_its_tables(tiny, tmp_path, monkeypatch):
    path = tmp_path / "w.safetensors"
    weights.save(path, tiny.arch, tiny.params, {})
    text = direction_tables.report(path, tmp_path / "out", TINY)
    assert "2 stacks, tables of 3 x 4 x 3 x 4, 64 walks a pair" in text
    first = json.loads((tmp_path / "out" / "direction_tables.json").read_text())
    assert first["weights"] == tiny.fingerprint and first["stacks"] == 2

    def walk_pairs(*args, **options):
        raise AssertionError("simulated again")

    monkeypatch.setattr(direction_tables, "walk_pairs", walk_pairs)
    direction_tables.report(path, tmp_path / "out", TINY)
    again = json.loads((tmp_path / "out" / "direction_tables.json").read_text())
    assert again["mae"] == first["mae"]
    assert again["noise_mae"] == pytest.approx(first["noise_mae"], rel=1e-3)  # half precision
    other = direction_tables.Protocol(stacks=2, polar=3, azimuth=4, walks=128)
    with pytest.raises(FileError, match="a table of another protocol; choose another folder"):
        direction_tables.report(path, tmp_path / "out", other)


def test_bad_sizes():
    with pytest.raises(ParameterError, match="3 x 5 angles; give positive numbers"):
        direction_tables.Protocol(polar=3, azimuth=5)


def test_table_errors_by_hand():
    table, reference = [1.0, 0.0, 0.0, 3.0], [3.0, 0.0, 2.0, 3.0]
    assert pictures.mae(table, reference) == pytest.approx(1.0)
    # 2 * 2 / 4 = 1 for the first, 2 for the third, which are as far apart as can be.
    assert direction_tables.smape(table, reference) == pytest.approx((1 + 0 + 2 + 0) / 4)
    assert direction_tables.smape(reference, table) == direction_tables.smape(table, reference)
