"""Errors of codes against the walk: its noise counts as no error, and every class has stacks."""

import numpy as np
import pytest
from benchmarks.evaluation.samples import Samples
from benchmarks.quality import codes

from urushi.fan2022.store import DataSpec, Part, generate
from urushi.nets.weights import default_model
from urushi.train.distribution import Extended, Practical


def test_stacks_are_of_all_classes():
    names = {part.name.rsplit("-", 2)[0] + part.name[-1] for part in codes.stacks().parts}
    assert names == {f"practical{n}" for n in (1, 2, 3)} | {f"whole{n}" for n in (1, 2, 4)} | {
        "low1"
    }
    few = codes.stacks(0.1).parts
    assert len(few) == len(codes.stacks().parts) and all(part.stacks >= 1 for part in few)


def test_noise_alone_is_no_error_and_an_error_beside_it_remains():
    """1,000 stacks of normal noise of 2 %, and f_hat that is 5 % too bright."""
    rng = np.random.default_rng(1)
    shape = 1000, codes.PAIRS
    wi, wo = (np.tile(np.array([0, 0, 1.0]), (*shape, 1)) for _ in range(2))
    truth, se = np.ones(shape), np.full(shape, 0.02)
    samples = Samples(None, wi, wo, truth + se * rng.standard_normal(shape), se)
    # Its size varies by 5 % from stack to stack: the root of 2 x 5 % of 1.6 %.
    assert np.median(codes.without_noise(truth, samples)) < 0.005
    error = codes.without_noise(1.05 * truth, samples)
    # Errors of either sign add in the mean of sizes less than in squares.
    assert np.sqrt(0.05**2 - 0.016**2) - 0.002 < error.mean() < 0.052


def test_transport_agrees_with_the_walk(tmp_path):
    parts = (
        Part("practical-diffuse-1", Practical(1, "diffuse"), 2, 64, 512, "cosine"),
        Part("whole-conductor-1", Extended(1, "conductor"), 2, 64, 512, "cosine"),
    )
    found = codes.errors(default_model(), generate(DataSpec(parts, seed=5, shard=64), tmp_path))
    assert found.keys() == {
        "practical, 1", "over diffuse", "whole, 1", "over conductor", "whole, 1, metal"
    }  # fmt: skip
    for ways in found.values():
        assert all(ways[way].shape == (2,) for way in codes.WAYS)
        # 512 walks: an error of about 3 %, of which the root of a tenth may remain.
        assert max(ways["table"].max(), ways["code"].max()) == pytest.approx(0, abs=0.03)
