"""The stages of a training, one after the other: what each trains, and on what."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from urushi.geometry.probe_pairs import probe_pairs
from urushi.nets.architecture import FIXED, PARTS, Architecture
from urushi.nets.features import direction_features
from urushi.nets.mlp import Params
from urushi.train import devices
from urushi.train.checkpoint import Checkpoint
from urushi.train.devices import Devices
from urushi.train.examples import Batches, Depth
from urushi.train.losses import compose, joint_loss
from urushi.train.optimiser import TrainState, compile_steps, start
from urushi.train.presets import Preset, Schedule
from urushi.train.stages.decoding import fresh_scatter, plain_loss, weighted_loss
from urushi.train.stages.layering import LayeringBatches, layering_loss, widened
from urushi.train.stages.quadratic_loss import measure_quadratic_losses
from urushi.train.stages.sampling import SamplerScene, sampler_loss

#: Stacks of each depth whose codes the proposal is trained on, at most.
SCENES = 1 << 15


class Learn(NamedTuple):
    """A stage's compiled steps, where their batches come from, and what shares the work."""

    steps: Callable[[TrainState, Any], tuple[TrainState, dict[str, jax.Array]]]
    batches: Callable[[int, int], Any]
    devices: Devices


@dataclass(frozen=True)
class Stage:
    """One stage.

    Attributes:
        trained: the networks that learn; all others are held. "scatter" is none of the model's,
            and ends with its stage.
        learn: from preset, schedule, examples by depth and all parameters so far.
    """

    trained: tuple[str, ...]
    learn: Callable[[Preset, Schedule, list[Depth], Params], Learn]


def networks_stage(
    preset: Preset, schedule: Schedule, depths: list[Depth], params: Params
) -> Learn:
    """Encoder, layerer and decoder together on the simulated stacks."""
    features = jnp.asarray(direction_features(*probe_pairs(preset.arch.probes)))
    fixed = {name: params[name] for name in FIXED}

    def loss(trained: Params, batch: Any) -> tuple[jax.Array, dict[str, jax.Array]]:
        return joint_loss({**fixed, **trained}, preset.first_arch, batch, features)

    shared = devices.find(sum(preset.stacks))
    batches = Batches(depths, preset.stacks, preset.seed)
    return Learn(compile_steps(loss, schedule, shared), batches.take, shared)


def layering_stage(
    preset: Preset, schedule: Schedule, depths: list[Depth], params: Params
) -> Learn:
    """The layerer, widened, on quadratic forms of the stacks, as many as fit into memory."""
    return _layering(preset, schedule, depths, params, preset.first_arch, preset.seed)


def relayering_stage(
    preset: Preset, schedule: Schedule, depths: list[Depth], params: Params
) -> Learn:
    """The layerer once more, on the forms that its stacks have by the decoder's last stage."""
    return _layering(preset, schedule, depths, params, preset.arch, preset.seed + 2)


def _layering(
    preset: Preset,
    schedule: Schedule,
    depths: list[Depth],
    params: Params,
    arch: Architecture,
    seed: int,
) -> Learn:
    """A stage of the layerer; arch: the sizes of `params`; seed: of its batches."""
    stacks, forms = preset.layering.stacks, []
    for depth in depths[1:]:
        forms.append(measure_quadratic_losses(params, arch, depth.first()))
        depth.forget()

    def loss(trained: Params, batch: Any) -> tuple[jax.Array, dict[str, jax.Array]]:
        return layering_loss(trained, preset.arch, batch)

    shared = devices.find(sum(stacks))
    batches = LayeringBatches(forms, stacks, seed)
    return Learn(compile_steps(loss, schedule, shared), batches.take, shared)


def decoding_stage(
    preset: Preset, schedule: Schedule, depths: list[Depth], params: Params
) -> Learn:
    """The decoder on the simulated stacks, whose codes stay as they are."""
    minimised = weighted_loss if preset.weigh_pairs else plain_loss

    def loss(trained: Params, batch: Any) -> tuple[jax.Array, dict[str, jax.Array]]:
        return minimised(trained, params, preset.arch, batch)

    shared = devices.find(sum(preset.stacks))
    batches = Batches(depths, preset.stacks, preset.seed + 1)
    return Learn(compile_steps(loss, schedule, shared), batches.take, shared)


def proposal_stage(
    preset: Preset, schedule: Schedule, depths: list[Depth], params: Params
) -> Learn:
    """The sampler on the latents that the other networks made; its batches are step numbers."""
    latents = all_latents(params, preset.arch, depths)
    scene = SamplerScene(dict(params), latents, jax.random.key(preset.seed))

    def loss(trained: Params, step: jax.Array) -> tuple[jax.Array, dict[str, jax.Array]]:
        return sampler_loss(trained, preset.arch, scene, step)

    def batches(step: int, steps: int) -> np.ndarray:
        return np.arange(step, step + steps, dtype=np.uint32)

    return Learn(compile_steps(loss, schedule), batches, Devices(None, 0))


STAGES = {
    "networks": Stage(("decoder", "encoder", "layerer"), networks_stage),
    "layering": Stage(("layerer",), layering_stage),
    "decoding": Stage(("decoder", "scatter"), decoding_stage),
    "relayering": Stage(("layerer",), relayering_stage),
    "proposal": Stage(("sampler",), proposal_stage),
}


def schedules(preset: Preset) -> dict[str, Schedule]:
    """The names of a training's stages, in order, and their schedules."""
    every = {
        "networks": preset.networks,
        "layering": preset.layering.schedule,
        "decoding": preset.decoding,
        "relayering": preset.relayering,
        "proposal": preset.proposal,
    }
    return {name: schedule for name, schedule in every.items() if schedule is not None}


def begin(name: str, preset: Preset, params: Params, seconds: float = 0.0) -> Checkpoint:
    """A stage's start.

    Args:
        name: the stage's.
        preset: the training.
        params: all parameters, as the stage before has left them; of the first stage, fresh ones.
        seconds: time spent so far.
    """
    stage = STAGES[name]
    trained = {k: v for k, v in params.items() if _of(k) in stage.trained and k not in FIXED}
    if name == "layering" and preset.layering.before is not None:
        wide = preset.arch.layerer
        trained = widened(params, preset.first_arch, "layerer", wide, preset.seed)
    if "scatter" in stage.trained and preset.weigh_pairs:
        trained |= fresh_scatter(preset.arch, preset.seed)
    made = {k: v for k, v in params.items() if _of(k) != "sampler" and k not in FIXED}
    state = start(trained, schedules(preset)[name])
    return Checkpoint(name, 0, seconds, state, {} if name == "networks" else made)


def learnt(average: Params) -> dict[str, Any]:
    """What a stage leaves to those after it, of the averages of what it has trained."""
    return {name: value for name, value in average.items() if _of(name) in PARTS}


def beginnings(preset: Preset, params: Params) -> dict[str, Checkpoint]:
    """Every stage's start from fresh parameters: what comes before is there in shape only."""
    first = {name: begin(name, preset, params) for name in ("networks", "layering")}
    wide = {**params, **first["layering"].state.params}
    return first | {
        name: begin(name, preset, wide) for name in schedules(preset) if name not in first
    }


def all_latents(params: Params, arch: Architecture, depths: list[Depth]) -> jax.Array:
    """Latent codes (M, 32) of training stacks of all depths, at most `SCENES` of each."""
    run = jax.jit(lambda probes, coats: compose(params, arch, probes, coats))
    codes = []
    for held in (depth.first() for depth in depths):
        some = slice(None, None, -(-len(held.probes) // SCENES))  # parts lie one after the other
        codes.append(run(held.probes[some], tuple(np.moveaxis(held.coats[some], 1, 0)[::-1])))
    return jnp.concatenate(codes)


def _of(name: str) -> str:
    """The network that a parameter belongs to."""
    return name.split(".")[0]
