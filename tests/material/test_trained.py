"""The shipped networks' proposal and faint rests; their errors are in
tests/nets/test_shipped_figures.py.
"""

import numpy as np

from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import stack_error
from urushi.material import encode, layer
from urushi.walk import StackTable, analytic, conductor, dielectric, walk_pairs


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


def test_a_faint_rest_does_not_spoil_coats(trained):
    """A white metal with half a per cent of diffuse light, under a smooth coat, against the walk.

    The lobe alone is within 1 % in E, and the walk's noise is 1.0 %. A code of the faint rest led
    to an E of 9 %.
    """
    surface = {
        "diffuse": 0.005, "ggx_weight": 0.995, "ggx_alpha": 0.3, "ggx_r0": 0.9,
        "beckmann_weight": 0.0, "beckmann_alpha": 0.5, "beckmann_r0": 0.5,
    }  # fmt: skip
    columns = {name: np.array([value], np.float32) for name, value in surface.items()}
    coat = {"alpha": 0.03, "eta": 1.5, "albedo": 0.0, "sigma_t": 0.0, "g": 0.0}
    stack = StackTable(
        **{name: np.array([[value]], np.float32) for name, value in coat.items()},
        kind="mixture",
        bottom=columns,
    )

    def f(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return analytic.rows("mixture", columns, np.zeros(len(wi), np.uint32), wi, wo)

    wi, wo = cosine_pairs(np.random.default_rng(7), 100)
    walked, _ = walk_pairs(stack, np.zeros(100, np.uint32), wi, wo, walks=4096, seed=3)
    coated = layer(dielectric(0.03, 1.5), encode(f, trained)).f(wi, wo)[:, 0]
    assert stack_error(coated[None], walked[None], wi[:, 2], wo[:, 2])[0] < 0.03
