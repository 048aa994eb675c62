"""Media by their appearance: closed forms, the walk, and an error for every mistake."""

import numpy as np
import pytest
from tests.directions import at_cosines

import urushi
from urushi.core import appearance
from urushi.core.namespace import DRJIT
from urushi.errors import ParameterError
from urushi.walk.simulate import albedo

COLOR = (0.9, 0.4, 0.05)


@pytest.mark.parametrize("thickness", (0.5, 1.0, 2.0))
def test_a_clear_coat_transmits_its_color_twice(thickness):
    """By Beer's law, along the normal. A black one is bounded, a white one absorbs nothing."""
    look = {"color": (0.9, 0.4, 0.0), "thickness": thickness}
    (coat,) = urushi.coat(urushi.diffuse(0.9), **look).coats
    expected = np.power((0.9, 0.4, 1e-6), thickness)
    np.testing.assert_allclose(np.exp(-2 * np.array(coat.sigma_t)), expected, rtol=1e-12)
    assert urushi.coat(urushi.diffuse(0.9), color=1.0).coats[0].sigma_t == 0


def diffuse_light(seed: int, **look) -> float:
    """What a coat without an interface over black reflects of diffuse light, by Gauss's nodes."""
    stack = urushi.coat(urushi.diffuse(0.0), eta=1.0, **look)
    nodes, weights = np.polynomial.legendre.leggauss(4)
    wi = at_cosines(0.5 * (nodes + 1))
    return weights @ (wi[:, 2] * albedo(stack, wi, walks=8192, seed=seed)[0][:, 0])


@pytest.mark.parametrize("body_color", (0.1, 0.5, 0.9))
@pytest.mark.parametrize("g", (0.0, 0.7))
def test_an_opaque_body_reflects_diffuse_light_as_its_color(body_color, g):
    """Van de Hulst gives the formula an error of about 0.01; g of a medium replaced by similarity
    changes the albedo by as much."""
    assert diffuse_light(1, body_color=body_color, g=g) == pytest.approx(body_color, abs=0.02)


@pytest.mark.parametrize("body", (0.2, 0.5, 0.9))
def test_white_pigment_keeps_its_body_from_passing(body):
    """What is not reflected has passed it. The two-stream share is within 0.02 of transport."""
    assert diffuse_light(2, body=body, body_color=1.0) == pytest.approx(body, abs=0.025)


def test_dye_and_pigment_add():
    """Absorption of both, scattering of the pigment alone."""
    (_, dye), (a, pigment) = (
        appearance.medium(look, 0.3) for look in ((0.4, 0.0, 0.5), (1.0, 0.6, 0.5))
    )
    both, depth = appearance.medium((0.4, 0.6, 0.5), 0.3)
    assert depth == pytest.approx(dye + pigment)
    assert both * depth == pytest.approx(a * pigment)
    assert appearance.medium((1.0, 0.0, 0.5), 0.3) == (0.0, 0.0)


def test_arrays_and_kernels_agree(rgb):
    rng = np.random.default_rng(0)
    look, g = rng.random((3, 100)), rng.uniform(-0.9, 0.9, 100)
    look[:, :3] = [[0, 1, 0.5], [1, 0, 1], [0, 1, 1]]
    expected = appearance.medium(look, g)
    found = appearance.medium([rgb.Float(x) for x in look], rgb.Float(g), DRJIT)
    for x, y in zip(found, expected, strict=True):
        np.testing.assert_allclose(x.numpy(), y, rtol=2e-5)


def test_layer_and_slab_take_what_coat_takes():
    look = {"color": COLOR, "body": 0.3, "body_color": 0.6, "thickness": 0.7, "g": 0.2}
    top, bottom = urushi.dielectric(0.2, ior=1.4), urushi.diffuse(0.5)
    coated = urushi.coat(bottom, 0.2, ior=1.4, **look)
    (coat,) = coated.coats
    assert urushi.slab(0.2, ior=1.4, **look).coats == coated.coats
    medium = {name: getattr(coat, name) for name in ("albedo", "sigma_t", "g")}
    assert urushi.layer(top, bottom, **look) == urushi.layer(top, bottom, **medium)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"color": 1.2}, "the coat's color is 1.2; it must be in [0, 1]"),
        ({"body": -0.5}, "the coat's body is -0.5; it must be in [0, 1]"),
        ({"body_color": (0.1, 2, 0.1)}, "the coat's body_color is 2; it must be in [0, 1]"),
        ({"thickness": -1}, "the coat's thickness is -1; it must be zero or more"),
        ({"thickness": (1, 2, 3)}, "thickness must be one number, which all channels share"),
        ({"thickness": 1e6, "sigma_t": 2}, "thickness times sigma_t is 2e+06; it must be an opti"),
        ({"color": 0.5, "sigma_t": 1}, "the coat's color and sigma_t are both given; give color,"),
        ({"body": 0.5, "albedo": 1}, "the coat's body and albedo are both given; give color,"),
    ],
)
def test_bad_input_is_named(values, sentence):
    with pytest.raises(ParameterError) as caught:
        urushi.coat(urushi.diffuse(0.5), **values)
    assert sentence in str(caught.value)
