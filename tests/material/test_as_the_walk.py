"""Materials of stacks by light transport against the random walk, which shares nothing with it."""

import math
from typing import Any

import numpy as np
import pytest

import urushi
from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import energy_weight
from urushi.walk import Coat, Stack, coat, conductor, diffuse

BRUSHED = conductor(alpha_u=0.1, alpha_v=0.4, r0=0.9)
GOLD = conductor(alpha_u=0.3, alpha_v=0.08, eta=0.2, k=3.9)
GREY = diffuse(0.5)
COMPENSATED = Coat(0.8, 1.5, energy_compensation=True)
CLOUDY = {"albedo": 0.9, "sigma_t": 1.0, "g": 0.3}


def satin(bottom: Any, u: float, v: float, **medium: float) -> Stack:
    return coat(bottom, alpha_u=u, alpha_v=v, eta=1.5, **medium)


#: Stacks by name, and bounds of E: of one width by tables, and of two widths by codes.
STACKS: dict[str, tuple[Stack, float]] = {
    "smooth": (coat(conductor(0.05, 0.8), 0.02, 1.5), 0.01),
    "tinted": (coat(conductor(0.1, 0.8), 0.2, 1.4, 0.0, 0.6), 0.01),
    "scattering": (coat(conductor(0.2, 0.8), 0.05, 1.6, **CLOUDY), 0.01),
    "less dense": (coat(conductor(0.3, 0.8), 0.1, 0.7), 0.01),
    # Few pairs of directions of the interface meet the lobe of polished metal.
    "rough on polished": (coat(conductor(0.02, 0.8), 0.3, 1.5), 0.02),
    "nested": (coat(coat(GREY, 0.05, 1.3, sigma_t=0.2), 0.1, 1.5, sigma_t=0.3), 0.01),
    "nested, denser": (coat(coat(GREY, 0.3, 0.8, 0.95, 1.0, 0.9), 0.25, 1.5, 0.9, 0.5), 0.01),
    # Only the topmost surface gives light back, also if both coats are one object.
    "compensated": (Stack((COMPENSATED, COMPENSATED), diffuse(1)), 0.01),
    "two media": (coat(coat(GREY, 0.4, 1.3, 0.9, 2.0, 0.5), 0.25, 1.4, 0.8, 1.0, -0.5), 0.01),
    "no interface": (coat(conductor(0.05, 0.9), 0.3, 1.0, 0.9, 0.7, -0.3), 0.01),
    "faint on gold": (coat(conductor(0.1, eta=0.2, k=3.9), 0.04, 1.003), 0.01),
    "faint on metal": (coat(conductor(0.1, r0=0.8), 0.04, 1.012), 0.01),
    # Facets mask and shadow each other whatever the index.
    "rough and of index 1.001": (coat(diffuse(0.6), 0.3, 1.001), 0.01),
    "rough and of index 0.99": (coat(diffuse(0.6), 0.3, 0.99), 0.01),
    "total reflection, smooth": (coat(GREY, 0.015, 0.55, 0.5, 0.2), 0.02),
    "total reflection, rough": (coat(GREY, 0.15, 0.95, 0.5, 0.2), 0.02),
    # Media outside the range of the networks' training.
    "deep": (coat(GREY, 0.1, 1.5, 0.98, 50.0), 0.01),
    "deep and white": (coat(GREY, 0.1, 1.5, 1.0, 13.0, 0.7), 0.01),
    "deep on polished": (coat(conductor(0.02, 0.9), 0.1, 1.5, 1.0, 20.0), 0.01),
    "scattering forwards": (coat(GREY, 0.1, 1.5, 1.0, 8.0, 0.93), 0.01),
    # A table has few nodes across a backward peak.
    "scattering backwards": (coat(GREY, 0.1, 1.5, 0.9, 2.0, -0.95), 0.08),
    "lacquer on brushed gold": (coat(GOLD, 0.15, 1.5, 0.4, 0.5), 0.02),
    "satin on brushed gold": (satin(GOLD, 0.1, 0.4, albedo=0.4, sigma_t=0.5), 0.02),
    "smooth on brushed": (coat(BRUSHED, 0.05, 1.5), 0.02),
    "across brushed": (satin(BRUSHED, 0.3, 0.1), 0.02),
    "no interface on brushed": (coat(BRUSHED, 0.2, 1.0, **CLOUDY), 0.02),
    "less dense on brushed": (coat(BRUSHED, 0.2, 0.7), 0.04),  # of codes; transport has 0.01
    "rough and tinted on brushed": (coat(BRUSHED, 0.5, 2.0, sigma_t=0.5), 0.02),
    "satin on white": (satin(diffuse(0.7), 0.1, 0.4, albedo=0.9, sigma_t=1.0), 0.02),
}


@pytest.mark.parametrize("name", STACKS)
def test_materials_of_stacks(name):
    """E of the first channel; the noise of the walk is subtracted in squares."""
    stack, most = STACKS[name]
    walks = 2048 if name.startswith("deep") else 8192  # walks through deep media are long
    wi, wo = cosine_pairs(np.random.default_rng(0), 200, lowest_cosine=0.02)
    walk, se = (x[:, 0] for x in urushi.simulate(stack, wi, wo, walks=walks, progress=False))
    weight = energy_weight(wi[:, 2], wo[:, 2])
    energy = (walk * weight).sum()
    error = (np.abs(urushi.encode(stack).f(wi, wo)[:, 0] - walk) * weight).sum() / energy
    noise = math.sqrt(2 / math.pi) * (se * weight).sum() / energy
    assert error**2 - noise**2 < most**2
