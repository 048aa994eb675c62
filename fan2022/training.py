"""The whole training of the paper's networks, from data to a weights file."""

import os
import time
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import jax
import numpy as np
from tqdm import tqdm

from fan2022 import layering, proxy, representation
from fan2022.architecture import LATENT, init, parameters_of
from fan2022.inference import direction_inputs
from fan2022.networks import PaperNetworks
from fan2022.palette import make_shard, read_shard
from fan2022.preset import PaperPreset
from fan2022.projection import project
from urushi.train import training, workers
from urushi.train.checkpoint import Checkpoint
from urushi.train.tables import generate

#: wi, wo and f of a shard.
Arrays = tuple[np.ndarray, np.ndarray, np.ndarray]


def train(
    preset: PaperPreset,
    *,
    data: str | os.PathLike | None = None,
    out: str | os.PathLike | None = None,
    run: str | os.PathLike | None = None,
    resume: bool = False,
    cluster: str | None = None,
    evaluation: PaperNetworks | None = None,
) -> PaperNetworks:
    """Train the three networks in turn and write the weights.

    Arguments as for `urushi.train.training.train`; the cluster projects BRDFs, too. evaluation:
    networks whose evaluation network is kept, so that the others alone are trained; the preset has
    their fingerprint.

    The evaluation network is trained together with its latents. Then all BRDFs are projected, and
    the layering network is trained on their codes. The sampling proxy is trained last. A checkpoint
    is written after every epoch of the evaluation network, after every projected shard, after every
    twentieth epoch of the layering network, and between the stages.
    """
    make: Any = make_shard  # a store needs the size and the number of shards of a specification
    made = partial(generate, make=make, cluster=cluster)
    store, journal, out = training.prepare(preset, data, out, run, resume, made)
    starts = beginnings(preset)
    point = journal.restore(starts) if resume else None
    if point is None:
        journal.clear()
        point = starts["representation"]
        if evaluation is not None:
            kept = parameters_of(evaluation.params, "evaluation")
            point = replace(starts["projection"], networks=kept)
    began = time.monotonic() - point.seconds  # as if earlier runs had been a part of this one

    def reached(point: Checkpoint, figures: Mapping[str, float] = {}) -> Checkpoint:
        """The checkpoint, saved with its time."""
        point = replace(point, seconds=time.monotonic() - began)
        journal.save(point, figures)
        return point

    if point.stage == "representation":
        for epoch in range(point.step, preset.epochs):
            batches = tqdm(
                representation.epoch(store, preset, epoch),
                desc=f"epoch {epoch + 1} of {preset.epochs}",
                disable=None,
            )
            state, loss = representation.learnt(
                representation.step, point.state, batches, *preset.rates(epoch)
            )
            point = reached(replace(point, step=epoch + 1, state=state), {"loss": loss})
        point = reached(replace(starts["projection"], networks=dict(point.state.params)))
    if point.stage == "projection":
        networks = {name: np.asarray(value) for name, value in point.networks.items()}
        left = missing(preset, point.state)
        tasks = ((shard, *read_shard(store, shard)) for shard in left)
        found = workers.results(partial(projected, networks, preset), tasks, cluster)
        for (shard, *_), result in tqdm(found, "shards", len(left), disable=None):
            state = with_codes(point.state, preset, shard, *result)
            point = reached(replace(point, step=point.step + 1, state=state))
        point = reached(replace(starts["layering"], networks={**point.networks, **point.state}))
    if point.stage == "layering":
        sets = layering.examples(preset, codes_of(preset, point.networks))
        epochs = preset.layering_epochs + preset.finetuning_epochs
        for epoch in tqdm(range(point.step, epochs), desc="layering", disable=None):
            state, loss = layering.learn_epoch(point.state, sets, preset, epoch)
            point = replace(point, step=epoch + 1, state=state)
            if (epoch + 1) % layering.DECAYS == 0 or epoch + 1 == epochs:
                point = reached(point, {"loss": loss})
        networks = {**point.networks, **point.state.params}
        point = reached(replace(starts["proxy"], networks=networks))

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
    first = representation.start(params, preset.trained)
    second = layering.start(params)
    found: dict[str, Any] = {}
    for name, (_, stacks) in preset.data.parts.items():
        found[f"codes.{name}"] = np.zeros((stacks, LATENT), np.float32)
        found[f"error.{name}"] = np.zeros(stacks, np.float32)
    arrays = {**first.params, **found}
    return {
        "representation": Checkpoint("representation", 0, 0.0, first, {}),
        "projection": Checkpoint("projection", 0, 0.0, found, dict(first.params)),
        "layering": Checkpoint("layering", 0, 0.0, second, arrays),
        "proxy": Checkpoint("proxy", 0, 0.0, {}, {**arrays, **second.params}),
    }


def projected(
    params: Mapping[str, Any], preset: PaperPreset, task: tuple[int, *Arrays]
) -> tuple[np.ndarray, np.ndarray]:
    """The codes (M, 32) and errors (M,) [1/sr] of the BRDFs of a shard; task: its number, and its
    arrays."""
    _, wi, wo, f = task
    return project(params, direction_inputs(wi, wo), f, preset.arch, preset.seed)


def with_codes(
    found: Any, preset: PaperPreset, shard: int, codes: np.ndarray, errors: np.ndarray
) -> dict[str, np.ndarray]:
    """The codes and errors of all parts by name, with those of one more shard."""
    name, rows = preset.data.places()[shard]
    arrays = {key: np.array(values) for key, values in found.items()}
    arrays[f"codes.{name}"][rows], arrays[f"error.{name}"][rows] = codes, errors
    return arrays


def missing(preset: PaperPreset, found: Any) -> list[int]:
    """The shards that are still to be projected, whose codes are 0."""
    return [
        shard
        for shard, (name, rows) in enumerate(preset.data.places())
        if not np.any(found[f"codes.{name}"][rows])
    ]


def codes_of(preset: PaperPreset, arrays: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """The codes of `projected` by the parts' names."""
    return {name: np.asarray(arrays[f"codes.{name}"]) for name in preset.data.parts}


def figures(
    params: Mapping[str, Any], preset: PaperPreset, results: Mapping[str, Any]
) -> dict[str, float]:
    """Mean absolute errors [1/sr] of projections, and mean absolute errors of layered codes."""
    sets = layering.examples(preset, codes_of(preset, results))
    loss = jax.jit(layering.l1_loss)
    named = {f"L1 {name}": np.mean(results[f"error.{name}"]) for name in preset.data.parts}
    named |= {"L1 validation": np.mean(results["error.two-layer"][-preset.validation :])}
    named |= {f"L1 codes {name}": loss(params, examples) for name, examples in sets.items()}
    return {name: float(value) for name, value in named.items()}
