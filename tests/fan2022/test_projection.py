"""Projection: optimising a code so that it decodes to given values."""

import numpy as np

from urushi.fan2022 import networks, projection
from urushi.fan2022.architecture import PaperArchitecture, init
from urushi.fan2022.inference import direction_inputs, evaluate
from urushi.fan2022.networks import PAIRS, PaperNetworks, projection_pairs


def test_pairs_are_unit_vectors_above_the_horizon_in_all_azimuths():
    for w in projection_pairs():
        np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1, atol=1e-6)
        assert w[:, 2].min() > 0
        azimuth = np.arctan2(w[:, 1], w[:, 0])
        assert np.histogram(azimuth, bins=8, range=(-np.pi, np.pi))[0].min() > PAIRS // 16


def test_a_known_codes_function_is_found_again():
    """The code itself need not be: the values are. Error relative to what the start leaves."""
    params = init(0)
    known = 1 + 0.1 * np.random.default_rng(4).normal(size=(2, 32))
    directions = direction_inputs(*projection_pairs())[None]
    f = evaluate(params, known[:, None].astype(np.float32), directions)
    before = projection.start(params, directions, f).loss
    z, loss = projection.project(params, directions, f)
    assert z.shape == (2, 32)
    assert (loss < 0.05 * before).all()
    np.testing.assert_allclose(
        np.abs(evaluate(params, z[:, None], directions) - f).mean(axis=1), loss, rtol=1e-5
    )


def test_the_loss_never_rises():
    params = init(1)
    directions = direction_inputs(*(w[::4] for w in projection_pairs()))[None]
    f = np.random.default_rng(5).gamma(0.5, size=(2, PAIRS // 4)).astype(np.float32)
    state = projection.start(params, directions, f)
    for _ in range(8):
        new = projection.step(params, state, directions, f)
        assert (new.loss <= state.loss).all()
        state = new


def test_equal_interfaces_are_projected_once(monkeypatch):
    projected = []

    def project(params, directions, f):
        projected.append(len(f))
        return np.repeat(f[:, :1], 32, axis=1), None

    monkeypatch.setattr(networks, "project", project)
    model = PaperNetworks(PaperArchitecture(), init(0), {})

    def rows(kind, columns, row, wi, wo):
        return (columns["alpha"] * columns["eta"])[row]

    monkeypatch.setattr(networks.analytic, "rows", rows)

    alpha = np.array([[0.1, 0.2], [0.1, 0.2]], np.float32)
    codes = model._top(alpha, np.float32(1.5))
    assert sum(projected) == 2
    np.testing.assert_allclose(codes[..., 0], alpha * 1.5, rtol=1e-6)
    model._top(alpha[:1], np.float32(1.5))
    assert sum(projected) == 2
