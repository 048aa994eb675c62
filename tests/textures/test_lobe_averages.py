"""Averages of lobes: factors are averaged linearly, roots of widths by light."""

import numpy as np

from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import stack_error
from urushi.material.albedo_rule import albedo_rule
from urushi.material.lobe_albedo import isotropic_albedos
from urushi.nets import lobe as lobes
from urushi.textures import mip_pyramid


def test_lobes_of_equal_widths_and_indices_are_averaged_exactly():
    rng = np.random.default_rng(2)
    own = np.tile(np.array([0.2, 0, 0, 0, 1.5, 0], np.float32), (8, 1))
    own[:, 1:4] = rng.random((8, 3))
    found = mip_pyramid.dropped_lobes(mip_pyramid.lifted_lobes(own).mean(axis=0, keepdims=True))
    np.testing.assert_allclose(found[0], own.mean(axis=0), rtol=1e-5, atol=1e-6)


def test_lobes_alone_stay_and_one_that_reflects_nothing_does_not_count():
    both = np.array([lobes.NO_LOBE, [0.1, 0, 0, 1, 1.7, 0]], np.float32)
    found = mip_pyramid.dropped_lobes(mip_pyramid.lifted_lobes(both).mean(axis=0, keepdims=True))[0]
    np.testing.assert_allclose(found, [0.1, 0, 0, 0.5, 1.7, 0], rtol=1e-3)
    metal = np.array([[0.3, 0, 0, 1, 0.2, 3.9], [0.2, 0, 0, 1, 0.6, 0]], np.float32)
    np.testing.assert_allclose(
        mip_pyramid.dropped_lobes(mip_pyramid.lifted_lobes(metal)), metal, rtol=1e-4, atol=1e-6
    )
    nothing = mip_pyramid.dropped_lobes(mip_pyramid.lifted_lobes(both[:1]))[0]
    np.testing.assert_allclose(nothing, both[0], rtol=1e-5)


def averaged_widths() -> tuple[np.ndarray, np.ndarray]:
    """Lobes (32, 8, 6) of a dielectric with widths from 0.05 to 0.4, and their averages (32, 6)."""
    widths = np.random.default_rng(0).uniform(0.05, 0.4, (32, 8)).astype(np.float32)
    several = lobes.of_coat(widths, np.float32(1.5))
    means = mip_pyramid.lifted_lobes(several.reshape(-1, 6)).reshape(32, 8, -1).mean(axis=1)
    return several, mip_pyramid.dropped_lobes(means)


def test_one_lobe_for_several_widths_reflects_as_much_light():
    """Under light from all sides, to 0.5 %."""
    cosines = albedo_rule().cosines
    weights = np.abs(np.gradient(cosines)) * cosines
    several, one = (isotropic_albedos(lobe, cosines) @ weights for lobe in averaged_widths())
    np.testing.assert_allclose(one, several.mean(axis=1), rtol=0.005)


def test_hardly_any_other_width_is_closer():
    wi, wo = cosine_pairs(np.random.default_rng(1), 1000)
    several, one = averaged_widths()
    f = lobes.f(several[:, :, None], wi, wo).mean(axis=1)
    errors = []
    for factor in np.geomspace(0.6, 1.6, 21):
        other = one * np.array([factor, 1, 1, 1, 1, 1])
        errors.append(stack_error(lobes.f(other[:, None], wi, wo), f, wi[:, 2], wo[:, 2]))
    assert errors[10].mean() < 1.1 * np.mean(errors, axis=1).min()
