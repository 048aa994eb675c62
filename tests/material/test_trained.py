"""The proposal of the shipped networks; their errors are in tests/eval/test_shipped_figures.py."""

import numpy as np

from urushi.material import encode
from urushi.reference.stack import conductor


def test_the_proposal_beats_the_cosine_on_glossy_materials(trained):
    # Second moments of f_cos / pdf from wi at 45 degrees: lower is a better proposal, and its
    # floor is the albedo squared. Cosine sampling of a lobe of width 0.1 is far above that.
    gold = encode(conductor(0.1, 0.9), trained)
    count = 20_000
    wi = np.tile(np.array([[np.sqrt(0.5), 0, np.sqrt(0.5)]], np.float32), (count, 1))
    wo, pdf = gold.sample(wi, np.random.default_rng(5).random((count, 3)))
    weight = gold.f(wi, wo)[:, 0] * wo[:, 2] / pdf
    cosine = np.mean(weight * np.pi * gold.f(wi, wo)[:, 0])  # E[(pi f)^2] under cosine density
    assert np.mean(weight**2) < 0.2 * cosine
