"""Materials of the paper's networks, and its errors over held-out stacks."""

import fan2022
import numpy as np
import pytest
from benchmarks.evaluation import benchmark
from benchmarks.evaluation import fan2022 as evaluation
from benchmarks.evaluation.samples import Group
from fan2022 import Material, PaperNetworks, layer, networks
from fan2022.architecture import init

import urushi
from urushi import dielectric
from urushi.checks import CoatParameters
from urushi.errors import FileError, ParameterError
from urushi.nets.weights import SHIPPED, default_model, find
from urushi.train.distribution import Extended


def test_encode_layer_save_and_load(paper, weights, tmp_path):
    """Weights and materials of one system are refused by the other."""
    bottom = fan2022.encode(lambda wi, wo: np.full(len(wi), 0.3), paper)
    assert bottom.latents.shape == (1, 32)
    assert fan2022.encode(bottom, paper) is bottom
    medium = {"albedo": 0.5, "sigma_t": (0.5, 1.0, 2.0), "g": 0.3}
    coated = layer(dielectric(0.2, 1.5), bottom, **medium)
    assert coated.latents.shape == (3, 32)
    material = tmp_path / "coated.safetensors"
    coated.save(material)
    for given in (paper, weights):
        loaded = fan2022.load(material, given)
        np.testing.assert_array_equal(loaded.latents, coated.latents)
    read = PaperNetworks.read(weights)
    assert read.fingerprint == paper.fingerprint and read.arch == paper.arch
    for load, own in (
        (fan2022.load, PaperNetworks(paper.arch, init(4), {})),
        (urushi.load, default_model()),
    ):
        with pytest.raises(FileError, match="does not match the weights"):
            load(material, own)
    sentence = "holds networks of the system '{}', but those of '{}' are needed"
    with pytest.raises(FileError, match=sentence.format("paper", "urushi")):
        find(weights)
    with pytest.raises(FileError, match=sentence.format("urushi", "paper")):
        PaperNetworks.read(SHIPPED / "default.safetensors")


@pytest.mark.research
def test_errors_are_measured_over_stacks_of_indices_above_one(paper, monkeypatch):
    def group(name, indices, coats=0):
        return Group(name, Extended(coats, "dielectric", indices), 2)

    groups = group("common", "common"), group("low", "low")
    sets = {g.name: benchmark.simulate(g) for g in groups}
    rows = tuple(evaluation.ROWS[0].__class__(g.name, (g.name,)) for g in groups)
    monkeypatch.setattr(evaluation, "ROWS", rows)
    text = evaluation.evaluate(paper, sets)
    assert "common" in text and "low" not in text and paper.fingerprint in text
    (row,) = (line for line in text.splitlines() if line.startswith("| common"))
    assert float(row.split()[3]) > 1  # per cent: the networks have learned nothing


def test_values_are_never_negative_and_zero_below_the_horizon(paper, directions):
    material = Material(np.random.default_rng(0).normal(size=(3, 32)), paper)
    wi, wo = directions[:500], directions[500:]
    f = material.f(wi, wo)
    above = (wi[:, 2] > 0) & (wo[:, 2] > 0)
    assert (f >= 0).all()
    assert not f[~above].any()
    assert f[above].any()


def test_too_many_interfaces_at_once_are_refused(paper):
    z = np.ones((networks.MAX_TOPS + 1, 32), np.float32)
    alpha = np.linspace(0.1, 1, len(z))
    with pytest.raises(ParameterError, match="has 257 different interfaces"):
        paper.layer(z, CoatParameters(alpha, 1.5, 0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("use", "sentence"),
    [
        (lambda m: fan2022.load("x", None), "path must be the path of a file, not None"),
        (lambda m: layer(dielectric(0.1, 1.5), urushi.diffuse(0.5)), "not Dielec"),
        (lambda m: layer(m, m), "layer needs a urushi.dielectric over a"),
        (lambda m: layer(dielectric(0.1, 0.8), m), "eta is 0.8, and the paper's networks cover"),
        (lambda m: layer(dielectric(alpha_u=0.1, alpha_v=0.2), m), "alpha_u and alpha_v differ"),
        (lambda m: m.sample([[0, 0, 1]], [[0.1]]), "u has shape"),
        (lambda m: m.save("x.txt"), "does not end in .safetensors"),
        (lambda m: Material("x", m.networks), "latents must be an array of numbers"),
    ],
)
def test_wrong_arguments_are_one_sentence(paper, use, sentence):
    with pytest.raises(ParameterError, match=sentence):
        use(Material(np.ones((1, 32)), paper))
