"""A whole training: tables, basis, layering network, proposals, and the weights file."""

import functools
import json
import os
import platform
import time
from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from urushi.core.probe_pairs import pair_measure
from urushi.errors import FileError
from urushi.files import check_name, new_folder
from urushi.nets import weights
from urushi.nets.transmittance import has_edges
from urushi.platform import available_cores
from urushi.train import basis_fit, layering, presets, tables
from urushi.train.checkpoint import Checkpoint, Journal
from urushi.train.layering import Layerings
from urushi.train.optimiser import compile_steps, start
from urushi.train.presets import Preset
from urushi.train.proposal_fit import fit_proposal
from urushi.train.tables import TableStore

#: Default folder of data, checkpoints, logs and weights.
RUNS = Path("runs")

#: Stride of the stacks that are held out for the metrics.
HELD_OUT = 10


def train(
    preset: str | Preset,
    *,
    data: str | os.PathLike | None = None,
    out: str | os.PathLike | None = None,
    run: str | os.PathLike | None = None,
    resume: bool = False,
    cluster: str | None = None,
) -> weights.Model:
    """Make basis and layering network, and write the weights.

    Args:
        preset: a name of `presets.NAMES`, or a preset.
        data: the folder of tables, which is completed if necessary; default `runs/NAME/data`.
        out: the weights file; default `runs/NAME/weights.safetensors`.
        run: folder of the checkpoint and of `log.jsonl`; default `runs/NAME`.
        resume: continue from the run folder's checkpoint. The weights are bit for bit the same as
            of an uninterrupted training on the same machine and software.
        cluster: where the tables are computed, see `workers.results`; default this machine's cores.

    Returns:
        The trained model, as written to `out`.

    Raises:
        ParameterError: there is no such preset, or the cluster cannot be read.
        PlatformError: the cluster does not answer, see `workers.results`.
        FileError: a file is foreign, damaged or cannot be written, or the run folder has a
            checkpoint and `resume` is not set.
    """
    preset = presets.get(preset) if isinstance(preset, str) else preset
    generate = functools.partial(tables.generate, cluster=cluster)
    store, journal, out = prepare(preset, data, out, run, resume, generate)
    beginning = layering.fresh(preset.arch, preset.seed)
    if preset.beginning:
        beginning = layering.widened(weights.shipped(preset.beginning), preset.arch)
    first = Checkpoint("layering", 0, 0.0, start(beginning, preset.schedule), {})
    point = journal.restore({"layering": first}) if resume else None  # refused at once
    began = time.monotonic()
    model, codes, metrics = fitted_basis(preset, store)
    found, stacks = layerings(model, store, cluster)
    hidden = stacks % HELD_OUT == 0
    known, others = found.taken(~hidden), found.taken(hidden)
    if preset.arch.widths == 2:
        images = layering.mirrored(known, preset.arch.factors[1:])
        known = Layerings(*map(np.concatenate, zip(known, images, strict=True)))
    if point is None:
        journal.clear()
        point = first
    else:
        began = time.monotonic() - point.seconds  # as if earlier runs had been a part of this one
    average = learn(point, preset, known, others, journal, began)
    params = dict(model.params) | average | fit_proposal(model.networks, codes)
    metrics |= measure(average, preset, others)
    seconds = time.monotonic() - began
    return weights.save(out, preset.arch, params, header(journal, metrics, seconds))


def fitted_basis(
    preset: Preset, store: TableStore
) -> tuple[weights.Model, np.ndarray, dict[str, float]]:
    """A model with the basis alone, codes (N, L) of fitted materials, and the errors E of others.

    E is that of codes from the probe pairs, over all nodes, for coated materials that are held out.
    """
    arch, names = preset.arch, ["table", "lobe", "level", "stack"]
    held = store.read(names + ["probes", "stretch"] * (arch.widths == 2))
    every, rows = basis_fit.prepared(basis_fit.materials(held))
    held = {name: array[rows] for name, array in held.items()}
    hidden, coated = held["stack"] % HELD_OUT == 0, held["level"] > 0
    # Few have edges, and cost the others more than they gain.
    learnt, factors = ~hidden & ~has_edges(held["lobe"]), arch.factors[1:]
    if arch.widths == 2:  # functions for bare mixtures, which are few, would cost coats more
        learnt &= coated
    known = every.taken(np.flatnonzero(learnt))
    if arch.widths == 1:
        given = np.tile(np.array([0, 1], np.float32), (every.logs.shape[2], 1))  # the constant
        rest = basis_fit.probed(held, arch.probes)[learnt]
        measure = basis_fit.probe_measure(rest, known.rest().ravel())
    else:
        given = weights.shipped(preset.beginning).params["basis.rows"]
        measure = pair_measure(arch.probes)
    functions, prior = basis_fit.fit_basis(known, given, factors)
    params = {name: np.zeros(shape, np.float32) for name, shape in arch.parameter_shapes().items()}
    params |= {"basis.rows": functions, "basis.measure": measure, "basis.prior": prior}
    model = weights.Model.of(arch, params, {})
    codes = basis_fit.bottom_codes(model, held)
    unseen, numbers = every.taken(np.flatnonzero(hidden & coated)), codes[hidden & coated]
    numbers = numbers[:, arch.lobe : arch.lobe + arch.functions]
    errors = unseen.errors(unseen.at_nodes(functions)[:, 1:], factors, numbers)
    return model, codes[~hidden], _figures("E of codes", errors)


def layerings(
    model: weights.Model, store: TableStore, cluster: str | None = None
) -> tuple[Layerings, np.ndarray]:
    """All examples of a store, and the numbers (N,) of their stacks.

    model: with the basis. Of two widths, coats over its codes are computed first. cluster: where
    they are computed, see `workers.results`.
    """
    names = ("over", "coated", "stack")
    if model.widths == 2:
        store = tables.generate_coats(store, model, cluster)
        held = store.read(("bottom", *names))
    else:
        held = store.read(("table", "lobe", *names))
        held["bottom"] = basis_fit.bottom_codes(model, held)
    found = layering.examples(model.networks.basis, held["bottom"], held["over"], held["coated"])
    return found, np.repeat(held["stack"], held["over"].shape[1])


def _figures(name: str, errors: np.ndarray) -> dict[str, float]:
    """Mean and 95th percentile by name."""
    return {f"{name}, mean": float(errors.mean()), f"{name}, p95": float(np.percentile(errors, 95))}


def measure(params: Any, preset: Preset, found: Layerings) -> dict[str, float]:
    """Errors of the layering network: roots of q (see `layering`), about E."""
    host = {name: np.asarray(value) for name, value in params.items()}
    errors = np.sqrt(layering.squares(host, preset.arch, found))
    return _figures("layering network", errors)


def prepare(
    preset: Any,
    data: str | os.PathLike | None,
    out: str | os.PathLike | None,
    run: str | os.PathLike | None,
    resume: bool,
    generate: Callable[[Any, Path], TableStore],
) -> tuple[TableStore, Journal, Path]:
    """The data, the journal and the weights file of a training; the arguments are of `train`.

    generate: makes or completes the data of `preset.data` in a folder.

    Raises:
        FileError: a folder is not writable, or the run folder has a training already.
    """
    folder = Path(run) if run is not None else RUNS / preset.name
    out = Path(out) if out is not None else folder / "weights.safetensors"
    check_name(out)
    if not resume and Journal(folder, {}).begun():
        raise FileError(
            f"'{folder}' contains a training already; give --resume to continue it, "
            "or choose another run folder"
        )
    for place in (folder, out.parent):
        new_folder(place)
        if not os.access(place, os.W_OK):
            raise FileError(f"cannot write into '{place}'; choose a folder that is writable")
    if out.is_dir():
        raise FileError(f"cannot write '{out}': it is a folder; give the name of a file")
    began = time.monotonic()
    store = generate(preset.data, Path(data) if data is not None else folder / "data")
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


def learn(
    point: Checkpoint,
    preset: Preset,
    known: Layerings,
    hidden: Layerings,
    journal: Journal,
    began: float,
) -> dict[str, np.ndarray]:
    """The parameters "layerer.*" after the remaining steps, with log lines and checkpoints.

    known: examples to learn from. hidden: others, whose errors are logged. began: on the monotonic
    clock [s].
    """
    schedule, arch, state = preset.schedule, preset.arch, point.state
    steps = compile_steps(lambda params, batch: layering.loss(params, arch, batch), schedule)
    bar = tqdm(total=schedule.steps, initial=point.step, desc=point.stage, disable=None)
    with bar:
        for step in range(point.step, schedule.steps, schedule.steps_per_call):
            batches = layering.batches(
                known, preset.batch, preset.seed, step, schedule.steps_per_call
            )
            state, loss = steps(state, batches)
            done = step + schedule.steps_per_call
            bar.update(schedule.steps_per_call)
            if done % schedule.checkpoint_every == 0 or done == schedule.steps:
                figures = {"loss": float(loss), **measure(state.average, preset, hidden)}
                bar.set_postfix({name: f"{value:.4f}" for name, value in figures.items()})
                seconds = time.monotonic() - began
                journal.save(replace(point, step=done, seconds=seconds, state=state), figures)
    return {name: np.asarray(value) for name, value in state.average.items()}
