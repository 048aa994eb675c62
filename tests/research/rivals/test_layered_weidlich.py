"""The plugin `layered_weidlich` against its model in NumPy, Mitsuba's bottoms and its sampler."""

import numpy as np
from research.rivals import weidlich
from tests.mitsuba.probes import f

import urushi

GOLD = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2, "eta": 0.2, "k": 3.9}
COAT = {"type": "layered_weidlich", "int_ior": 1.5, "ext_ior": 1.0}
COLOURS = (0.1, 1.0, 3.0)
ABSORBING = {"sigma_t": {"type": "rgb", "value": list(COLOURS)}}


def test_values_are_the_models(rgb, random_directions):
    wi, wo = (random_directions(3000, seed, 0.05) for seed in (0, 1))
    plugin = COAT | ABSORBING | {"alpha": 0.1, "base": GOLD}
    stack = urushi.coat(urushi.conductor(0.2, eta=0.2, k=3.9), 0.1, 1.5, 0.0, COLOURS)
    np.testing.assert_allclose(
        f(rgb.load_dict(plugin), wi, wo), weidlich.f(stack, wi, wo), rtol=1e-3, atol=1e-6
    )
    below = plugin | {"int_ior": 1.2, "ext_ior": 0.8}
    twice = rgb.load_dict(COAT | {"alpha_u": 0.4, "alpha_v": 0.2, "int_ior": 0.8, "base": below})
    stack = urushi.coat(stack, alpha_u=0.4, alpha_v=0.2, eta=0.8)
    np.testing.assert_allclose(f(twice, wi, wo), weidlich.f(stack, wi, wo), rtol=1e-3, atol=1e-6)
