"""Encoding takes every kind of source, gives equal codes for equal BRDFs, and refuses others."""

import numpy as np
import pytest

from urushi.core.probe_pairs import probe_pairs
from urushi.errors import ParameterError, UrushiWarning
from urushi.material import Material
from urushi.material import encode as package_encode
from urushi.material.encode import encode
from urushi.material.source import Source, as_source
from urushi.walk import analytic, conductor, diffuse, slab


def test_a_function_and_its_description_encode_alike(model):
    description = diffuse((0.1, 0.5, 0.9))
    sources = lambda *w: analytic.f(description, *w), description
    found, expected = (encode(source, model).latents for source in sources)
    for codes in (slice(1, 4), slice(6, None)):  # the width of a lobe that reflects nothing is free
        np.testing.assert_allclose(found[:, codes], expected[:, codes], atol=1e-4)


def test_functions_of_one_channel_have_the_same_code_every_time(model):
    grey = encode(lambda wi, wo: np.full(len(wi), 0.3), model)
    column = encode(lambda wi, wo: np.full((len(wi), 1), 0.3), model)
    assert grey == column and grey.channels == 1


def test_objects_with_f_and_materials(material, model, other_model):
    class Brdf:
        f = staticmethod(material.f)

    assert encode(material, model) is material
    assert encode(Brdf(), model, table=False) == encode(material.f, model, table=False)
    assert encode(material, other_model).model is other_model


def test_other_types_of_sources_can_be_registered(model):
    class Foreign:
        level = 0.25

    with pytest.raises(ParameterError, match="cannot encode Foreign"):
        encode(Foreign(), model)
    as_source.register(
        Foreign, lambda source: Source(lambda wi, wo: np.full((len(wi), 3), source.level))
    )
    expected = encode(lambda wi, wo: np.full((len(wi), 3), 0.25), model)
    assert package_encode(Foreign(), model) == expected


def test_the_source_sees_the_probe_pairs(model):
    seen = []
    encode(lambda wi, wo: seen.append((wi, wo)) or np.ones(len(wi)), model)
    for side, probes in zip(seen[0], probe_pairs(model.arch.probes), strict=True):
        assert np.array_equal(side[: len(probes)], probes)  # the other pairs measure its albedo


@pytest.mark.parametrize("source", [None, 3.0, "gold", {"type": "diffuse"}, conductor, Material])
def test_other_things_are_refused(source, model):
    # `conductor` is a function, but not of two directions: its own error says so.
    with pytest.raises(ParameterError):
        encode(source, model)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (lambda n: np.ones((n, 3, 1)), "returns shape"),
        (lambda n: np.ones((n - 1, 3)), "returns shape"),
        (lambda n: np.ones((n, 0)), "returns shape"),
        (lambda n: 1.0, "returns shape"),
        (lambda n: "bright", "not return an array of numbers"),
        (lambda n: np.full((n, 3), -1e-3), "negative or non-finite"),
        (lambda n: np.full((n, 3), np.nan), "negative or non-finite"),
        (lambda n: np.full((n, 3), np.inf), "negative or non-finite"),
    ],
)
def test_faulty_functions_are_refused(values, words, model):
    with pytest.raises(ParameterError, match=words):
        encode(lambda wi, wo: values(len(wi)), model)


def test_slabs_are_opaque_as_codes(model):
    """A clear slab transmits 1 - 2 F / (1 + F) = 92 % of the light; the standard error is 2.7 %."""
    with pytest.warns(UrushiWarning, match=r"lets (8[5-9]|9\d)% of the light through: only what"):
        encode(slab(0.02, ior=1.5), model)
