"""Fitted proposals have less variance than those they start from."""

from functools import partial

import numpy as np
import pytest
from tests import mixtures
from tests.directions import in_plane
from tests.untrained import untrained

from urushi.nets import lobe as lobes
from urushi.nets import proposal
from urushi.train import proposal_fit


@pytest.mark.parametrize("widths", [1, 2])
def test_the_fit_lowers_the_variance(widths, monkeypatch):
    """Of dielectrics and of no lobe, with rests of all kinds."""
    monkeypatch.setattr(proposal_fit, "STEPS", 15)
    networks, rng = untrained(widths=widths, spread=1.0).networks, np.random.default_rng(0)
    codes = rng.normal(0, 0.7, (24, networks.arch.latent)).astype(np.float32)
    codes[::2, : networks.arch.lobe] = (0.1, 0, 0, 1, 1.5, 0, 0.2)[: networks.arch.lobe]
    codes[1::2, : networks.arch.lobe] = lobes.no_lobe(widths)
    fitted, half = proposal_fit.fit_proposal(networks, codes), proposal.TERMS // 2
    np.testing.assert_array_equal(fitted["proposal.weight"][0, :half], 1)
    first = {name: np.zeros_like(x) for name, x in fitted.items()}
    first["proposal.weight"][0, :half] = first["proposal.overlap"][:] = 1
    first["proposal.bias"][:half] = -2  # the lobes of the rest reflect little

    wi = in_plane([10.0, 60.0])

    def log_variance(parameters) -> float:
        own = networks._replace(params={**networks.params, **parameters})
        found = [mixtures.variation(own, z, partial(networks.f, z), wi) for z in codes]
        return 2 * np.log(found).mean()

    assert log_variance(fitted) < log_variance(first) - 0.1
