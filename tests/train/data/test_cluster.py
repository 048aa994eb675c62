"""A cluster writes the same store as a single process, byte for byte, even if workers die."""

import os
import pkgutil
import signal
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

import pytest

from urushi.errors import ParameterError, PlatformError
from urushi.train.data import cluster
from urushi.train.data import generate as generation
from urushi.train.data.distribution import Extended, Table2
from urushi.train.data.generate import generate
from urushi.train.data.spec import DataSpec, Part
from urushi.train.data.store import Store

distributed = pytest.importorskip("distributed", reason="the extra 'cluster' is not installed")

SPEC = DataSpec(
    parts=(
        Part("coated", Table2(), stacks=20, pairs=16, walks=4),
        Part("twice", Extended(2, "diffuse"), stacks=6, pairs=8, walks=2),
        Part("bare", Extended(0, "conductor_complex"), stacks=5, pairs=8, walks=1),
    ),
    seed=3,
    shard=2,
)
SHARDS = 16


@pytest.fixture(scope="module")
def single(tmp_path_factory):
    """The store that this process makes by itself."""
    path = tmp_path_factory.mktemp("single") / "data.zarr"
    generate(SPEC, path)
    return path


def test_a_worker_killed_in_mid_run_loses_nothing(
    two_workers, single, fingerprints, tmp_path, monkeypatch
):
    address = two_workers.scheduler_address
    with distributed.Client(address, set_as_default=False) as client:
        pids = list(client.run(os.getpid).values())
    write, written = Store.write, []

    def killing(self, *shard):
        written.append(shard[:2])
        if len(written) == 2:  # while others are under way on either worker
            os.kill(pids[0], signal.SIGKILL)
        write(self, *shard)

    monkeypatch.setattr(Store, "write", killing)
    path = tmp_path / "cluster.zarr"
    generate(SPEC, path, address)
    assert sorted(written) == list(SPEC.shards())
    assert len(written) == SHARDS
    with distributed.Client(address, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=60)  # the nanny has started another one
        assert pids[0] not in client.run(os.getpid).values()
    assert fingerprints(path) == fingerprints(single)


def test_an_interrupted_run_leaves_whole_shards_and_resumes(
    two_workers, single, fingerprints, tmp_path, monkeypatch
):
    write, written = Store.write, []

    def interrupted(self, *shard):
        if len(written) == 5:
            raise KeyboardInterrupt
        written.append(shard[:2])
        write(self, *shard)

    monkeypatch.setattr(Store, "write", interrupted)
    path = tmp_path / "cluster.zarr"
    with pytest.raises(KeyboardInterrupt):
        generate(SPEC, path, two_workers.scheduler_address)
    monkeypatch.undo()
    assert len(Store.open(path).missing()) == SHARDS - 5
    generate(SPEC, path, two_workers.scheduler_address)
    assert fingerprints(path) == fingerprints(single)


def test_the_command_passes_the_scheduler(two_workers, single, fingerprints, tmp_path, monkeypatch):
    from types import SimpleNamespace

    from urushi.app import cli
    from urushi.train import presets

    monkeypatch.setattr(presets, "get", lambda name: SimpleNamespace(data=SPEC))
    path = tmp_path / "command.zarr"
    flags = ["-o", str(path), "--scheduler", two_workers.scheduler_address]
    assert cli.main(["data", "generate", *flags]) == 0
    assert fingerprints(path) == fingerprints(single)


# Tasks are functions in functions: workers get these by value, as they cannot import the tests.


def test_no_more_results_are_under_way_than_the_workers_have_room_for(two_workers, tmp_path):
    def double(x, folder):
        (folder / f"{x}").touch()  # a trace of having run
        return 2 * x

    begun = cluster.run(two_workers.scheduler_address, double, [(x, tmp_path) for x in range(40)])
    taken = dict(next(begun) for _ in range(3))
    time.sleep(1.0)  # time in which the workers could continue
    # Two workers have two tasks each, and get another one only when a result is taken.
    assert len(list(tmp_path.iterdir())) <= 3 + 2 * cluster.IN_FLIGHT
    taken |= dict(begun)
    assert taken == {x: 2 * x for x in range(40)}


def test_an_error_of_a_task_arrives_as_it_was_raised(two_workers):
    def refuse(x):
        raise ParameterError(f"{x} is refused")

    with pytest.raises(ParameterError, match="7 is refused"):
        list(cluster.run(two_workers.scheduler_address, refuse, [(7,)]))


def test_workers_with_other_software_are_refused(two_workers, tmp_path, monkeypatch):
    other = {**generation.versions(), "drjit": "0.0"}
    monkeypatch.setattr(generation, "versions", lambda: other)
    with pytest.raises(
        PlatformError, match="a worker of the cluster has drjit .*, but here .* 0.0"
    ):
        generate(SPEC, tmp_path / "data.zarr", two_workers.scheduler_address)


def test_a_scheduler_that_is_not_there_and_one_without_workers(monkeypatch):
    monkeypatch.setattr(cluster, "PATIENCE", 0.5)
    for address in ("tcp://127.0.0.1:1", "nonsense://"):
        with pytest.raises(PlatformError, match="there is no Dask scheduler at"):
            list(cluster.run(address, abs, [(1,)]))
    with distributed.LocalCluster(n_workers=0, dashboard_address=":0", host="127.0.0.1") as empty:
        with pytest.raises(PlatformError, match="has no worker; start at least one with `dask wor"):
            list(cluster.run(empty.scheduler_address, abs, [(1,)]))


@pytest.fixture
def strange_worker(tmp_path, request):
    """The address of a cluster with a worker that has everything but this Urushi.

    request.param: the text of the module that it has in its place, or None.
    """
    folder = tmp_path / "packages"
    folder.mkdir()
    for entry in Path(sysconfig.get_paths()["purelib"]).iterdir():
        if "urushi" not in entry.name:
            (folder / entry.name).symlink_to(entry)
    if request.param is not None:
        (folder / "urushi.py").write_text(request.param)
    with distributed.LocalCluster(n_workers=0, dashboard_address=":0", host="127.0.0.1") as cluster:
        command = [sys.executable, "-S", "-m", "distributed.cli.dask_worker", "--no-nanny"]
        where = ["--nthreads", "1", "--no-dashboard", "--local-directory", tmp_path]
        worker = subprocess.Popen(
            [*command, cluster.scheduler_address, *where],
            env={**os.environ, "PYTHONPATH": str(folder)},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            yield cluster.scheduler_address
        finally:
            worker.kill()
            worker.wait()


@pytest.mark.parametrize(
    ("strange_worker", "words"),
    [
        (None, "worker at '.*' cannot import Urushi .*; install Urushi .* `dask worker` runs in"),
        ("__version__ = '99.0'", "worker at '.*' has Urushi 99.0, but here it is .*; install the"),
    ],
    indirect=["strange_worker"],
)
def test_a_worker_without_this_urushi_is_refused_before_any_task(strange_worker, words, tmp_path):
    with pytest.raises(PlatformError, match=words):
        generate(SPEC, tmp_path / "data.zarr", strange_worker)


def test_a_scheduler_without_urushi_is_refused(two_workers, monkeypatch):
    """The tests' scheduler is in this process: it is asked for a package that is nowhere."""
    missing = pkgutil.resolve_name, "urushi_of_another_name:__version__"
    monkeypatch.setattr(cluster, "_VERSION", missing)
    with pytest.raises(PlatformError, match="scheduler at '.*' cannot import Urushi"):
        list(cluster.run(two_workers.scheduler_address, abs, [(1,)]))
