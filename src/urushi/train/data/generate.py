"""Generation of a data store; each shard is a pure function of the specification and its index."""

import os

import numpy as np
from tqdm import tqdm

from urushi.checks import CoatParameters
from urushi.core import direction_sets
from urushi.train.data.spec import DataSpec
from urushi.train.data.store import Shard, Store
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS
from urushi.walk.simulate import walk_pairs


def make_shard(spec: DataSpec, part: int, shard: int) -> Shard:
    """Draw and simulate the stacks of one shard.

    Args:
        spec: the whole specification.
        part, shard: indices of the part and of its shard.

    Returns:
        The arrays of `store`'s layout; they depend only on the arguments.
    """
    described = spec.parts[part]
    rows = spec.rows(part, shard)
    count = rows.stop - rows.start
    parameters, directions, walks = spec.seeds(part, shard).spawn(3)
    table = described.distribution.draw(np.random.default_rng(parameters), rows)
    rng = np.random.default_rng(directions)
    wi, wo = direction_sets.draw_pairs(described.directions, rng, count, described.pairs)
    row = np.repeat(np.arange(count, dtype=np.uint32), described.pairs)
    if described.distribution.coats == 0:
        f = analytic.rows(table.kind, table.bottom, row, wi, wo)
        se = np.zeros_like(f)
    else:
        seed = int(walks.generate_state(1)[0])
        f, se = walk_pairs(table, row, wi, wo, walks=described.walks, seed=seed)
    arrays = {
        "bottom": np.stack([table.bottom[name] for name in KINDS[table.kind].parameters], axis=-1),
        "wi": wi.reshape(count, -1, 3),
        "wo": wo.reshape(count, -1, 3),
        "f": f.reshape(count, -1),
        "se": se.reshape(count, -1),
    }
    if described.distribution.coats:
        coats = CoatParameters(*(getattr(table, name) for name in CoatParameters._fields))
        arrays["coats"] = np.stack(coats.columns(), axis=-1)
    return arrays


def generate(spec: DataSpec, path: str | os.PathLike) -> Store:
    """Generate the data of `spec` at `path`, or resume where an earlier run was stopped.

    The bytes of the result do not depend on interruptions.

    Args:
        spec: the content.
        path: the store's folder; only this process writes to it.

    Raises:
        FileError: `path` holds something else, or cannot be written.
    """
    store = Store.create(path, spec)
    missing = store.missing()
    total = sum(spec.walks(*index) for index in missing)
    with tqdm(total=total, unit="walk", unit_scale=True, disable=None) as progress:
        for part, shard in missing:
            progress.set_description(spec.parts[part].name)
            store.write(part, shard, make_shard(spec, part, shard))
            progress.update(spec.walks(part, shard))
    return store
