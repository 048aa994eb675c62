"""The model of Weidlich and Wilkie 2007 against closed forms and laws of physics."""

import numpy as np
from research.rivals import weidlich

from urushi.core.direction_sets import cosine_pairs
from urushi.walk import coat, conductor, diffuse


def test_absorption_is_beers_law_along_the_refracted_directions() -> None:
    # The quotient of what two coats let through: whatever the interfaces do cancels.
    wi, wo = cosine_pairs(np.random.default_rng(0), 500, lowest_cosine=0.2)
    facet = (wi + wo).astype(float)
    facet /= np.linalg.norm(facet, axis=1, keepdims=True)
    path = 0
    for w in (wi, wo):  # bent towards the facet's normal by Snell's law
        tangent = (w - np.sum(w * facet, axis=1, keepdims=True) * facet) / 1.5
        inside = tangent + np.sqrt(1 - np.sum(tangent**2, axis=1, keepdims=True)) * facet
        path += 1 / inside[:, 2]
    expected = np.exp(-0.8 * path)

    def below(sigma_t: float) -> np.ndarray:
        stacks = (coat(diffuse(r), 0.3, 1.5, 0.0, sigma_t) for r in (1.0, 0.0))
        white, black = (weidlich.f(stack, wi, wo)[:, 0].astype(float) for stack in stacks)
        kept = white > 1.001 * black  # the rest is rounding of a coat's bright lobe
        return np.where(kept, white - black, np.nan)

    found = below(0.8) / below(0.0)
    known = np.isfinite(found)
    assert known.mean() > 0.9
    np.testing.assert_allclose(found[known], expected[known], rtol=2e-3)


def test_the_model_is_reciprocal() -> None:
    wi, wo = cosine_pairs(np.random.default_rng(3), 500, lowest_cosine=0.1)
    stack = coat(coat(conductor(0.2, r0=0.9), 0.3, 1.2, 0.0, 0.4), 0.1, 1.4)
    np.testing.assert_allclose(
        weidlich.f(stack, wi, wo), weidlich.f(stack, wo, wi), rtol=1e-3, atol=1e-6
    )
