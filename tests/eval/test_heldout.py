"""Evaluation on held-out stacks: its reference is as good as it says, and its figures are right."""

import json

import numpy as np
import pytest

import urushi
from urushi.data.distribution import Extended, Table2
from urushi.errors import FileError, ParameterError
from urushi.eval import heldout
from urushi.nets import weights
from urushi.nets.architecture import Architecture, init

SMALL = Architecture(decoder=(16,), encoder=(16,), layerer=(16,), sampler=(8,))


@pytest.fixture(scope="module")
def group() -> heldout.Group:
    return heldout.Group("a few", Table2(coats=1), stacks=4)


@pytest.fixture(scope="module")
def samples(group) -> heldout.Samples:
    return heldout.simulate(group)


def test_the_reference_reaches_its_aim(samples):
    """Below 0.5 % in E and in P on average, as the figures' definition asks."""
    for error in heldout.reference_error(samples):
        assert error.mean() < 0.005


def test_another_reference_of_the_same_stacks_agrees(samples):
    """An independent run has just the noise of both: E|n| <= sqrt(2) of one's root mean square."""
    table, wi, wo = samples.table, samples.wi, samples.wo
    f, se = heldout._walk(table, np.arange(len(table)), wi, wo, 16384, seed=99)
    again = heldout.Samples(table, wi, wo, f, se)
    own_e, _ = heldout.reference_error(samples)
    other_e, _ = heldout.reference_error(again)
    assert (heldout.stack_errors(f, samples) < 1.5 * (own_e + other_e)).all()
    assert (heldout.stack_errors(samples.f, samples) == 0).all()
    assert (heldout.pair_errors(samples.f, samples) == 0).all()


def test_other_seeds_give_other_stacks(group, samples):
    table, wi, _, _ = heldout.draw(group, seed=1)
    assert not np.isin(table.alpha, samples.table.alpha).any()
    assert not np.isin(wi[..., 0], samples.wi[..., 0]).all()


def test_prediction_of_networks_that_answer_zero():
    """With all parameters zero every network answers zero, whatever the coats: f = exp(0)."""
    params = {name: np.zeros_like(value) for name, value in init(SMALL, 0).items()}
    params["encoder.input_scale"][:] = 1
    model = weights.Model.of(SMALL, params, {})
    group = heldout.Group("deep", Extended(coats=3, bottom="diffuse"), stacks=3)
    table, wi, wo, _ = heldout.draw(group)
    f = heldout.predict(model, table, wi, wo)
    assert f.shape == wi.shape[:2] and f.dtype == np.float32
    np.testing.assert_array_equal(f, 1)


def test_prediction_is_that_of_the_public_functions():
    """encode, then layer from the lowest coat to the top one, for a stack of two coats."""
    model = weights.Model.of(SMALL, init(SMALL, 3), {})
    group = heldout.Group("two coats", Extended(coats=2, bottom="diffuse"), stacks=2)
    table, wi, wo, _ = heldout.draw(group)
    f = heldout.predict(model, table, wi, wo)
    for stack in range(2):
        made = urushi.encode(urushi.diffuse(float(table.bottom["reflectance"][stack])), model)
        for coat in (1, 0):
            alpha, eta, albedo, sigma_t, g = (
                float(getattr(table, name)[stack, coat])
                for name in ("alpha", "eta", "albedo", "sigma_t", "g")
            )
            top = urushi.dielectric(alpha, eta)
            made = urushi.layer(top, made, albedo=albedo, sigma_t=sigma_t, g=g)
        expected = made.f(wi[stack], wo[stack])[:, 0]
        np.testing.assert_allclose(f[stack], expected, rtol=1e-4)  # float32 in another order


def test_report_prints_and_writes_the_same_figures(group, samples, tmp_path, monkeypatch):
    monkeypatch.setattr(heldout, "simulate", lambda *_: samples)
    weights.save(tmp_path / "w.safetensors", SMALL, init(SMALL, 0), {})
    text = heldout.report(tmp_path / "w.safetensors", tmp_path / "e.json", groups=(group,))
    written = json.loads((tmp_path / "e.json").read_text())
    (figures,) = written["groups"]
    head, line = text.splitlines()
    assert "E mean" in head and "P median" in head
    assert line.split()[2:4] == [f"{100 * figures['E'][k]:.2f}" for k in ("mean", "median")]
    assert figures["stacks"] == 4


def test_bad_input(tmp_path):
    with pytest.raises(FileError, match=r"missing\.safetensors"):
        heldout.report(tmp_path / "missing.safetensors")
    with pytest.raises(ParameterError, match="needs some"):
        heldout.draw(heldout.Group("none", Table2(), stacks=0))
