"""The shared fixtures of this folder: a training of a few steps, and its data without transport."""

import numpy as np
import pytest

from urushi import files
from urushi.core.probe_pairs import probe_pairs
from urushi.core.table import node_pairs
from urushi.nets import lobe as lobes
from urushi.nets.networks import Architecture
from urushi.train import tables
from urushi.train.distribution import draw_coats
from urushi.train.optimiser import Schedule
from urushi.train.presets import Preset
from urushi.train.tables import TableSpec, TableStore


def log_f(wi: np.ndarray, wo: np.ndarray, c: np.ndarray) -> np.ndarray:
    """ln f (N, P) of a family with three functions, for numbers c (N, 3)."""
    functions = np.stack([np.ones(len(wi)), wi[:, 2] * wo[:, 2], (wi * wo).sum(axis=1)])
    return c @ functions - 2


def made_shard(spec: TableSpec, shard: int) -> dict[str, np.ndarray]:
    """A shard whose rests are of the family, under coats that change their numbers linearly."""
    rng = np.random.default_rng([spec.seed, shard])
    count = spec.shard
    c, over = 0.5 * rng.standard_normal((count, 3)), draw_coats(rng, count * spec.coats)
    change = over[:, :3] @ np.array([[0.1, 0, 0.2], [-0.2, 0.1, 0], [0.1, 0.1, 0.1]])
    coated = np.repeat(c, spec.coats, axis=0) + change
    lobe = lobes.of_coat(rng.uniform(0.1, 0.5, count), np.full(count, 1.5))
    return {
        "table": log_f(*node_pairs(), c).astype(np.float16),
        "lobe": lobe.astype(np.float32),
        "stack": np.arange(shard * count, (shard + 1) * count, dtype=np.int32),
        "level": np.ones(count, np.int32),
        "over": over.reshape(count, spec.coats, 5).astype(np.float32),
        "coated": log_f(*probe_pairs(spec.probes), coated)
        .reshape(count, spec.coats, -1)
        .astype(np.float32),
    }


@pytest.fixture(scope="session")
def tiny() -> Preset:
    return Preset(
        name="tiny",
        data=TableSpec(stacks=60, coats=2, probes=64, seed=5, shard=20),
        schedule=Schedule(8, 4, 1e-3, average=0.9, steps_per_call=4, checkpoint_every=4),
        batch=16,
        arch=Architecture(functions=4, probes=64, layerer=(8, 8)),
    )


@pytest.fixture(scope="session")
def store(tiny, tmp_path_factory) -> TableStore:
    made, description = tables.opened(tiny.data, tmp_path_factory.mktemp("data")), {"version": 1}
    for shard in made.missing():
        files.write_tensors(made.file(shard), "tables", description, made_shard(tiny.data, shard))
    return made
