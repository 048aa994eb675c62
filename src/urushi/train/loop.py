"""Training from nothing to a weights file: data, networks, proposal, export."""

import json
import os
import platform
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from tqdm import tqdm

import urushi
from urushi.data.generate import generate
from urushi.data.store import Store
from urushi.errors import FileError
from urushi.files import new_folder
from urushi.nets import weights
from urushi.nets.architecture import FIXED, Architecture, Params, init
from urushi.nets.encoder import input_statistics
from urushi.nets.features import direction_features
from urushi.nets.probes import probe_pairs
from urushi.processors import available
from urushi.train import devices, examples, presets, validation
from urushi.train.checkpoint import Checkpoint
from urushi.train.devices import Devices
from urushi.train.examples import Batches, Depth
from urushi.train.journal import Journal
from urushi.train.losses import compose, joint_loss
from urushi.train.optimiser import State, compile_steps, start
from urushi.train.paper.preset import PaperPreset
from urushi.train.presets import Preset, Schedule
from urushi.train.proposal import Scene, proposal_loss, variation

#: Where everything goes that the caller does not place: data, run folder and weights.
RUNS = Path("runs")

#: Stacks of each depth whose codes the proposal is trained on, at most.
SCENES = 1 << 15


def train(
    preset: str | Preset | PaperPreset,
    *,
    data: str | os.PathLike | None = None,
    out: str | os.PathLike | None = None,
    run: str | os.PathLike | None = None,
    resume: bool = False,
) -> weights.Model:
    """Train all networks and write the weights.

    Args:
        preset: a name of `presets.NAMES`, or the value itself.
        data: the data store, generated where it is missing or incomplete; default
            `runs/NAME/data.zarr`.
        out: the weights file; default `runs/NAME/weights.safetensors`.
        run: folder of the checkpoint and of `log.jsonl`; default `runs/NAME`.
        resume: go on from the run folder's checkpoint. The weights are those that an
            uninterrupted training gives, bit for bit on the same machine and software.

    Returns:
        The trained model, as written to `out`.

    Raises:
        ParameterError: no such preset, or it does not fit its data.
        FileError: a file is foreign, damaged or cannot be written, or the run folder has a
            checkpoint and `resume` is not set.

    Several JAX devices share the stacks of each step; see `devices`.
    """
    preset = presets.get(preset) if isinstance(preset, str) else preset
    if isinstance(preset, PaperPreset):
        from urushi.train.paper import loop as paper  # it needs this module

        return paper.train(preset, data=data, out=out, run=run, resume=resume)
    folder = Path(run) if run is not None else RUNS / preset.name
    out = Path(out) if out is not None else folder / "weights.safetensors"
    prepare(folder, out, resume)
    shared = devices.find(sum(preset.stacks))

    began = time.monotonic()
    store = generate(preset.data, data if data is not None else folder / "data.zarr")
    generated = time.monotonic() - began
    depths = examples.load(store, preset.arch, preset.pairs, preset.memory)
    checks = validation.load(store, preset.arch)
    made_for = identity(preset, store)
    journal = Journal(folder, made_for)

    params = initial(preset, depths)
    point = journal.restore(beginnings(preset, params)) if resume else None
    if point is None:
        journal.clear()
        point = beginnings(preset, params)["networks"]

    if point.stage == "networks":

        def report(state: State) -> dict[str, float]:
            return validation.measure({**params, **state.average}, preset.arch, checks)

        learn = networks_stage(preset, depths, params, shared)
        point = advance(point, preset.networks, learn, report, journal)
        proposal = beginnings(preset, params)["proposal"]
        networks = shared.collect(point.state.average)
        point = replace(proposal, seconds=point.seconds, networks=networks)
        journal.save(point)

    params |= point.networks
    latents = all_latents(params, preset.arch, depths)
    learn = proposal_stage(preset, params, latents)
    point = advance(point, preset.proposal, learn, lambda state: {}, journal)
    params |= point.state.average

    metrics = validation.measure(params, preset.arch, checks)
    spread = np.asarray(variation(params, preset.arch, latents, seed=preset.seed + 1))
    metrics |= {
        "sampling cv median": float(np.median(spread)),
        "sampling cv p95": float(np.percentile(spread, 95)),
    }
    cost = {
        "data seconds": round(generated),
        "training seconds": round(point.seconds),
        "devices": shared.count,
    }
    return weights.save(out, preset.arch, params, header(made_for, metrics, cost))


def identity(preset: Preset | PaperPreset, store: Store) -> dict[str, Any]:
    """What a checkpoint must belong to: preset and data."""
    return {"preset": json.loads(json.dumps(preset.to_dict())), "data": store.hash()}


def prepare(folder: Path, out: Path, resume: bool) -> None:
    """Refuse what would fail at the end: an unwritable place, or a run that would be lost."""
    if not resume and Journal(folder, {}).begun():
        raise FileError(
            f"'{folder}' holds a training that was begun; give --resume to go on with it, "
            "or choose another run folder"
        )
    for place in (folder, out.parent):
        new_folder(place)
        if not os.access(place, os.W_OK):
            raise FileError(f"cannot write into '{place}'; choose a folder that is writable")
    if out.is_dir():
        raise FileError(f"cannot write '{out}': it is a folder; give the name of a file")


def header(
    made_for: dict[str, Any], metrics: dict[str, float], cost: dict[str, int]
) -> dict[str, Any]:
    """What the weights file says of its making."""
    packages = {name: version(name) for name in ("jax", "optax", "numpy")}
    return {
        "preset": made_for["preset"],
        "seed": made_for["preset"]["seed"],
        "data": made_for["data"],
        "metrics": metrics,
        "cost": {**cost, "processors": available(), "machine": platform.machine()},
        "versions": {
            "urushi": urushi.__version__,
            "python": platform.python_version(),
            **packages,
        },
    }


def initial(preset: Preset, depths: list[Depth]) -> dict[str, Any]:
    """Fresh parameters, with the statistics of the bottoms at the probe pairs."""
    bottoms = np.concatenate([depth.first().probes for depth in depths])
    return {**init(preset.arch, preset.seed), **input_statistics(bottoms)}


def beginnings(preset: Preset, params: Params) -> dict[str, Checkpoint]:
    """Each stage's start. The encoder's input statistics are fixed and in neither."""
    sampler = {name: value for name, value in params.items() if name.startswith("sampler.")}
    others = {
        name: value for name, value in params.items() if name not in sampler and name not in FIXED
    }
    return {
        "networks": Checkpoint("networks", 0, 0.0, start(others, preset.networks), {}),
        "proposal": Checkpoint("proposal", 0, 0.0, start(sampler, preset.proposal), others),
    }


@dataclass(frozen=True)
class Learn:
    """A stage's compiled steps and where their batches come from."""

    steps: Callable[[State, Any], tuple[State, dict[str, jax.Array]]]
    batches: Callable[[int, int], Any]


def networks_stage(preset: Preset, depths: list[Depth], params: Params, shared: Devices) -> Learn:
    """Encoder, layerer and decoder on the simulated stacks."""
    features = jnp.asarray(direction_features(*probe_pairs(preset.arch.probes)))
    fixed = {name: params[name] for name in FIXED}

    def loss(trained: Params, batch: Any) -> tuple[jax.Array, dict[str, jax.Array]]:
        return joint_loss({**fixed, **trained}, preset.arch, batch, features)

    batches = Batches(depths, preset.stacks, preset.seed)
    return Learn(compile_steps(loss, preset.networks, shared), batches.take)


def proposal_stage(preset: Preset, params: Params, latents: jax.Array) -> Learn:
    """The sampler on the latents that the other networks made; its batches are step numbers."""
    scene = Scene(dict(params), latents, jax.random.key(preset.seed))

    def loss(trained: Params, step: jax.Array) -> tuple[jax.Array, dict[str, jax.Array]]:
        return proposal_loss(trained, preset.arch, scene, step)

    return Learn(
        compile_steps(loss, preset.proposal),
        lambda step, steps: np.arange(step, step + steps, dtype=np.uint32),
    )


def advance(
    point: Checkpoint,
    schedule: Schedule,
    learn: Learn,
    report: Callable[[State], dict[str, float]],
    journal: Journal,
) -> Checkpoint:
    """Take the rest of a stage's steps, with a log line and a checkpoint now and then."""
    state, clock, spent = point.state, time.monotonic(), point.seconds
    bar = tqdm(total=schedule.steps, initial=point.step, desc=point.stage, disable=None)
    with bar:
        for step in range(point.step, schedule.steps, schedule.steps_per_call):
            batches = learn.batches(step, schedule.steps_per_call)
            state, terms = learn.steps(state, batches)
            done = step + schedule.steps_per_call
            bar.update(schedule.steps_per_call)
            if done % schedule.checkpoint_every == 0 or done == schedule.steps:
                figures = {name: float(value) for name, value in terms.items()} | report(state)
                seconds = spent + time.monotonic() - clock
                point = replace(point, step=done, seconds=seconds, state=state)
                bar.set_postfix({name: f"{value:.4f}" for name, value in figures.items()})
                journal.log(point, figures)
                journal.save(point)
    return replace(point, seconds=spent + time.monotonic() - clock)


def all_latents(params: Params, arch: Architecture, depths: list[Depth]) -> jax.Array:
    """Latent codes (M, 32) of training stacks of all depths, at most `SCENES` of each."""
    run = jax.jit(lambda probes, coats: compose(params, arch, probes, coats))
    codes = []
    for held in (depth.first() for depth in depths):
        some = slice(None, None, -(-len(held.probes) // SCENES))  # parts lie one after the other
        codes.append(run(held.probes[some], tuple(np.moveaxis(held.coats[some], 1, 0)[::-1])))
    return jnp.concatenate(codes)
