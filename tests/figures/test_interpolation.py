"""The figure of blends: ends are exact, and a new computation orders the methods as stored."""

import json

import numpy as np
import pytest
from figures.interpolation import compute


def test_the_results_have_all_ways_and_their_ends_are_the_materials():
    found = json.loads((compute.FOLDER / "results.json").read_text())["ways"]
    assert found.keys() == compute.ENDS.keys()
    for way in found.values():
        for method in compute.METHODS:
            e = np.array(way[method]["E"])
            assert e.shape == (len(compute.SHARES),)
            # Networks' error of one coat, as of figure 6, and the walk's noise.
            assert max(e[0], e[-1]) < 0.03


@pytest.mark.parametrize("name", compute.ENDS)
def test_lerp_is_closest_to_the_blend_of_brdfs_on_average(name):
    found = compute.errors(*compute.ENDS[name], walks=1 << 10)
    e = {method: np.mean(found[method]["E"][1:-1]) for method in compute.METHODS}
    assert min(e, key=e.__getitem__) == "lerp"
    # Independent walks of the ends and of the stack between them: their noise, and the networks.
    for method in compute.METHODS:
        assert found[method]["E"][0] < 0.03 + 2 * max(found["noise"])


def test_parameters_between_two_stacks():
    a, b = compute.ENDS["depth"]
    half = compute.between(a, b, 0.5)
    assert half.sigma_t == [2.0, 2.0, 2.0] and half.alpha == a.alpha
    assert compute.between(a, b, 0.0).r0 == list(a.r0)
