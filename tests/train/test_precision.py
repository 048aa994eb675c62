"""bfloat16 rounds only the factors of the hidden products."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from urushi.core.direction_sets import training_pairs
from urushi.errors import ParameterError
from urushi.nets.architecture import Architecture, init
from urushi.nets.decoder import decode
from urushi.nets.features import direction_features
from urushi.train.optimiser import Schedule, compile_steps, lowered, start

ARCH = Architecture(
    latent=10, decoder=(32, 32), encoder=(8, 8), layerer=(8,), sampler=(8,), probes=8
)
PARAMS = {name: jnp.asarray(value) for name, value in init(ARCH, 0).items()}
LOW = lowered(PARAMS, "bfloat16")


def features(n=256):
    return jnp.asarray(direction_features(*training_pairs(np.random.default_rng(0), n)))


def test_only_matrices_between_two_hidden_layers_are_lowered():
    low = {name for name, value in LOW.items() if value.dtype == jnp.bfloat16}
    assert low == {"decoder.1.weight", "encoder.1.weight"}  # the others have one hidden layer
    assert all(value is PARAMS[name] for name, value in LOW.items() if name not in low)
    assert lowered(PARAMS, "float32") == PARAMS


def test_the_decoder_differs_by_the_rounding_of_one_layer():
    z = jnp.ones((256, ARCH.latent - ARCH.lobe))
    exact, rounded = (np.asarray(decode(p, ARCH, z, features())) for p in (PARAMS, LOW))
    assert rounded.dtype == np.float32
    error = np.abs(np.log(rounded / exact))
    # 32 products with factors of 8 bits: each is wrong by about 2^-9 of it, and so is their sum.
    assert 0 < error.max() < 0.05


def test_reciprocity_survives():
    wi, wo = training_pairs(np.random.default_rng(1), 256)
    z = jnp.ones((256, ARCH.latent - ARCH.lobe))
    there, back = (
        decode(LOW, ARCH, z, jnp.asarray(direction_features(*pair)))
        for pair in ((wi, wo), (wo, wi))
    )
    np.testing.assert_array_equal(there, back)


def test_training_in_bfloat16_learns_and_keeps_float32_weights():
    """A lobe over the features, learnt by the decoder with rounded products."""
    schedule = Schedule(
        300, 10, 1e-2, average=0.9, steps_per_call=50, checkpoint_every=50, precision="bfloat16"
    )
    inputs = features()
    z = jnp.zeros((256, ARCH.latent - ARCH.lobe))
    target = -inputs[:, 0]

    def loss(params, _):
        error = jnp.mean((jnp.log(decode(params, ARCH, z, inputs)) - target) ** 2)
        return error, {"loss": error}

    trained = {name: value for name, value in PARAMS.items() if name.startswith("decoder.")}
    state, steps = start(trained, schedule), compile_steps(loss, schedule)
    for first in range(0, schedule.steps, 50):
        state, terms = steps(state, np.arange(first, first + 50, dtype=np.uint32))
    assert all(leaf.dtype == jnp.float32 for leaf in jax.tree.leaves((state.params, state.average)))
    # The rounding of one layer leaves an error of the order of 0.01 in a function of variance one.
    assert float(terms["loss"]) < 3e-3


def test_errors_name_an_unknown_precision():
    with pytest.raises(ParameterError, match="precision is 'half'; choose one of float32, bfloat"):
        Schedule(8, 1, 1e-3, steps_per_call=4, checkpoint_every=4, precision="half")


def test_errors_name_an_unknown_rule():
    with pytest.raises(ParameterError, match="rule is 'sgd'; choose one of muon, soap"):
        Schedule(8, 1, 1e-3, steps_per_call=4, checkpoint_every=4, rule="sgd")
