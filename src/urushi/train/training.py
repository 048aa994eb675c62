"""A whole training: simulate the data, run stage after stage, write the weights."""

import json
import os
import platform
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from tqdm import tqdm

from urushi.checks import CoatParameters
from urushi.core import error_metrics
from urushi.errors import FileError
from urushi.files import check_name, new_folder
from urushi.nets import weights
from urushi.nets.architecture import Architecture, init
from urushi.nets.decoder import decode
from urushi.nets.encoder import encode, input_statistics
from urushi.nets.layerer import layer
from urushi.nets.mlp import Params
from urushi.platform import available_cores
from urushi.train import examples, presets
from urushi.train.checkpoint import Checkpoint, Journal
from urushi.train.examples import METRICS, Depth, Examples
from urushi.train.optimiser import compile_steps, start
from urushi.train.presets import Preset
from urushi.train.stages import Stage, Task, parameters_of
from urushi.train.store import Store, generate

#: Default folder of data, checkpoints, logs and weights.
RUNS = Path("runs")


class Check(NamedTuple):
    """One validation part in memory, and the cosines (S, P) of its pairs."""

    metric: str
    examples: Examples
    cos_i: np.ndarray
    cos_o: np.ndarray


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
        preset: a name of `presets.NAMES`, or a preset.
        data: the data store, which is completed if necessary; default `runs/NAME/data`.
        out: the weights file; default `runs/NAME/weights.safetensors`.
        run: folder of the checkpoint and of `log.jsonl`; default `runs/NAME`.
        resume: continue from the run folder's checkpoint. The weights are bit for bit the same as
            of an uninterrupted training on the same machine and software.

    Returns:
        The trained model, as written to `out`.

    Raises:
        ParameterError: there is no such preset, or it does not fit its data.
        FileError: a file is foreign, damaged or cannot be written, or the run folder has a
            checkpoint and `resume` is not set.
    """
    preset = presets.get(preset) if isinstance(preset, str) else preset
    store, journal, out = prepare(preset, data, out, run, resume)
    stages, sizes = preset.stages, preset.architectures()
    names = [stage.name for stage in stages]
    depths = examples.load(store, preset.arch, preset.pairs)
    checks = load_checks(store, preset.arch)

    params = initial(preset, depths)
    point = journal.restore(beginnings(preset, params)) if resume else None
    if point is None:
        journal.clear()
        point = begin(preset, 0, params)

    for index in range(names.index(point.stage), len(stages)):
        stage, arch = stages[index], sizes[index + 1]
        params |= point.networks
        clock = time.monotonic()
        task = stage.task(params, arch, depths, preset.seed)
        point = replace(point, seconds=point.seconds + time.monotonic() - clock)
        report = partial(measure, {**params}, arch, checks)
        point = advance(point, stage, task, report, journal)
        params |= parameters_of(point.state.average, stage.trains)
        if index + 1 < len(stages):
            point = begin(preset, index + 1, params, point.seconds)
            journal.save(point)

    metrics = measure(params, preset.arch, checks)
    return weights.save(out, preset.arch, params, header(journal, metrics, point.seconds))


def begin(preset: Preset, index: int, params: Params, seconds: float = 0.0) -> Checkpoint:
    """The checkpoint before the first step of the preset's stage `index`.

    params: all parameters, as the stage before has left them; fresh ones for the first stage.
    seconds: time spent so far.
    """
    stage, arch = preset.stages[index], preset.architectures()[index + 1]
    state = start(stage.begin(params, arch, preset.seed), stage.schedule)
    earlier = {network for before in preset.stages[:index] for network in before.trains}
    return Checkpoint(stage.name, 0, seconds, state, parameters_of(params, earlier))


def beginnings(preset: Preset, params: Params) -> dict[str, Checkpoint]:
    """The first checkpoint of every stage by its name, from fresh parameters.

    Structure and shapes are right, the values that earlier stages learn are not.
    """
    points, params = {}, {**params}
    for index, stage in enumerate(preset.stages):
        points[stage.name] = begin(preset, index, params)
        params |= parameters_of(points[stage.name].state.params, stage.trains)
    return points


def prepare(
    preset: Any,
    data: str | os.PathLike | None,
    out: str | os.PathLike | None,
    run: str | os.PathLike | None,
    resume: bool,
) -> tuple[Store, Journal, Path]:
    """The data, the journal and the weights file of a training; the arguments are of `train`.

    Refuses unwritable places, and an earlier training that would be lost.
    """
    folder = Path(run) if run is not None else RUNS / preset.name
    out = Path(out) if out is not None else folder / "weights.safetensors"
    check_name(out)
    if not resume and Journal(folder, {}).begun():
        raise FileError(
            f"'{folder}' contains an unfinished training; give --resume to continue it, "
            "or choose another run folder"
        )
    for place in (folder, out.parent):
        new_folder(place)
        if not os.access(place, os.W_OK):
            raise FileError(f"cannot write into '{place}'; choose a folder that is writable")
    if out.is_dir():
        raise FileError(f"cannot write '{out}': it is a folder; give the name of a file")
    began = time.monotonic()
    store = generate(preset.data, data if data is not None else folder / "data")
    generated = time.monotonic() - began
    origin = {"preset": json.loads(json.dumps(preset.to_dict())), "data": store.hash()}
    return store, Journal(folder, origin, generated), out


def header(journal: Journal, metrics: dict[str, float], seconds: float) -> dict[str, Any]:
    """The weights file's record of its training; seconds: spent after the data were made."""
    packages = {name: version(name) for name in ("urushi", "jax", "optax", "numpy")}
    return {
        **journal.identity,
        "seed": journal.identity["preset"]["seed"],
        "metrics": metrics,
        "cost": {
            "data seconds": round(journal.data_seconds),
            "training seconds": round(seconds),
            "processors": available_cores(),
            "machine": platform.machine(),
        },
        "versions": {"python": platform.python_version(), **packages},
    }


def initial(preset: Preset, depths: list[Depth]) -> dict[str, Any]:
    """Fresh parameters, with the statistics of the bottoms' values at the probe pairs."""
    bottoms = np.concatenate([depth.examples().probes for depth in depths])
    return {**init(preset.architectures()[0], preset.seed), **input_statistics(bottoms)}


def advance(
    point: Checkpoint,
    stage: Stage,
    task: Task,
    report: Callable[[Params], dict[str, float]],
    journal: Journal,
) -> Checkpoint:
    """Take the remaining steps of a stage, with log lines and checkpoints by its schedule.

    report: validation errors by the averages of the parameters that learn.
    """
    schedule = stage.schedule
    steps = compile_steps(task.loss, schedule)
    state, clock, spent = point.state, time.monotonic(), point.seconds
    bar = tqdm(total=schedule.steps, initial=point.step, desc=point.stage, disable=None)
    with bar:
        for step in range(point.step, schedule.steps, schedule.steps_per_call):
            state, terms = steps(state, task.batches(step, schedule.steps_per_call))
            done = step + schedule.steps_per_call
            bar.update(schedule.steps_per_call)
            if done % schedule.checkpoint_every == 0 or done == schedule.steps:
                logged = {name: float(x) for name, x in terms.items()} | report(state.average)
                seconds = spent + time.monotonic() - clock
                point = replace(point, step=done, seconds=seconds, state=state)
                bar.set_postfix({name: f"{value:.4f}" for name, value in logged.items()})
                journal.save(point, logged)
    return replace(point, seconds=spent + time.monotonic() - clock)


def load_checks(store: Store, arch: Architecture) -> list[Check]:
    """Read the validation parts of a store."""
    checks = []
    for index, part in enumerate(store.spec.parts):
        if part.directions in METRICS:
            held = Depth(store, [index], arch, part.pairs).examples()
            cos_i, cos_o = (store.read(part)[name][..., 2] for name in ("wi", "wo"))
            checks.append(Check(METRICS[part.directions], held, cos_i, cos_o))
    return checks


def measure(
    params: Params, arch: Architecture, checks: list[Check], learnt: Params | None = None
) -> dict[str, float]:
    """E mean and P median, as fractions; they include the noise of the reference.

    learnt: replace some of the parameters.
    """
    params = {**params, **(learnt or {})}
    host: dict[str, Any] = {name: np.asarray(value) for name, value in params.items()}
    figures = {}
    for check in checks:
        held = check.examples
        z = np.concatenate([held.lobes, encode(host, arch, held.probes)], axis=-1)
        for coat in np.moveaxis(held.coats, 1, 0)[::-1]:  # the lowest first
            z = layer(host, arch, z, CoatParameters.of_columns(coat.T))
        f_hat = held.top + decode(host, arch, z[:, None, arch.lobe :], held.features)
        if check.metric == "E mean":
            errors = error_metrics.stack_error(f_hat, held.f, check.cos_i, check.cos_o)
            figures[check.metric] = float(errors.mean())
        else:
            figures[check.metric] = float(np.median(error_metrics.pair_error(f_hat, held.f)))
    return figures
