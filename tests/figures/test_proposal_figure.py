"""The figure of importance sampling: docs and results agree, and proposals are unbiased."""

import json

import numpy as np
import pytest
from benchmarks.quality import sphere
from figures.proposal import compute


@pytest.fixture(scope="module")
def found():
    return json.loads((compute.FOLDER / "results.json").read_text())


def test_networks_have_the_least_noise_on_most_stacks_and_at_grazing_angles(found):
    networks, paper, cosine = (found["variation"][name] for name in compute.NAMES.values())
    half = len(compute.SHARES) // 2
    assert networks["quantiles"][half] < paper["quantiles"][half] < cosine["quantiles"][half]
    assert networks["by angle"][0][-1] < 0.6 * paper["by angle"][0][-1]
    assert networks["largest"] < 0.01 * paper["largest"]


def test_all_proposals_draw_the_sphere_without_bias(found):
    light = sphere.exposed(sphere.own_environments()[0])
    name, material = list(compute.materials().items())[1]
    (truth,) = sphere.render(material.f, [light])
    inside = sphere.mask()
    for proposal, draw in compute.proposals(material).items():
        image = compute.render(material, draw, light, 8, seed=1)
        # By cosines few samples hold much of the light: the mean of 100,000 is uncertain.
        rare = proposal == "cosine"
        assert image[inside].mean() == pytest.approx(
            truth[inside].mean(), rel=0.15 if rare else 0.03
        ), proposal
        if not rare:
            # The error falls as the number of samples: 8 are between 4 and 16.
            errors = found["spheres"][name][proposal]
            error = compute.error([image], truth)
            assert 0.8 * errors["16"] < error < 1.2 * errors["4"]
        assert np.isfinite(image).all() and (image >= 0).all()
