"""The paper's networks: sizes and formulas."""

import jax
import numpy as np
import pytest
from fan2022 import PaperNetworks, architecture, inference
from fan2022.architecture import ALL, EVALUATION, LAYERING, PaperArchitecture
from fan2022.inference import direction_inputs, evaluate, proxy

from urushi.errors import ParameterError

ARCH = PaperArchitecture()


@pytest.fixture(scope="module")
def inputs(pairs):
    rng = np.random.default_rng(2)
    z = (1 + 0.5 * rng.normal(size=(300, 32))).astype(np.float32)
    wi, wo = (w[:300] for w in pairs)
    return z, direction_inputs(wi, wo)


def test_sizes_are_the_papers():
    for network, count in ((EVALUATION, 1_074_689), (LAYERING, 1_954_208)):
        assert sum(map(np.prod, architecture.shapes(network).values())) == count
    shapes = architecture.shapes(ALL)
    widths = [shapes[f"proxy.{i}.weight"][1] for i in range(5)]
    assert widths == [128, 512, 128, 32, 2]


def test_inputs_are_view_and_light_in_the_papers_order(params, inputs):
    """Before the code; `test_published` has the networks themselves."""
    view, light = np.array([[0.1, 0.2, 0.3]]), np.array([[0.4, 0.5, 0.6]])
    np.testing.assert_array_equal(direction_inputs(view, light), [[0.1, 0.2, 0.4, 0.5, 0.3, 0.6]])
    whole = np.concatenate(inputs[::-1], axis=-1)
    expected = architecture.apply(params, EVALUATION, whole)[..., 0]
    np.testing.assert_allclose(evaluate(params, *inputs), expected, atol=1e-4)


def test_numpy_and_jax_agree(params, inputs):
    z, directions = inputs
    there = jax.jit(evaluate)(params, z, directions)
    np.testing.assert_allclose(evaluate(params, z, directions), there, atol=1e-5)
    medium = np.full(len(z), 0.5, np.float32)
    ours = inference.layer(params, z, z[::-1], medium, medium)
    there = jax.jit(inference.layer)(params, z, z[::-1], medium, medium)
    np.testing.assert_allclose(ours, there, atol=1e-5)
    for a, b in zip(proxy(params, z), jax.jit(proxy)(params, z), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-4)


def test_isotropic_media_stay_and_absorption_does_for_all():
    albedo, sigma_t = np.array([0.0, 0.5, 1.0]), np.array([1.0, 2.0, 3.0])
    same = inference.isotropic(albedo, sigma_t, 0.0)
    np.testing.assert_array_equal(same, (albedo, sigma_t))
    other, thickness = inference.isotropic(albedo, sigma_t, 0.7)
    np.testing.assert_allclose(thickness * (1 - other), sigma_t * (1 - albedo), atol=1e-12)
    np.testing.assert_allclose(thickness * other, sigma_t * albedo * 0.3, atol=1e-12)


def test_other_sizes_and_missing_parameters_are_refused(params):
    for text in (
        '{"kind": "paper", "latent": 16}',
        '{"kind": "paper", "adam": {"steps": 3}}',
        "[]",
    ):
        with pytest.raises(ParameterError, match="takes no options but the projection"):
            PaperArchitecture.from_json(text)
    with pytest.raises(ParameterError, match="'evaluation.0.bias' is missing"):
        less = {k: v for k, v in params.items() if k != "evaluation.0.bias"}
        PaperNetworks(ARCH, less, {})
