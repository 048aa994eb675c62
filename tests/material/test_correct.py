"""Corrected codes are closer to the encoded BRDFs, and nothing else changes."""

import numpy as np
import pytest

from urushi.core.error_metrics import DARK_OFFSET
from urushi.material.correction import correct_codes
from urushi.material.encode import bare_anchors, material_from_values
from urushi.walk import analytic, conductor, dielectric, diffuse

SURFACES = (
    conductor(0.03, (0.95, 0.6, 0.3)),
    conductor(0.5, (0.9, 0.5, 0.1)),
    dielectric(0.1, 1.5),
    diffuse((0.8, 0.3, 0.05)),
)


@pytest.fixture(scope="module")
def surfaces(trained) -> np.ndarray:
    """Values (12, P) of plain surfaces, three channels each."""
    pairs = trained.networks.pairs()
    return np.concatenate([analytic.f(surface, *pairs).T for surface in SURFACES])


def errors(trained, z, f):
    """Huber's loss (C,) of the logarithms at the probe pairs."""
    f_hat = trained.networks.f(z[:, None], *trained.networks.pairs())
    size = np.abs(np.log((f_hat + DARK_OFFSET) / (f + DARK_OFFSET)))
    return np.where(size < 0.5, size**2, size - 0.25).sum(axis=1)


def test_correction_brings_codes_closer(trained, surfaces):
    z = trained.networks.encode(surfaces)
    before, after = (
        errors(trained, c, surfaces) for c in (z, correct_codes(trained.networks, z, surfaces))
    )
    assert (after <= before * (1 + 1e-5)).all()
    assert np.sqrt(after).mean() < 0.9 * np.sqrt(before).mean()


def test_no_code_gets_worse_whatever_the_networks_and_values(trained, model):
    rng = np.random.default_rng(0)
    pairs = len(trained.networks.pairs()[0])
    odd = np.stack(
        [
            np.zeros(pairs),
            np.full(pairs, 1e4),
            np.where(np.arange(pairs) % 2, 0.3, 0.0),
            rng.lognormal(0, 3, pairs),
        ]
    ).astype(np.float32)
    for networks in (trained, model):
        z = networks.networks.encode(odd)
        found = correct_codes(networks.networks, z, odd)
        assert np.isfinite(found).all()
        assert (errors(networks, found, odd) <= errors(networks, z, odd) * (1 + 1e-5)).all()


def test_materials_keep_the_encoders_codes_for_coats(trained, surfaces):
    """Of metals over a diffuse share, so that the fitted lobe leaves a rest that matters."""
    values = np.float32(0.5) * surfaces[:3] + np.float32(0.1 / np.pi)
    material = material_from_values(values.T, trained)
    expected = trained.networks.encode(values)
    np.testing.assert_allclose(material.anchors, expected, rtol=1e-4, atol=1e-4)
    assert not np.array_equal(material.anchors, material.latents)


def test_a_lobe_that_is_the_whole_source_has_the_anchor_of_a_bare_surface(trained, surfaces):
    """The code of its misfit decodes to more than the misfit, so that it is left out."""
    anchors = material_from_values(surfaces[:3].T, trained).anchors
    assert np.array_equal(anchors, bare_anchors(trained, anchors[:, : trained.arch.lobe]))


def test_channels_are_corrected_by_themselves(trained, surfaces):
    z = trained.networks.encode(surfaces)
    together = correct_codes(trained.networks, z, surfaces)
    alone = np.concatenate(
        [correct_codes(trained.networks, z[k : k + 1], surfaces[k : k + 1]) for k in range(len(z))]
    )
    f = [
        trained.networks.f(codes[:, None], *trained.networks.pairs()) for codes in (together, alone)
    ]
    np.testing.assert_allclose(f[0], f[1], rtol=2e-3)  # a step magnifies rounding errors
