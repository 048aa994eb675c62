"""The whole training of the paper's networks, from data to a weights file."""

import functools
import os
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import jax
import numpy as np
from tqdm import tqdm

from urushi.fan2022 import layering, projection, proxy, representation
from urushi.fan2022.architecture import LATENT, AdamProjection, init
from urushi.fan2022.inference import direction_inputs
from urushi.fan2022.networks import PaperNetworks
from urushi.fan2022.preset import PaperPreset
from urushi.fan2022.store import Store, generate
from urushi.nets.mlp import Params
from urushi.train import training
from urushi.train.checkpoint import Checkpoint, Journal

#: BRDFs that are projected together, and their pairs in one step, at most: bounds memory.
TOGETHER, ROWS = 16, 1 << 13


def train(
    preset: PaperPreset,
    *,
    data: str | os.PathLike | None = None,
    out: str | os.PathLike | None = None,
    run: str | os.PathLike | None = None,
    resume: bool = False,
) -> PaperNetworks:
    """Train the three networks in turn and write the weights.

    Arguments as for `urushi.train.training.train`.

    The evaluation network is trained together with its latents. Then all BRDFs are projected, and
    the layering network is trained on their codes. The sampling proxy is trained last. A checkpoint
    is written after every epoch of the evaluation network, after every projected shard, after every
    twentieth epoch of the layering network, and between the stages.
    """
    store, journal, out = training.prepare(preset, data, out, run, resume, generate)
    starts = beginnings(preset)
    point = journal.restore(starts) if resume else None
    if point is None:
        journal.clear()
        point = starts["representation"]
    began = time.monotonic() - point.seconds  # as if earlier runs had been a part of this one
    if point.stage == "representation":
        point = represent(point, preset, store, journal, began)
        networks = dict(point.state.params)
        seconds = time.monotonic() - began
        point = replace(starts["projection"], seconds=seconds, networks=networks)
        journal.save(point)
    if point.stage == "projection":
        point = project_all(point, preset, store, journal, began)
        networks = {**point.networks, **point.state}
        point = replace(starts["layering"], seconds=time.monotonic() - began, networks=networks)
        journal.save(point)
    if point.stage == "layering":
        point = learn_layering(point, preset, journal, began)
        networks = {**point.networks, **point.state.params}
        point = Checkpoint("proxy", 0, time.monotonic() - began, {}, networks)
        journal.save(point)

    results = {name: np.asarray(value) for name, value in point.networks.items()}
    params = {name: v for name, v in results.items() if not name.startswith(("codes.", "error."))}
    wi = proxy.incoming(preset.proxy_incoming, preset.seed)
    codes = results["codes.two-layer"][: preset.proxy_materials]
    histograms = proxy.histograms(params, codes, wi)
    sampling, divergence = proxy.learn(init(preset.seed), histograms)
    metrics = figures(params, preset, results) | {"proxy divergence": divergence}
    header = {**training.header(journal, metrics, time.monotonic() - began), "scale": preset.scale}
    return PaperNetworks(preset.arch, {**params, **sampling}, header).save(out)


def beginnings(preset: PaperPreset) -> dict[str, Checkpoint]:
    """Each stage's first checkpoint; only the shapes of earlier results count."""
    params = init(preset.seed)
    first = representation.start(params, representation.trained(preset))
    second = layering.start(params)
    found: dict[str, Any] = {}
    for part in preset.data.parts:
        found[f"codes.{part.name}"] = np.zeros((part.stacks, LATENT), np.float32)
        found[f"error.{part.name}"] = np.zeros(part.stacks, np.float32)
    arrays = {**first.params, **found}
    return {
        "representation": Checkpoint("representation", 0, 0.0, first, {}),
        "projection": Checkpoint("projection", 0, 0.0, found, dict(first.params)),
        "layering": Checkpoint("layering", 0, 0.0, second, arrays),
        "proxy": Checkpoint("proxy", 0, 0.0, {}, {**arrays, **second.params}),
    }


def represent(
    point: Checkpoint, preset: PaperPreset, store: Store, journal: Journal, began: float
) -> Checkpoint:
    """Train the evaluation network for its remaining epochs."""
    pairs = preset.part("two-layer").pairs
    runs = pairs // min(preset.pairs, pairs)
    for epoch in range(point.step, preset.epochs):
        rates = (rate * preset.decay**epoch for rate in (preset.weights_rate, preset.latents_rate))
        batches = tqdm(
            representation.epoch(store, preset, epoch),
            total=runs * max(1, representation.trained(preset) // preset.stacks),
            desc=f"epoch {epoch + 1} of {preset.epochs}",
            disable=None,
        )
        state, loss = representation.learn_epoch(point.state, batches, *rates)
        point = replace(point, step=epoch + 1, seconds=time.monotonic() - began, state=state)
        journal.save(point, {"loss": loss})
    return point


def project_all(
    point: Checkpoint, preset: PaperPreset, store: Store, journal: Journal, began: float
) -> Checkpoint:
    """Project the remaining shards of all parts: codes and errors by name, in the state."""
    shards = list(store.spec.shards())
    arrays = {name: np.array(values) for name, values in point.state.items()}
    progress = tqdm(shards[point.step :], desc="project", unit="shard", disable=None)
    for done, (part, shard) in enumerate(progress, point.step + 1):
        name, rows = store.spec.parts[part].name, store.spec.rows(part, shard)
        options = preset.arch.adam
        found = project_shard(point.networks, store, part, shard, options, preset.seed)
        arrays[f"codes.{name}"][rows], arrays[f"error.{name}"][rows] = found
        point = replace(point, step=done, seconds=time.monotonic() - began, state=arrays)
        journal.save(point)
    return point


def project_shard(
    params: Mapping[str, Any],
    store: Store,
    part: int,
    shard: int,
    options: AdamProjection,
    seed: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """Codes (S, 32) of a shard's BRDFs and their mean absolute errors (S,) [1/sr]."""
    pairs = store.spec.parts[part].pairs
    together = max(1, min(TOGETHER, ROWS // min(options.pairs, pairs)))
    at = projection.draws(options, pairs, seed)
    arrays = store.read_shard(part, shard, ("wi", "wo", "f"))
    found = []
    for start in range(0, len(arrays["f"]), together):
        wi, wo, f = (arrays[name][start : start + together] for name in ("wi", "wo", "f"))
        count, missing = len(f), ((0, together - len(f)), (0, 0))
        # All blocks have one shape, for the compiler.
        f = np.pad(f, missing, "edge")
        directions = np.pad(direction_inputs(wi, wo), (*missing, (0, 0)), "edge")
        results = project(params, directions, f, at, options.steps)
        found.append([np.asarray(result)[:count] for result in results])
    codes, errors = map(np.concatenate, zip(*found, strict=True))
    return codes, errors


@functools.partial(jax.jit, static_argnums=4)
def project(
    params: Params, directions: jax.Array, f: jax.Array, at: jax.Array | None, steps: int
) -> tuple[jax.Array, jax.Array]:
    """`projection.project` on JAX; at: of `projection.draws`."""

    def step(index: int, state: projection.AdamState) -> projection.AdamState:
        chosen = slice(None) if at is None else at[index]
        return projection.step(params, state, directions[:, chosen], f[:, chosen], steps)

    state = jax.lax.fori_loop(0, steps, step, projection.start(f))
    return state.z, state.error


def codes_of(preset: PaperPreset, arrays: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """The codes of `projected` by the parts' names."""
    return {part.name: np.asarray(arrays[f"codes.{part.name}"]) for part in preset.data.parts}


def learn_layering(
    point: Checkpoint, preset: PaperPreset, journal: Journal, began: float
) -> Checkpoint:
    """Train the layering network for its remaining epochs."""
    sets = layering.examples(preset, codes_of(preset, point.networks))
    epochs = preset.layering_epochs + preset.finetuning_epochs
    for epoch in tqdm(range(point.step, epochs), desc="layering", disable=None):
        state, loss = layering.learn_epoch(point.state, sets, preset, epoch)
        point = replace(point, step=epoch + 1, seconds=time.monotonic() - began, state=state)
        if (epoch + 1) % layering.DECAYS == 0 or epoch + 1 == epochs:
            journal.save(point, {"loss": loss})
    return point


def figures(
    params: Mapping[str, Any], preset: PaperPreset, results: Mapping[str, Any]
) -> dict[str, float]:
    """Mean absolute errors [1/sr] of projections, and mean absolute errors of layered codes."""
    sets = layering.examples(preset, codes_of(preset, results))
    loss = jax.jit(layering.l1_loss)
    named = {f"L1 {p.name}": np.mean(results[f"error.{p.name}"]) for p in preset.data.parts}
    named |= {"L1 validation": np.mean(results["error.two-layer"][-preset.validation :])}
    named |= {f"L1 codes {name}": loss(params, examples) for name, examples in sets.items()}
    return {name: float(value) for name, value in named.items()}
