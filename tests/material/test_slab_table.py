"""Shares of the light of slabs, and their tables, against closed forms and walks.

Walks share neither their quadratures nor their grids.
"""

import numpy as np
import pytest
from tests.directions import DOWN, at_cosines
from tests.oracles.analog import analog_albedo

import urushi
from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import energy_weight
from urushi.material.crossing import in_plane, inner_albedo
from urushi.material.slab_shares import Layers as SharedLayers
from urushi.material.slab_shares import shares
from urushi.material.slab_table import SlabTables, slab_tables

#: Coats (alpha, eta, albedo, sigma_t, g) and the lowest interface (alpha, eta) of slabs.
Layers = tuple[list[tuple], tuple[float, float]]
CLEAR = (0.0, 0.0, 0.0)
MEDIUM = (0.9, 1.0, 0.3)
FIRST: dict[str, Layers] = {
    "absorbing": ([(0.1, 1.5, (0.0, 0.0, 0.0), (0.0, 0.5, 2.0), 0.0)], (0.1, 1 / 1.5)),
    "paper": ([(0.4, 1.4, (0.9, 1.0, 0.5), (0.5, 2.0, 1.0), 0.5)], (0.4, 1 / 1.4)),
    "thinner": ([(0.3, 0.8, (1.0, 0.9, 0.5), (0.3, 1.0, 3.0), -0.3)], (0.3, 1 / 0.8)),
    "body": ([(0.1, 1.3, *MEDIUM)], (0.2, 1.5 / 1.3)),
    "denser coat": ([(0.3, 1.8, *MEDIUM)], (0.1, 1.33 / 1.8)),
    "matched body": ([(0.2, 1.5, *MEDIUM)], (0.1, 1.0)),
    "a medium on a pane": ([(0.1, 1.0, *MEDIUM), (0.05, 1.5, *CLEAR)], (0.05, 1 / 1.5)),
    "coated pane": ([(0.2, 1.4, *MEDIUM), (0.03, 1.1, 0, 0.3, 0)], (0.03, 1 / 1.54)),
    "coats on glass": ([(0.1, 1.4, 0, 0.2, 0), (0.3, 1.2, *MEDIUM)], (0.15, 1.5 / 1.68)),
}


def arrays(layers: Layers) -> tuple[np.ndarray, np.ndarray]:
    """Interfaces (n + 1, 2) and media (n, 3, C)."""
    coats, far = layers
    channels = max(np.size(x) for coat in coats for x in coat)
    media = [[np.broadcast_to(x, channels) for x in coat[2:]] for coat in coats]
    return np.array([coat[:2] for coat in coats] + [far]), np.array(media, float)


def tables(layers: Layers) -> SlabTables:
    return slab_tables(*arrays(layers))


def described(layers: Layers) -> urushi.Stack:
    coats, far = layers
    slab = urushi.dielectric(*far)
    for coat in reversed(coats):
        slab = urushi.coat(slab, *coat)
    return slab


def clear(surfaces: list[tuple[float, float]]) -> Layers:
    """A slab of surfaces (alpha, eta) without media."""
    return [(*surface, *CLEAR) for surface in surfaces[:-1]], surfaces[-1]


@pytest.mark.parametrize(
    ("whole", "cut"),
    [
        ([(0.1, 1.5), (0.2, 0.8)], [(0.1, 1.5), (0.3, 1.0), (0.2, 0.8)]),
        ([(0.1, 1.0), (0.2, 1.5)], [(0.3, 1.0), (0.1, 1.0), (0.2, 1.5)]),
        ([(0.2, 1.5), (0.3, 1.0)], [(0.2, 1.5), (0.1, 1.0), (0.3, 1.0)]),
    ],
)
def test_an_interface_of_index_one_is_none(whole: list[tuple], cut: list[tuple]) -> None:
    """Inside, above and below a slab. Media are doubled from other depths."""
    half, wi = (0.9, 0.5, 0.3), at_cosines([0.98, 0.8, 0.6, 0.4, 0.25, 0.12])
    slabs = ([(*whole[0], *MEDIUM)], whole[1]), ([(*x, *half) for x in cut[:2]], cut[2])
    np.testing.assert_allclose(*(tables(slab).shares(wi) for slab in slabs), atol=1e-3)


@pytest.mark.parametrize(
    "surfaces",
    [
        [(0.01, 1.6), (0.01, 1.5 / 1.6)],
        [(0.283, 1.59), (0.047, 1.0757)],
        pytest.param(
            [(0.025, 1.18), (0.023, 1.66), (0.023, 0.687), (0.044, 0.743)], marks=pytest.mark.slow
        ),
    ],
)
def test_clear_slabs_have_the_shares_of_the_analog_walk(surfaces: list[tuple]) -> None:
    """Within four standard errors of the walks, which are 0.004 at most, and 0.003 of the grid."""
    cosines = np.array([0.98, 0.8, 0.6, 0.4, 0.25, 0.12])
    for own in (surfaces, [(alpha, 1 / eta) for alpha, eta in surfaces[::-1]]):
        inner = shares(SharedLayers.of(*arrays(clear(own))), 1)[0]
        reflected, passed = (
            np.interp(np.arccos(cosines), inner.angles, x[:, 0])
            for x in (inner.reflected, inner.passed)
        )
        reflected = reflected + inner_albedo(in_plane(cosines[:, None]), own[0][0], 1 / own[0][1])
        for share, transmitted in ((reflected, False), (passed, True)):
            truth, se = analog_albedo(
                described(clear(own)), at_cosines(cosines), walks=1 << 14, transmitted=transmitted
            )
            assert np.all(np.abs(share - truth[:, 0]) < 0.003 + 4 * se[:, 0])


def drawn(count: int) -> list[Layers]:
    """Slabs over the whole range of every parameter but smooth surfaces, whose lobes pairs miss.

    Every second one is as symmetric as one coat can be; the others are bodies, and two coats.
    """
    rng, every = np.random.default_rng(3), []

    def coat(index: int) -> tuple:
        return (
            float(np.exp(rng.uniform(np.log(0.02), 0))),
            float(rng.uniform(1.05, 2.2)),
            np.ones(3) if index % 3 == 0 else rng.uniform(0, 1, 3),
            np.zeros(3) if index % 4 == 0 else rng.exponential(1.5, 3),
            float(rng.uniform(-0.5, 0.9)),
        )

    for index in range(count):
        coats = [coat(index)]
        far = coats[0][0], 1 / coats[0][1]
        if index % 4 == 1:
            far = float(rng.uniform(0.02, 1)), float(rng.uniform(1.1, 1.7) / coats[0][1])
        elif index % 4 == 3:
            coats.append((*coat(index)[:1], float(rng.uniform(0.7, 1.3)), *coat(index)[2:]))
            far = coats[1][0], 1 / (coats[0][1] * coats[1][1])
        every.append((coats, far))
    return every


def errors(layers: Layers, walks: int) -> tuple[np.ndarray, np.ndarray]:
    """E of what a slab reflects on either side and transmits (3, C), and the walks' own noise."""
    own, slab, noise, value = tables(layers), described(layers), [], []
    wi, wo = cosine_pairs(np.random.default_rng(1), 128)
    weight = energy_weight(wi[:, 2], wo[:, 2])[:, None]
    for a, b in ((wi, wo), (wi * DOWN, wo * DOWN), (wi, wo * DOWN)):
        f, se = urushi.simulate(slab, a, b, walks=walks, progress=False, mode="importance")
        energy, channels = (f * weight).sum(0), own.passed.shape[-1]
        value.append(((np.abs(own.f(a, b) - f) * weight).sum(0) / energy)[:channels])
        noise.append(((se * weight).sum(0) / energy * np.sqrt(2 / np.pi))[:channels])
    return np.array(value), np.array(noise)


@pytest.mark.parametrize("name", FIRST)
def test_tables_agree_with_the_walk(name: str) -> None:
    error, noise = errors(FIRST[name], 1 << 12)
    assert np.all(error[2] < 0.02 + noise[2])
    assert np.all(error[:2] < 0.04 + noise[:2])  # the tables of coats of an index below one
    assert noise.max() < 0.05


@pytest.mark.research
def test_tables_of_many_slabs_agree_with_the_walk() -> None:
    every = [errors(slab, 1 << 12) for slab in drawn(60)]
    # The walks through the deepest channels have more noise than the error that is asserted.
    excess = np.array([np.where(noise < 0.05, found - noise, 0) for found, noise in every])
    assert np.mean([noise < 0.05 for _, noise in every]) > 0.95
    assert excess[:, 2].mean() < 0.01
    assert excess[:, 2].max() < 0.03
    assert excess[:, :2].mean() < 0.02


GRAZING: list[Layers] = [
    ([(0.16, 1.37, *CLEAR)], (0.164, 1.235)),
    ([(0.04, 1.57, 1.0, 1.4, 0.1), (0.5, 1.56, *CLEAR)], (0.15, 0.536)),
]


@pytest.mark.parametrize("layers", GRAZING, ids=["clear", "scattering"])
def test_bodies_transmit_grazing_light_as_by_the_walk(layers: Layers) -> None:
    """Refraction packs light of the horizon into a few degrees of the denser medium.

    Nodes are as dense there as elsewhere. Between them, linear interpolation of logarithms is off
    by up to 0.06 of the light of a direction; 0.02 more are for the choice of 48 directions wo.
    """
    cosines, wo = [0.2, 0.1, 0.05], cosine_pairs(np.random.default_rng(2), 48)[1] * DOWN
    wi, wo = np.repeat(at_cosines(cosines), len(wo), axis=0), np.tile(wo, (len(cosines), 1))
    slab = described(layers)
    f, se = urushi.simulate(slab, wi, wo, walks=1 << 11, progress=False, mode="importance")
    cosine = np.abs(wo[:, 2])
    light, error, noise = (
        (x * cosine).reshape(len(cosines), -1).sum(1)
        for x in (f[:, 0], np.abs(tables(layers).f(wi, wo)[:, 0] - f[:, 0]), se[:, 0])
    )
    assert np.all(error < 0.08 * light + noise)


def test_white_scattering_slabs_lose_no_light() -> None:
    """Within half a per cent, also where light in the glass is close to total reflection."""
    wi = at_cosines([0.95, 0.75, 0.7, 0.45])
    for far in ((0.01, 1 / 1.5), (0.01, 1.0)):
        own = tables(([(0.01, 1.5, 1.0, 4.0, 0.2)], far))
        for w in (wi, wi * DOWN):
            assert np.all(np.abs(own.shares(w).sum(axis=0)[:, 0] - 1) < 0.005)


def test_transmission_is_reciprocal() -> None:
    wi, wo = cosine_pairs(np.random.default_rng(1), 256)
    for name in ("paper", "body", "coats on glass"):
        own = tables(FIRST[name])
        for near, far in ((wi, wo), (wi * DOWN, wo * DOWN)):
            np.testing.assert_array_equal(own.f(near, far), own.f(far, near))
        down, up = own.f(wi, wo * DOWN), own.f(wo * DOWN, wi)
        np.testing.assert_allclose(down, up * own.eta**2, rtol=1e-5)


HORIZON = [0.45, 0.3, 0.2, 0.1, 0.05]
#: About the angle of total reflection, where cells of the table of transmission hold 0.025 too much
ALL = [0.98, 0.8, 0.735, 0.7, 0.6, 0.4, 0.25, 0.12]
#: Surfaces of clear slabs, reflected light (0), or transmitted (1), and its bound. Light of the
#: horizon refracts into few cells of a table; inside, it is close to total reflection, and smooth
#: surfaces widen it beyond.
SHARES = [
    ([(0.1, 1.4), (0.1, 1.5 / 1.4)], HORIZON, (1,), 0.04),
    ([(0.02, 1.3), (0.02, 1.5 / 1.3)], HORIZON, (1,), 0.04),
    ([(0.01, 1.5), (0.01, 1 / 1.5)], HORIZON, (1,), 0.04),
    ([(0.01, 1.5), (0.01, 1 / 1.5)], [0.3, 0.2, 0.15, 0.1], (0, 1), 0.025),
    # Sharp on rough, from inside glass.
    ([(0.3, 1.4 / 1.5), (0.01, 1 / 1.4)], [0.7, 0.6, 0.45, 0.3], (0,), 0.04),
    # Interfaces of little refraction: of the glass's own index, from inside; of about it; on a pane
    ([(0.2, 1.0), (0.01, 1 / 1.5)], ALL, (0, 1), 0.01),
    ([(0.01, 1.6 / 1.5), (0.01, 1 / 1.6)], ALL, (0, 1), 0.01),
    ([(0.01, 1.3), (0.3, 1.0), (0.01, 1 / 1.3)], ALL, (0, 1), 0.01),
    ([(0.04, 1 / 1.02), (0.1, 1 / 1.96)], ALL, (0, 1), 0.01),
    ([(0.03, 1.7), (0.01, 0.88), (0.01, 0.8), (0.02, 0.833)], ALL, (0, 1), 0.01),
]


@pytest.mark.parametrize("case", range(len(SHARES)))
def test_clear_slabs_keep_their_light_near_the_horizon_and_total_reflection(case: int) -> None:
    surfaces, cosines, parts, bound = SHARES[case]
    layers, wi = clear(surfaces), at_cosines(cosines)
    own = tables(layers).shares(wi)
    for part in parts:
        kept, se = analog_albedo(described(layers), wi, walks=1 << 15, transmitted=bool(part))
        noise = 3 * se[:, 0] if bound == 0.01 else 0
        assert np.all(np.abs(own[part] - kept)[:, 0] < bound + noise)
