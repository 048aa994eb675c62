"""Sizes survive JSON, name every parameter, and refuse nonsense."""

import dataclasses
import json

import numpy as np
import pytest

from urushi.errors import ParameterError
from urushi.nets.architecture import (
    Architecture,
    init,
    parameter_shapes,
)

SMALL = Architecture(latent=8, decoder=(16,), encoder=(24, 20), probes=32, activation="relu")


@pytest.mark.parametrize("arch", [Architecture(), SMALL])
def test_json_round_trip(arch):
    assert Architecture.from_json(arch.to_json()) == arch


@pytest.mark.parametrize("arch", [Architecture(), SMALL])
def test_init_makes_exactly_the_named_parameters(arch):
    params = init(arch, seed=1)
    assert {name: value.shape for name, value in params.items()} == parameter_shapes(arch)
    assert all(value.dtype == np.float32 for value in params.values())


def test_init_depends_on_the_seed_alone():
    first, again, other = init(SMALL, 3), init(SMALL, 3), init(SMALL, 4)
    assert all(np.array_equal(first[name], again[name]) for name in first)
    assert not np.array_equal(first["decoder.0.weight"], other["decoder.0.weight"])


def test_the_lobes_numbers_pass_by_decoder_and_encoder():
    arch = Architecture(latent=24, decoder=(24, 24), sampler=(16,), lobes=1)
    shapes = parameter_shapes(arch)
    assert shapes["decoder.0.weight"] == (17 + 8, 24)  # of 24 numbers, 6 are the lobe's, 1 the gain
    assert shapes["encoder.2.weight"][1] == shapes["layerer.3.weight"][1] == 18
    assert shapes["sampler.1.weight"][1] == 2 + 1 + 1  # weights of two lobes and cosine, one width


def test_a_lobe_of_other_numbers_is_refused():
    entries = json.loads(SMALL.to_json())
    assert entries["lobe"] == 6
    with pytest.raises(ParameterError, match="lobe is 3; this version of Urushi has 6 numbers"):
        Architecture.from_json(json.dumps(entries | {"lobe": 3}))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"latent": 0}, "latent is 0"),
        ({"probes": 1.5}, "probes is 1.5"),
        ({"decoder": ()}, "decoder is \\(\\)"),
        ({"sampler": (32, -1)}, "sampler is"),
        ({"latent": 7}, "latent is 7; a code has 6 numbers for its lobe and at least two more"),
        ({"activation": "tanh"}, "choose one of smoothstep, silu7, relu"),
    ],
)
def test_bad_sizes_are_refused(change, words):
    with pytest.raises(ParameterError, match=words):
        dataclasses.replace(Architecture(), **change)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"latent": 3}', "null"])
def test_foreign_json_is_refused(text):
    with pytest.raises(ParameterError, match="architecture"):
        Architecture.from_json(text)
