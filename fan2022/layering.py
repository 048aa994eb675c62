"""Training of the layering network: it maps projected codes to projected codes, with an L1 loss."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from fan2022.architecture import parameters_of
from fan2022.inference import layer
from fan2022.preset import PaperPreset
from fan2022.representation import RULE, learnt, updated
from urushi.nets.mlp import Params

#: The learning rate, its factor at each decay, and the number of decays: the paper's rate decays
#: every 50 of 1,000 epochs.
RATE, DECAY, DECAYS = 3e-3, 0.7, 20

#: The learning rate on three layers, and layerings in a step.
FINETUNING_RATE, ROWS = 3e-4, 64


class Examples(NamedTuple):
    """Layerings: codes (N, 32) of dielectrics, lower parts and results; the media (N,)."""

    z_top: np.ndarray
    z_bottom: np.ndarray
    albedo: np.ndarray
    sigma_t: np.ndarray
    target: np.ndarray


class LayeringState(NamedTuple):
    """The layering network and Adam's state for it."""

    params: Params
    optimiser: Any


def start(params: Params) -> LayeringState:
    """The state before the first step."""
    params = jax.tree.map(jnp.asarray, parameters_of(params, "layering"))
    return LayeringState(params, RULE.init(params))


def examples(preset: PaperPreset, codes: dict[str, np.ndarray]) -> dict[str, Examples]:
    """The examples "train", "validation" (two layers) and "three-layer" from all parts' codes."""
    sets = {}
    for name, lower in (("two-layer", "conductor"), ("three-layer", "two-layer")):
        source, count = preset.data.parts[name]
        top, below, albedo, sigma_t = source.parts(slice(0, count))
        columns = codes["dielectric"][top], codes[lower][below], albedo, sigma_t, codes[name]
        sets[name] = Examples(*(np.asarray(column, np.float32) for column in columns))
    return {
        "train": Examples(*(column[: preset.trained] for column in sets["two-layer"])),
        "validation": Examples(*(column[preset.trained :] for column in sets["two-layer"])),
        "three-layer": sets["three-layer"],
    }


def l1_loss(params: Params, batch: Examples) -> jax.Array:
    """Mean |z_pred - z|."""
    z = layer(params, batch.z_top, batch.z_bottom, batch.albedo, batch.sigma_t)
    return jnp.mean(jnp.abs(z - batch.target))


@jax.jit
def step(state: LayeringState, batch: Examples, rate: float) -> tuple[LayeringState, jax.Array]:
    """Update the weights; returns the loss too."""
    loss, slope = jax.value_and_grad(l1_loss)(state.params, batch)
    return LayeringState(*updated(*state, slope, rate)), loss


def learn_epoch(
    state: LayeringState, sets: dict[str, Examples], preset: PaperPreset, epoch: int
) -> tuple[LayeringState, float]:
    """Take the steps of one epoch: on two layers for `layering_epochs`, then on three layers."""
    if epoch < preset.layering_epochs:
        period = max(1, preset.layering_epochs // DECAYS)
        data, rate = sets["train"], RATE * DECAY ** (epoch // period)
    else:
        data, rate = sets["three-layer"], FINETUNING_RATE
    order = np.random.default_rng((preset.seed, 1, epoch)).permutation(len(data.target))
    parts = np.array_split(order, -(-len(order) // ROWS))
    batches = (Examples(*(column[rows] for column in data)) for rows in parts)
    return learnt(step, state, batches, rate)
