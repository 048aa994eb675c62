"""Tables over directions: their nodes, their error, and when there is none."""

from dataclasses import replace

import numpy as np
import pytest

from urushi.core.direction_sets import cosine_pairs
from urushi.core.namespace import NUMPY
from urushi.core.table import (
    SHAPE,
    interpolated,
    interpolated_nodes,
    knots_of,
    knotted,
    known_nodes,
    node_directions,
    pair_coordinates,
    squared_tangent,
    unknotted,
)
from urushi.material import Material, encode, layer
from urushi.walk import conductor, dielectric, diffuse


def test_nodes_have_their_coordinates():
    inner = np.random.default_rng(0).uniform(0.15, 0.9, (3, 200))
    wi, wo = node_directions(*inner)
    for w in (wi, wo):
        np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1, atol=1e-6)
        assert (w[:, 2] > 0).all()
    # wi + wo loses digits in single precision where the half angle is small.
    np.testing.assert_allclose(pair_coordinates(wi, wo), inner, atol=2e-3)
    axes = (np.linspace(0, 1, count) for count in SHAPE)
    wi, wo = node_directions(*(x.ravel() for x in np.meshgrid(*axes, indexing="ij")))
    for w in (wi, wo):
        np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1, atol=1e-6)
        assert w[:, 2].min() > -1e-6


@pytest.fixture(scope="module")
def materials(model) -> list[Material]:
    gold = conductor(0.3, r0=(0.9, 0.6, 0.3))
    amber = encode(diffuse((0.5, 0.2, 0.05)), model)
    return [
        amber,
        layer(dielectric(0.05, 1.5), amber),
        layer(dielectric(0.1, 1.5), encode(gold, model), sigma_t=(2, 0.5, 0.1), albedo=0.7),
        layer(dielectric(0.02, 1.3), encode(conductor(0.1, r0=0.9), model)),
        layer(dielectric(0.3, 1.2), encode(gold, model), sigma_t=0.3),
    ]


def test_the_table_of_a_code_is_its_f(materials):
    """Both are linear in ln f between nodes: rounding apart they are equal."""
    pairs = cosine_pairs(np.random.default_rng(1), 4000, lowest_cosine=0.05)
    wi, wo = (w.astype(np.float32) for w in pairs)
    for material in materials:
        f, networks = replace(material, table=None).f(wi, wo), material.model.networks
        top = networks.top(material.latents[:, None], wi, wo).T
        found = top + interpolated(networks.table(material.latents), wi, wo)
        np.testing.assert_allclose(found, f, rtol=1e-4)


def test_lobes_alone_need_no_table(model):
    metal, white = encode(conductor(0.2, r0=0.9), model), encode(diffuse(0.9), model)
    assert model.networks.table(metal.latents) is None
    assert model.networks.table(white.latents).shape == (*SHAPE, 3)


def test_angles_of_total_reflection_are_nodes() -> None:
    """Seen from glass, below a coat: the angles whose sines are the quotients of the indices."""
    sines = np.array([1.0, 1.3]) / 1.5
    knots = knots_of(sines.tolist())
    places = [node / (SHAPE[1] - 1) for _, node in knots]
    half = np.arcsin(sines) / 2
    np.testing.assert_allclose(unknotted(np.array(places), knots), 2**0.5 * np.sin(half))
    v = np.linspace(0, 1, 101)
    np.testing.assert_allclose(unknotted(knotted(v, knots, NUMPY), knots), v, atol=1e-12)
    assert all(node in known_nodes(knots)[1] for _, node in knots)


def test_values_at_a_part_of_the_nodes_tell_the_others() -> None:
    """The logarithm of GGX is smooth, and a bend at a knot does not reach beyond it."""
    knots = knots_of([1 / 1.5])
    u, v, _ = np.ix_(*(np.linspace(0, 1, count) for count in SHAPE))
    tan2 = squared_tangent(u)
    bend = np.exp(5 * np.minimum(unknotted(v, knots), knots[0][0]))
    f = np.broadcast_to(bend / (0.1**2 + tan2) ** 2, SHAPE)[..., None]
    known = np.ix_(*known_nodes(knots))
    np.testing.assert_allclose(interpolated_nodes(f[known], knots), f, rtol=0.02)
