"""The paper's training: its numbers, that it learns, and that it runs from data to weights."""

import json
from dataclasses import replace

import jax
import numpy as np
import pytest
from fan2022 import Material, layering, networks, projection, proxy, representation, training
from fan2022.architecture import PaperArchitecture, init
from fan2022.inference import direction_inputs
from fan2022.pairs import stratified_pairs
from fan2022.palette import make_shard, read_shard
from fan2022.preset import PaperPreset
from fan2022.training import train

from urushi.errors import ParameterError
from urushi.train.checkpoint import Journal
from urushi.train.tables import generate
from urushi.walk import analytic

pytestmark = pytest.mark.research

TINY = 1e-10


def test_at_scale_one_all_numbers_are_the_papers():
    """Smaller scales take fewer samples. Over all epochs, rates fall by the same factor."""
    preset = PaperPreset()
    parts = {name: count for name, (_, count) in preset.data.parts.items()}
    assert parts == {"conductor": 300, "dielectric": 300, "two-layer": 12_720, "three-layer": 1_800}
    assert (preset.data.pairs, preset.trained, preset.epochs) == (25**4, 12_000, 50)
    assert preset.rates(0) == (3e-4, 1e-4)
    assert preset.rates(1) == pytest.approx((0.9 * 3e-4, 0.9 * 1e-4))
    assert (preset.layering_epochs, layering.RATE, layering.DECAY) == (1000, 3e-3, 0.7)
    assert preset.layering_epochs // layering.DECAYS == 50
    small = PaperPreset(1e-4)
    whole, part = (p.trained * p.data.pairs * p.epochs for p in (preset, small))
    assert part / whole == pytest.approx(1e-4, rel=0.3)  # whole numbers
    decay = small.rates(small.epochs)[0] / small.rates(0)[0]
    assert decay == pytest.approx(0.9**50)
    with pytest.raises(ParameterError, match="scale is 2; it must be in"):
        PaperPreset(2)


def test_shards_are_projected_into_their_places(tmp_path):
    preset = PaperPreset(TINY, PaperArchitecture(steps=4, pairs=16))
    store, params = generate(preset.data, tmp_path / "data", make_shard), init(0)
    start = training.beginnings(preset)["projection"].state
    assert training.missing(preset, start) == [0, 1, 2, 3]
    result = training.projected(params, preset, (2, *read_shard(store, 2)))
    found = training.with_codes(start, preset, 2, *result)
    codes = found["codes.two-layer"]
    assert (codes != 0).all() and (found["error.two-layer"] > 0).all()
    assert training.missing(preset, found) == [0, 1, 3]
    wi, wo, f = (values[:1] for values in read_shard(store, 2))
    alone, _ = projection.project(params, direction_inputs(wi, wo), f, preset.arch)
    np.testing.assert_allclose(codes[:1], alone, atol=1e-4)


def test_a_sampler_is_fitted_to_networks_that_came_without_one(monkeypatch, positive):
    """Its proposals depend on the code; the networks are untrained, so that any will do."""
    for name in ("COMPONENTS", "STACKS", "INCOMING"):
        monkeypatch.setattr(proxy, name, 2)
    params = {k: v for k, v in positive.items() if not k.startswith("proxy.")}
    params["evaluation.3.bias"] = np.float32([0.5])  # so that nearly all values are positive
    fitted, divergence = proxy.fitted_proxy(params, PaperArchitecture(steps=1, pairs=64))
    assert set(fitted) == {k for k in init(0) if k.startswith("proxy.")}
    assert 0 < divergence < 0.5  # from nearly constant values to lobes


def test_one_brdf_is_learned_by_heart():
    """A rough conductor at 81 pairs: L1 falls far below what a constant leaves."""
    wi, wo = stratified_pairs(np.random.default_rng(9), 81)
    columns = {"alpha": np.array([0.4]), "r0": np.array([0.9])}
    f = analytic.rows("conductor", columns, np.zeros(81, np.uint32), wi, wo)
    batch = representation.Batch(np.zeros(1, np.int32), wi[None], wo[None], f[None])
    state = representation.start(init(0), brdfs=2)
    for step in range(200):
        rate = 3e-4 * 0.985**step
        state, loss = representation.step(state, batch, rate, rate)
    assert loss < 0.4 * np.abs(f - np.median(f)).mean()
    assert np.abs(state.latents[0] - 1).max() > 1e-3
    np.testing.assert_array_equal(state.latents[1], 1)  # only the batch's codes learn


@pytest.mark.parametrize("brdfs", [1, 8, 22, 29])
def test_a_step_in_slices_is_a_step_of_the_whole_batch(brdfs):
    """The first moments are a tenth of the slopes."""
    rng = np.random.default_rng(brdfs)
    wi, wo = (w[: 4 * brdfs].reshape(brdfs, 4, 3) for w in stratified_pairs(rng, 256))
    f = rng.random((brdfs, 4)).astype(np.float32)
    batch = representation.Batch(np.arange(brdfs), wi, wo, f)
    state = representation.start(init(1), brdfs)
    z = state.latents + rng.normal(0, 0.1, state.latents.shape)
    state, loss = representation.step(state._replace(latents=z), batch, 0.0, 0.0)
    params = {k: v for k, v in init(1).items() if k.startswith("evaluation.")}
    whole, (slope, z_slope) = jax.value_and_grad(representation.l1_loss, (0, 1))(params, z, batch)
    assert loss == pytest.approx(float(whole), rel=1e-5)
    np.testing.assert_allclose(state.moments.mu, 0.1 * z_slope, rtol=1e-3, atol=1e-7)
    for name, moment in state.optimiser.mu.items():
        np.testing.assert_allclose(moment, 0.1 * slope[name], rtol=1e-3, atol=1e-6, err_msg=name)


def test_epochs_show_every_brdf_equally_often_and_are_repeatable(tmp_path):
    """Their batches have one size, so that each run over all leaves out other BRDFs."""
    preset = PaperPreset(1e-9, stacks=8, pairs=16)
    store = generate(preset.data, tmp_path / "data", make_shard)
    batches = list(representation.epoch(store, preset, 0))
    trained, runs = preset.trained, preset.data.pairs // 16
    assert trained % 8
    assert {batch.f.shape for batch in batches} == {(8, 16)}
    shown = np.array([batch.rows for batch in batches]).reshape(runs, -1)
    assert shown.shape[1] == trained // 8 * 8
    left_out = [set(range(trained)) - set(run) for run in shown.tolist()]
    assert {len(rest) for rest in left_out} == {trained % 8}  # no BRDF twice in a run
    assert len(set(map(frozenset, left_out))) == runs
    assert shown.max() < trained
    again = next(iter(representation.epoch(store, preset, 0)))
    for a, b in zip(again, batches[0], strict=True):
        np.testing.assert_array_equal(a, b)
    other = next(iter(representation.epoch(store, preset, 4)))
    assert not np.array_equal(other.f, batches[0].f)


def test_layering_examples_join_codes_of_the_right_parts():
    preset = PaperPreset(TINY)
    codes = {
        name: np.arange(count)[:, None] + 1000 * index + np.zeros((1, 32))
        for index, (name, (_, count)) in enumerate(preset.data.parts.items())
    }
    sets = layering.examples(preset, codes)
    source, count = preset.data.parts["three-layer"]
    top, below, _, sigma_t = source.parts(slice(0, count))
    three = sets["three-layer"]
    np.testing.assert_array_equal(three.z_top[:, 0], 1000 + top)
    np.testing.assert_array_equal(three.z_bottom[:, 0], 2000 + below)
    np.testing.assert_array_equal(three.sigma_t, sigma_t)
    assert len(sets["train"].target) == preset.trained
    assert len(sets["validation"].target) == preset.validation


def test_the_proxy_learns_to_tell_narrow_from_wide():
    """Histograms of a Gaussian and of a cosine lobe are recognised by width and share."""
    squared = (proxy.centres() ** 2).sum(axis=1)
    narrow = np.exp(-squared / (2 * 0.1**2))
    cosine = np.where(squared < 1, 1.0, 0.0)
    z = np.random.default_rng(11).normal(size=(2, 32)).astype(np.float32)
    shares = np.stack([narrow / narrow.sum(), cosine / cosine.sum()]).astype(np.float32)
    data = proxy.Histograms(z, shares, shares[1])
    trained, divergence = proxy.learn(init(0), data)
    mixture = proxy.proxy(trained, z)
    assert divergence < 0.1
    assert mixture.sigma[0] == pytest.approx(0.1, rel=0.3)
    assert mixture.share[0] > 0.9


@pytest.mark.slow
def test_from_data_to_weights_and_the_same_bits_after_an_interruption(tmp_path, monkeypatch):
    preset = PaperPreset(TINY, PaperArchitecture(steps=8, pairs=16))
    model = train(preset, data=tmp_path / "data", run=tmp_path / "whole")
    header = networks.PaperNetworks.read(tmp_path / "whole" / "weights.safetensors").header
    assert header["scale"] == TINY
    assert header["preset"]["name"] == "paper"
    stages = [
        json.loads(line)["stage"]
        for line in (tmp_path / "whole" / "log.jsonl").read_text().splitlines()
    ]
    assert stages == sorted(stages, reverse=True)  # representation, then layering
    material = Material(np.ones((1, 32)), model)
    assert (material.f([[0, 0, 1]], [[0.6, 0, 0.8]]) >= 0).all()
    more = replace(preset, evaluation=model.fingerprint)  # trains the other networks alone
    assert more.data.pairs == networks.PAIRS
    others = train(more, run=tmp_path / "more", evaluation=model)
    kept = {name for name, x in model.params.items() if np.array_equal(x, others.params[name])}
    assert kept >= {name for name in model.params if name.startswith("evaluation.")}
    assert not any(name.startswith("layering.") for name in kept)

    save, count = Journal.save, []

    def interrupted(self, point, *figures):
        save(self, point, *figures)
        count.append(point)
        if len(count) == 4:  # after an epoch, and two shards of four
            raise KeyboardInterrupt

    monkeypatch.setattr(Journal, "save", interrupted)
    with pytest.raises(KeyboardInterrupt):
        train(preset, data=tmp_path / "data", run=tmp_path / "cut")
    monkeypatch.undo()
    assert count[-1].stage == "projection"
    resumed = train(preset, data=tmp_path / "data", run=tmp_path / "cut", resume=True)
    assert resumed.fingerprint == model.fingerprint
    assert resumed.header["metrics"] == model.header["metrics"]
