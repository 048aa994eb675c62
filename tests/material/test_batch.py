"""BRDFs that are encoded together have the same codes as alone."""

import numpy as np
import pytest
from tests.untrained import untrained

import urushi
from urushi.errors import FileError, ParameterError
from urushi.material.encode import encode, encode_all
from urushi.nets import weights

GOLD = urushi.conductor(alpha=0.2, r0=(0.98, 0.77, 0.34))
SOURCES = [GOLD, urushi.diffuse(0.5), urushi.dielectric(alpha=0.1, eta=1.5)] * 4


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    own = untrained()
    path = tmp_path_factory.mktemp("weights") / "untrained.safetensors"
    return weights.save(path, own.arch, own.params, {})


def same(found, model):
    """Whether every source became what `encode` makes of it."""
    assert sorted(found) == list(range(len(SOURCES)))
    for index, encoded in found.items():
        np.testing.assert_array_equal(encoded[0].latents, encode(SOURCES[index], model).latents)


def test_here(model):
    same(dict(encode_all(SOURCES, weights=model)), model)


def test_errors_belong_to_their_source(model, tmp_path):
    missing = [tmp_path / "absent.binary", tmp_path / "nothing.bsdf"]
    found = dict(encode_all([*missing, GOLD, 7], weights=model))
    assert isinstance(found[0], FileError) and "absent.binary" in str(found[0])
    assert isinstance(found[1], FileError) and "nothing.bsdf" in str(found[1])
    np.testing.assert_array_equal(found[2][0].latents, encode(GOLD, model).latents)
    assert isinstance(found[3], ParameterError)
