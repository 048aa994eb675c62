"""Tables of slabs against the walk, which shares neither their quadratures nor their grids."""

import numpy as np
import pytest
from tests.oracles.analog import analog_albedo

import urushi
from urushi.checks import CoatParameters
from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import energy_weight
from urushi.material.slab_table import slab_materials
from urushi.nets.weights import default_model

DOWN = np.array([1, 1, -1], np.float32)
FIRST = [
    (0.1, 1.5, (0.0, 0.0, 0.0), (0.0, 0.5, 2.0), 0.0),
    (0.4, 1.4, (0.9, 1.0, 0.5), (0.5, 2.0, 1.0), 0.5),
    (0.3, 0.8, (1.0, 0.9, 0.5), (0.3, 1.0, 3.0), -0.3),
]


def drawn(count: int) -> list[tuple]:
    """Slabs over the whole range of every parameter but smooth surfaces, whose lobes pairs miss."""
    rng = np.random.default_rng(3)
    return [
        (
            float(np.exp(rng.uniform(np.log(0.02), 0))),
            float(rng.uniform(1.05, 2.2)),
            np.ones(3) if index % 3 == 0 else rng.uniform(0, 1, 3),
            np.zeros(3) if index % 4 == 0 else rng.exponential(1.5, 3),
            float(rng.uniform(-0.5, 0.9)),
        )
        for index in range(count)
    ]


def errors(slab: tuple, walks: int) -> tuple[np.ndarray, np.ndarray]:
    """E of what a slab reflects and transmits (2, 3), and what the walk's own noise adds to it."""
    alpha, eta, albedo, sigma_t, g = slab
    coat = CoatParameters(*(np.atleast_1d(x) for x in slab))
    wi, wo = (w.astype(np.float32) for w in cosine_pairs(np.random.default_rng(1), 256))
    weight = energy_weight(wi[:, 2], wo[:, 2])[:, None]
    found, noise = [], []
    for material, to in zip(slab_materials(default_model(), coat), (wo, wo * DOWN), strict=True):
        stack = urushi.slab(alpha, eta, albedo, sigma_t, g)
        f, se = urushi.simulate(stack, wi, to, walks=walks, progress=False)
        energy = (f * weight).sum(0)
        found.append((np.abs(material.f(wi, wo) - f) * weight).sum(0) / energy)
        noise.append((se * weight).sum(0) / energy * np.sqrt(2 / np.pi))
    return np.array(found), np.array(noise)


@pytest.mark.parametrize("slab", FIRST)
def test_tables_agree_with_the_walk(slab: tuple) -> None:
    error, noise = errors(slab, 1 << 12)
    assert np.all(error[1] < 0.02 + noise[1])
    assert np.all(error[0] < 0.04 + noise[0])  # the tables of coats of an index below one
    assert noise.max() < 0.05


@pytest.mark.parametrize(
    "count",
    [pytest.param(6, marks=pytest.mark.slow), pytest.param(60, marks=pytest.mark.research)],
)
def test_tables_of_many_slabs_agree_with_the_walk(count: int) -> None:
    every = [errors(slab, 1 << 12) for slab in drawn(count)]
    found, noise = (np.array(x) for x in zip(*every, strict=True))
    excess = found - noise
    assert excess[:, 1].mean() < 0.01
    assert excess[:, 1].max() < 0.03
    assert excess[:, 0].mean() < 0.02


def test_clear_panes_keep_as_much_light_as_the_analog_walk() -> None:
    cosines = np.array([0.95, 0.8, 0.6, 0.4])
    wi = np.stack([np.sqrt(1 - cosines**2), 0 * cosines, cosines], axis=1).astype(np.float32)
    for alpha, eta in ((0.03, 1.3), (0.03, 1.7), (0.15, 1.5)):
        coat = CoatParameters(*(np.array([x]) for x in (alpha, eta, 0.0, 0.0, 0.0)))
        shares = [m.directional_albedo(wi)[:, 0] for m in slab_materials(default_model(), coat)]
        pane = urushi.slab(alpha, eta)
        kept, _ = analog_albedo(pane, wi, walks=1 << 15, transmitted=None)
        # Inside, grazing light is close to the critical angle, which lies between nodes.
        assert np.all(np.abs(sum(shares) - kept[:, 0]) < [0.01, 0.01, 0.01, 0.06])


def test_transmission_is_reciprocal() -> None:
    coat = CoatParameters(*(np.array([x]) for x in (0.2, 1.5, 0.9, 1.0, 0.4)))
    wi, wo = (w.astype(np.float32) for w in cosine_pairs(np.random.default_rng(1), 256))
    for material in slab_materials(default_model(), coat):
        np.testing.assert_array_equal(material.f(wi, wo), material.f(wo, wi))
