"""Fitted proposals have less variance than those they start from."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from tests import mixtures
from tests.untrained import untrained

from urushi.nets import lobe as lobes
from urushi.nets import proposal
from urushi.train import proposal_fit


@pytest.fixture(params=[1, 2], ids=["one width", "two widths"])
def networks(request):
    return untrained(widths=request.param, spread=1.0).networks


@pytest.fixture
def codes(networks) -> np.ndarray:
    """Codes (24, L) of dielectrics and of no lobe, with rests of all kinds."""
    rng = np.random.default_rng(0)
    z = rng.normal(0, 0.7, (24, networks.arch.latent)).astype(np.float32)
    top = (0.1, 0, 0, 1, 1.5, 0, 0.2)[: networks.arch.lobe]
    z[::2, : networks.arch.lobe] = top
    z[1::2, : networks.arch.lobe] = lobes.no_lobe(networks.arch.widths)
    return z


def test_the_fit_lowers_the_variance(networks, codes, monkeypatch):
    monkeypatch.setattr(proposal_fit, "STEPS", 15)
    found = proposal_fit.fit_proposal(networks, codes)
    np.testing.assert_array_equal(found["proposal.weight"][0, : proposal.TERMS // 2], 1)
    problem = jax.tree.map(jnp.asarray, proposal_fit.problem_of(networks, codes))
    fitted = networks._replace(params={**networks.params, **found})
    wi = np.array([0.5, 0, np.sqrt(0.75)], np.float32)
    weights = mixtures.weights(fitted.proposal(codes, wi))
    np.testing.assert_allclose(weights.sum(axis=-1), 1, atol=1e-6)
    # The optimisation's numbers of the fitted parameters.
    weight, bias, overlap = (found[f"proposal.{n}"] for n in ("weight", "bias", "overlap"))
    numbers = np.zeros((len(weight) + 1, proposal.TERMS))
    numbers[:-2] = np.linalg.solve(problem.factor, weight[1:].astype(float))
    numbers[-2] = bias + problem.rest[:, 0, 1:].mean(axis=0) @ weight[1:]
    numbers[-1, : len(overlap)] = np.log(overlap)
    first = np.zeros_like(numbers)
    first[-2, : proposal.TERMS // 2] = -2  # the lobes of the rest reflect little
    before, after = (proposal_fit.variance(problem, x) for x in (first, numbers))
    assert after < before - 0.1
