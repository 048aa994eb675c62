"""Training from nothing to a weights file: data, stage after stage, export."""

import json
import os
import platform
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from urushi.data.generate import generate
from urushi.data.store import Store
from urushi.errors import FileError
from urushi.files import new_folder
from urushi.nets import weights
from urushi.nets.architecture import Architecture, init
from urushi.nets.encoder import input_statistics
from urushi.nets.mlp import Params
from urushi.platform import available_cores
from urushi.train import devices, examples, presets, validation
from urushi.train.checkpoint import Checkpoint, Journal
from urushi.train.examples import Depth
from urushi.train.optimiser import TrainState
from urushi.train.presets import Preset, Schedule
from urushi.train.stages.sampling import variation
from urushi.train.stages.stage import (
    STAGES,
    Learn,
    all_latents,
    begin,
    beginnings,
    learnt,
    schedules,
)
from urushi.train.validation import Check
from urushi.version import __version__

#: Where everything goes that the caller does not place: data, run folder and weights.
RUNS = Path("runs")


def train(
    preset: str | Preset,
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
    folder = Path(run) if run is not None else RUNS / preset.name
    out = Path(out) if out is not None else folder / "weights.safetensors"
    prepare(folder, out, resume)
    shared, plan = devices.find(sum(preset.stacks)), schedules(preset)
    names = list(plan)

    began = time.monotonic()
    store = generate(preset.data, data if data is not None else folder / "data.zarr")
    generated = time.monotonic() - began
    depths = examples.load(store, preset.arch, preset.pairs, preset.memory)
    checks = validation.load(store, preset.arch)
    made_for = identity(preset, store)
    journal = Journal(folder, made_for, names)

    params = initial(preset, depths)
    point = journal.restore(beginnings(preset, params)) if resume else None
    if point is None:
        journal.clear()
        point = begin("networks", preset, params)

    for name in names[names.index(point.stage) :]:
        params |= point.networks
        clock = time.monotonic()
        learn = STAGES[name].learn(preset, plan[name], depths, params)
        point = replace(point, seconds=point.seconds + time.monotonic() - clock)
        arch = preset.first_arch if name == "networks" else preset.arch
        report = partial(figures, {**params}, arch, checks)
        point = advance(point, plan[name], learn, report, journal)
        params |= learnt(learn.devices.collect(point.state.average))
        if name != names[-1]:
            point = begin(names[names.index(name) + 1], preset, params, point.seconds)
            journal.save(point)

    metrics = validation.measure(params, preset.arch, checks)
    latents = all_latents(params, preset.arch, depths)
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


def identity(preset: Any, store: Store) -> dict[str, Any]:
    """What a checkpoint must belong to: preset and data."""
    return {"preset": json.loads(json.dumps(preset.to_dict())), "data": store.hash()}


def prepare(folder: Path, out: Path, resume: bool) -> None:
    """Refuse what would fail at the end: an unwritable place, or a run that would be lost."""
    if not resume and Journal(folder, {}, ()).begun():
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
        "cost": {**cost, "processors": available_cores(), "machine": platform.machine()},
        "versions": {
            "urushi": __version__,
            "python": platform.python_version(),
            **packages,
        },
    }


def initial(preset: Preset, depths: list[Depth]) -> dict[str, Any]:
    """Fresh parameters, with the statistics of the bottoms at the probe pairs."""
    bottoms = np.concatenate([depth.first().probes for depth in depths])
    return {**init(preset.first_arch, preset.seed), **input_statistics(bottoms)}


def figures(
    params: Params, arch: Architecture, checks: list[Check], state: TrainState
) -> dict[str, float]:
    """What the validation parts say of parameters, those in `state` by their averages."""
    return validation.measure({**params, **state.average}, arch, checks)


def advance(
    point: Checkpoint,
    schedule: Schedule,
    learn: Learn,
    report: Callable[[TrainState], dict[str, float]],
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
                found = {name: float(value) for name, value in terms.items()} | report(state)
                seconds = spent + time.monotonic() - clock
                point = replace(point, step=done, seconds=seconds, state=state)
                bar.set_postfix({name: f"{value:.4f}" for name, value in found.items()})
                journal.log(point, found)
                journal.save(point)
    return replace(point, seconds=spent + time.monotonic() - clock)
