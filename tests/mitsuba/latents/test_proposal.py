"""Proposals of codes in Dr.Jit are those of NumPy."""

import numpy as np
import pytest
from tests import mixtures
from tests.mitsuba.probes import pairs, vector
from tests.untrained import untrained

from urushi.nets import proposal
from urushi.nets.weights import Model, default_model


@pytest.fixture(scope="module", params=[1, 2], ids=["one width", "two widths"])
def model(request) -> Model:
    return default_model() if request.param == 1 else untrained(widths=2)


@pytest.fixture(scope="module")
def code(model) -> np.ndarray:
    """The code (size,) of a dielectric and a rest."""
    lobe = (0.2, 0, 0, 1, 1.5, 0, 0.1)[: model.arch.lobe]
    rest = 0.2 * np.random.default_rng(0).normal(size=model.arch.rest)
    return np.array([*lobe, *rest], np.float32)


def compare(mi, mixture, model, code, atol):
    """A mixture has the weights, widths and density of NumPy's."""
    wi, wo = pairs()
    own = model.networks.proposal(code[None], wi)
    found = np.stack([np.broadcast_to(x.numpy(), len(wi)) for x in mixture.weights], -1)
    np.testing.assert_allclose(found, mixtures.weights(own), atol=atol)
    density = mixtures.pdf(own, wi, wo)
    found = mixture.pdf(vector(wi), vector(wo)).numpy()
    np.testing.assert_allclose(found, density, rtol=10 * atol)


def proposals(model, code):
    from urushi.mitsuba.latents.lobe import kind_of
    from urushi.mitsuba.latents.proposal import CodeProposals

    return CodeProposals(model, kind_of(code[None, : model.arch.lobe]))


def mixture_of(mi, model, code, wi):
    """The mixture of a code in Dr.Jit."""
    size = model.arch.lobe
    terms = proposal.code_terms(model.params, code[size:])
    lobe, numbers = ([mi.Float(float(x)) for x in part] for part in (code[:size], terms))
    return proposals(model, code).proposal_of_terms(lobe, numbers, wi, mi.Float(float(code[-1])))


@pytest.mark.parametrize("eta", [1.5, 0.7])
def test_proposals_of_codes_agree_with_numpy(rgb, model, code, eta):
    code = np.array(code)
    code[4] = eta
    mixture = mixture_of(rgb, model, code, vector(pairs()[0]))
    compare(rgb, mixture, model, code, 1e-4)  # logarithms of small cosines are rounded


def test_tables_of_proposals_agree_with_numpy(rgb, model, code):
    own = proposals(model, code)
    table = [rgb.Float(x.ravel()) for x in own.tabulated(code)]
    mixture = own.proposal_of_table(table, vector(pairs()[0]))
    compare(rgb, mixture, model, code, 1e-2)  # linear between 129 cosines
