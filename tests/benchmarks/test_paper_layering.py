"""Errors of layering networks of Fan et al. 2022 on held-out stacks."""

import numpy as np
import pytest
from benchmarks.quality import paper_layering

from urushi.fan2022 import layering, projection
from urushi.fan2022.architecture import init
from urushi.fan2022.inference import direction_inputs, evaluate
from urushi.fan2022.preset import paper
from urushi.fan2022.store import generate

#: Scale of the paper's training.
TINY = 1e-10


def test_held_out_errors_are_those_of_the_stored_values(tmp_path):
    """Written out for all held-out BRDFs, whose codes are known."""
    preset, params = paper(TINY), init(0)
    store = generate(preset.data, tmp_path / "data")
    part = preset.part("two-layer")
    z = 1 + 0.1 * np.random.default_rng(12).normal(size=(preset.validation, 32)).astype(np.float32)
    medium = np.ones(preset.validation, np.float32)
    found = paper_layering.value_errors(
        params, preset, store, layering.Examples(z, z, medium, medium, z)
    )
    index = preset.data.parts.index(part)
    shards = range(store.spec.shard_count(part))
    read = [store.read_shard(index, shard, ("wi", "wo", "f")) for shard in shards]
    wi, wo, f = (np.concatenate([a[k] for a in read])[-preset.validation :] for k in read[0])
    value = np.maximum(evaluate(params, z[:, None], direction_inputs(wi, wo)), 0)
    assert found["L1 projected"] == pytest.approx(np.abs(value - f).mean(), rel=1e-4)
    cos = wo[..., 2]
    compressed = np.abs(projection.compressed(value * cos) - projection.compressed(f * cos)).mean()
    assert found["compressed L1 projected"] == pytest.approx(compressed, rel=1e-4)
    assert set(found) == {
        f"{m} {c}" for m in ("L1", "compressed L1") for c in ("projected", "layered")
    }
