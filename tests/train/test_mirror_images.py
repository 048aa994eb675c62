"""Stacks with exchanged axes: the same values by simulation and by formula, and learned from."""

import numpy as np
import pytest

from urushi.checks import CoatParameters
from urushi.core.probe_pairs import ANISOTROPIC_PROBES
from urushi.errors import ParameterError
from urushi.nets.architecture import Architecture, init
from urushi.train import examples
from urushi.train.distribution import ANISOTROPIC_BOTTOMS, Anisotropic, Table2
from urushi.train.examples import mirror_images
from urushi.train.stages.layering import MirroredLayering
from urushi.train.store import DataSpec, Part, generate, make_shard
from urushi.walk import StackTable, analytic, walk_pairs
from urushi.walk.bottoms import KINDS

ARCH = Architecture(
    latent=12,
    decoder=(8,),
    encoder=(8,),
    layerer=(8,),
    sampler=(4,),
    probes=ANISOTROPIC_PROBES,
    widths=2,
)


def _shard(kind, coats, walks, stacks=8):
    part = Part("stacks", Anisotropic(coats, kind), stacks, 32, walks, "anisotropic")
    return part, make_shard(DataSpec((part,), seed=11, shard=stacks), 0, 0)


@pytest.mark.parametrize("kind", ["conductor_anisotropic", "mixture_anisotropic"])
def test_simulation_of_the_mirror_image_agrees(kind):
    part, arrays = _shard(kind, coats=2, walks=4096)
    mirrored = mirror_images(part, arrays)
    coats = CoatParameters.of_columns(np.moveaxis(mirrored["coats"], -1, 0))
    assert not np.array_equal(coats.alpha.u, coats.alpha.v)
    columns = dict(zip(KINDS[kind].parameters, mirrored["bottom"].T, strict=True))
    table = StackTable(kind=kind, bottom=columns, **coats._asdict())
    row = np.repeat(np.arange(len(table), dtype=np.uint32), 32)
    wi, wo = (mirrored[name].reshape(-1, 3) for name in ("wi", "wo"))
    f, se = walk_pairs(table, row, wi, wo, walks=4096, seed=99)
    spread = np.hypot(se, arrays["se"].ravel())
    z = (f - arrays["f"].ravel())[spread > 0] / spread[spread > 0]
    # 256 independent differences: the mean square of normal ones is 1 within 4 x 0.09. The width
    # ratios reach 8, so that values without the exchange differ by many standard errors.
    assert len(z) > 200
    assert 0.64 < np.mean(z**2) < 1.36


@pytest.mark.parametrize("kind", ANISOTROPIC_BOTTOMS)
def test_a_bare_bottom_has_the_same_values(kind):
    part, arrays = _shard(kind, coats=0, walks=1)
    mirrored = mirror_images(part, arrays)
    columns = dict(zip(KINDS[kind].parameters, mirrored["bottom"].T, strict=True))
    row = np.repeat(np.arange(8, dtype=np.uint32), 32)
    f = analytic.rows(kind, columns, row, *(mirrored[n].reshape(-1, 3) for n in ("wi", "wo")))
    np.testing.assert_allclose(f, arrays["f"].ravel(), rtol=1e-4, atol=1e-7)


def test_twice_mirrored_is_the_stack_itself():
    part, arrays = _shard("conductor_complex_anisotropic", coats=1, walks=2)
    twice = mirror_images(part, mirror_images(part, arrays))
    for name, values in arrays.items():
        np.testing.assert_array_equal(twice[name], values)


def test_stacks_of_one_width_are_refused():
    with pytest.raises(ParameterError, match="'table' has stacks of one GGX width"):
        mirror_images(Part("table", Table2(1), 8, 16, 1), {})


def test_the_stage_learns_from_every_stack_and_its_mirror_image(tiny, tmp_path):
    parts = tuple(
        Part(f"{coats}", Anisotropic(coats, "conductor_anisotropic"), 8, 16, 4, "anisotropic")
        for coats in (1, 2)
    )
    bare = Part("bare", Anisotropic(0, "mixture_anisotropic"), 4, 16, 1, "anisotropic")
    store = generate(DataSpec((bare, *parts), seed=3, shard=8), tmp_path / "data")
    depths = examples.load(store, ARCH, 16)
    stage = MirroredLayering(tiny.stages[1].schedule, stacks=(16, 4))
    one, other = stage.examples(depths[1])
    # The top lobe is that of the mirrored coat in mirrored directions: the same values.
    np.testing.assert_allclose(other.top, one.top, rtol=1e-4)
    np.testing.assert_array_equal(other.f, one.f)
    assert not np.array_equal(other.features, one.features)
    params = init(ARCH, 0)
    batch = stage.task(params, ARCH, depths, seed=0).batches(0, 1)
    lowest = batch.coats[0][0][4:]  # after the stacks of two coats, one epoch of those of one
    expected = np.concatenate([one.coats[:, 0], other.coats[:, 0]])
    assert sorted(map(bytes, lowest)) == sorted(map(bytes, expected))
