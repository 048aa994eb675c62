"""The linear basis in Dr.Jit agrees with NumPy and has exact derivatives."""

import drjit as dr
import numpy as np
import pytest
from tests.mitsuba.probes import pairs, vector

from urushi.nets.lobe import NO_LOBE
from urushi.nets.weights import Model, default_model

LOBES = ([0.2, 0, 0, 1, 1.5, 0], [0.1, 0.8, 1, 0, 1.5, 0], NO_LOBE)


@pytest.fixture(scope="module")
def shipped() -> Model:
    return default_model()


@pytest.fixture(scope="module")
def codes(shipped) -> np.ndarray:
    """Codes (3, size) of a dielectric, a metal and no lobe."""
    rest = np.random.default_rng(0).normal(size=(3, shipped.arch.functions)) * 0.2
    return np.concatenate([LOBES, rest], axis=1).astype(np.float32)


def decoder(mi, shipped, codes):
    """f of the codes, a function of directions."""
    from urushi.mitsuba.latents.basis import BasisDecoder
    from urushi.mitsuba.latents.lobe import ANY_LOBE

    found = BasisDecoder(shipped, ANY_LOBE)
    terms = found.code_terms([[mi.Float(float(x)) for x in channel] for channel in codes])
    return lambda wi, wo: found.f_of_terms(terms, wi, wo)


def test_f_agrees_with_numpy(variant, shipped, codes):
    import mitsuba as mi

    wi, wo = pairs()
    expected = shipped.networks.f(codes[:, None], wi, wo)
    f = decoder(mi, shipped, codes)(vector(wi), vector(wo))
    # functions of 16 bits: half a level of each, of 2.5e-4 of a logarithm at most
    np.testing.assert_allclose(np.array([x.numpy() for x in f]), expected, rtol=1e-3)


def test_derivatives_by_directions_are_differences(rgb, shipped, codes):
    of_pair = decoder(rgb, shipped, codes)

    def f(x):
        wi = dr.normalize(rgb.Vector3f(0.31 + x, 0.2, 0.9))
        return of_pair(wi, dr.normalize(rgb.Vector3f(-0.5, 0.17, 0.6)))[0]

    change = rgb.Float(0)
    dr.enable_grad(change)
    value = f(change)
    dr.forward(change)
    slope = (f(1e-3) - f(-1e-3)) / 2e-3  # within one cell of the table
    np.testing.assert_allclose(value.grad.numpy(), slope.numpy(), rtol=0.02)


def test_plugins_of_the_same_networks_share_a_table(rgb, shipped):
    from urushi.mitsuba.latents.basis import table_of

    first = table_of(shipped)
    assert table_of(shipped) is first
