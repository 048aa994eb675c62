"""Tables of random stacks: levels from the bottom up, reproducible, completed if interrupted."""

import numpy as np
import pytest

from urushi.checks import CoatParameters
from urushi.core.probe_pairs import probe_pairs
from urushi.core.table import MIN_LOG, SHAPE
from urushi.errors import FileError
from urushi.material.coated_values import coated_f
from urushi.material.reflector import Reflector
from urushi.material.substrate import Substrate
from urushi.nets import lobe as lobes
from urushi.nets.transmittance import both_ways
from urushi.train import distribution, tables
from urushi.train.tables import TableSpec

SPEC = TableSpec(stacks=4, coats=2, probes=64, seed=3, shard=2)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("tables")
    tables.generate(SPEC, path)
    return path


def test_rows_are_the_levels_of_stacks_from_the_bottom_up(folder):
    held = tables.opened(SPEC, folder).read(("stack", "level", "coat"))
    assert (np.unique(held["stack"]) == np.arange(SPEC.stacks)).all()
    new = np.diff(held["stack"], prepend=-1) > 0
    assert (held["level"][new] == 0).all()
    assert (np.diff(held["level"])[~new[1:]] == 1).all()
    assert not held["coat"][new].any()
    # Further coats share interfaces.
    coats = distribution.draw_coats(np.random.default_rng(0), 16)
    assert (coats[::2, :2] == coats[1::2, :2]).all() and len(np.unique(coats[:, 0])) == 8
    assert (coats[::2, 2:] != coats[1::2, 2:]).any()


def test_further_coats_are_light_transport_over_the_level(folder):
    held = tables.opened(SPEC, folder).read(("table", "lobe", "over", "coated"))
    row = len(held["table"]) - 1
    logs = held["table"][row].reshape(*SHAPE, 1)
    below = Substrate.of(Reflector.of_logs(logs, held["lobe"][row : row + 1]))
    coat, pairs = CoatParameters(*held["over"][row, 0].astype(float)), probe_pairs(SPEC.probes)
    passed = both_ways(lobes.of_coat(coat.alpha, coat.eta), *pairs)
    found = np.exp(held["coated"][row, 0])
    rest = coated_f(below, coat, *pairs)[:, 0] / passed
    np.testing.assert_allclose(found, np.maximum(rest, np.exp(MIN_LOG)), rtol=1e-3)


def test_a_stack_does_not_depend_on_the_number_of_stacks(folder):
    held = tables.opened(SPEC, folder).read(("stack", "table"))
    own = np.stack([row["table"] for row in tables.levels(SPEC.seed, 3)])
    np.testing.assert_array_equal(own, held["table"][held["stack"] == 3])


def test_an_interrupted_store_is_completed_on_a_cluster_to_the_same_bytes(folder, tmp_path):
    whole = tables.opened(SPEC, folder)
    store = tables.opened(SPEC, tmp_path)
    store.file(1).write_bytes(whole.file(1).read_bytes())
    assert store.missing() == [0]
    assert tables.generate(SPEC, tmp_path, cluster="local:2").hash() == whole.hash()


def test_a_folder_of_another_specification_is_refused(folder):
    with pytest.raises(FileError, match="another specification"):
        tables.opened(TableSpec(stacks=5, coats=2, probes=64), folder)
