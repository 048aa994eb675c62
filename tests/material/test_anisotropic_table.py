"""Tables of four coordinates for two widths: nodes, symmetries, and how closely they keep f."""

import numpy as np
import pytest

from urushi.core.direction_sets import cosine_pairs, slope_pairs
from urushi.core.table import anisotropic_node_directions, interpolated, pair_coordinates
from urushi.material import Material, encode, layer
from urushi.walk import conductor, dielectric, diffuse

BRUSHED = {"alpha_u": 0.08, "alpha_v": 0.4}


@pytest.fixture(scope="module")
def materials() -> list[Material]:
    return [
        layer(dielectric(0.1, 1.5), conductor(r0=(0.9, 0.6, 0.3), **BRUSHED), sigma_t=0.3),
        layer(dielectric(alpha_u=0.3, alpha_v=0.1, eta=1.4), diffuse((0.5, 0.2, 0.1)), sigma_t=1),
        layer(dielectric(eta=0.8, **BRUSHED), conductor(r0=0.7, **BRUSHED), sigma_t=0.5),
    ]


@pytest.fixture(scope="module")
def tables(materials) -> list[np.ndarray]:
    return [m.model.networks.table(m.latents) for m in materials]


def pairs(count: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of cosine density, and others whose half vector is near the normal."""
    rng = np.random.default_rng(1)
    both = (make(rng, count, lowest_cosine=0.05) for make in (cosine_pairs, slope_pairs))
    return tuple(np.concatenate(w).astype(np.float32) for w in zip(*both, strict=True))


def test_nodes_have_their_coordinates():
    inner = np.random.default_rng(0).uniform(0.2, 0.9, (4, 4000))
    wi, wo = anisotropic_node_directions(*inner)
    above = (wi[:, 2] > 0.01) & (wo[:, 2] > 0.01)
    assert above.sum() > 500
    for w in (wi, wo):
        np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1, atol=1e-6)
    # wi + wo and wi - wo lose digits in single precision where they are small.
    np.testing.assert_allclose(
        pair_coordinates(wi[above], wo[above], 2), inner[:, above], atol=2e-3
    )


@pytest.mark.parametrize("signs", [(-1, 1, 1), (1, -1, 1), (-1, -1, 1)])
def test_mirrored_and_exchanged_pairs_have_the_same_coordinates(signs):
    wi, wo = pairs()
    expected = pair_coordinates(wi, wo, 2)
    mirrored = wi * np.float32(signs), wo * np.float32(signs)
    for w in (mirrored, mirrored[::-1], (wo, wi)):
        np.testing.assert_array_equal(pair_coordinates(*w, 2), expected)


def test_f_is_continuous_where_a_half_vector_crosses_an_axis(tables):
    """The angle jumps there, but f does not."""
    wi, wo = pairs(500)
    for axis in (0, 1):
        for table in tables:
            sides = []
            for offset in (-1e-5, 1e-5):
                other = wo.copy()
                other[:, axis] = offset - wi[:, axis]
                other[:, 2] = np.sqrt(np.maximum(1 - (other[:, :2] ** 2).sum(axis=1), 0))
                sides.append(interpolated(table, wi, other))
            # Near the horizon, 2e-5 of a direction changes its cosine by a few per cent.
            seen = (wi[:, 2] > 0.1) & (other[:, 2] > 0.1)
            assert seen.sum() > 200
            np.testing.assert_allclose(sides[0][seen], sides[1][seen], rtol=0.01)


def test_a_bare_lobe_needs_no_table():
    metal = encode(conductor(r0=0.9, **BRUSHED))
    assert metal.model.networks.table(metal.latents) is None
