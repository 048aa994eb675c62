"""Work on a cluster: every result once, whoever is killed, and sentences for what cannot work."""

import functools
import os
import signal
from pathlib import Path

import pytest

from urushi import platform
from urushi.errors import ParameterError, PlatformError
from urushi.train import workers

pytest.importorskip("distributed")


def square(number: int) -> int:
    return number * number


def square_of_a_survivor(folder: Path, number: int) -> int:
    """The square; but the first process that is asked for that of 3 is killed."""
    victim = folder / "victim"
    if number == 3 and not victim.exists():
        victim.write_text(str(os.getpid()))
        os.kill(os.getpid(), signal.SIGKILL)
    return square(number)


def test_a_killed_worker_loses_nothing(tmp_path):
    make = functools.partial(square_of_a_survivor, tmp_path)
    found = list(workers.results(make, range(20), "local:2"))
    assert (tmp_path / "victim").exists()
    assert sorted(found) == [(number, square(number)) for number in range(20)]


def test_a_killed_process_is_one_sentence(tmp_path):
    """Without a cluster nobody takes over its work."""
    make = functools.partial(square_of_a_survivor, tmp_path)
    with pytest.raises(PlatformError, match="killed, perhaps for lack of memory; run the command"):
        list(workers.results(make, range(20), processes=2))


def test_few_tasks_are_under_way_at_once():
    begun = []
    tasks = (begun.append(number) or number for number in range(100))
    done = workers.results(square, tasks, processes=2)
    next(done)
    assert len(begun) <= 2 * workers.DEPTH
    done.close()
    assert len(begun) <= 2 * workers.DEPTH


def test_errors_of_tasks_are_those_of_the_caller():
    with pytest.raises(ZeroDivisionError):
        list(workers.results(functools.partial(divmod, 1), [1, 0], processes=2))


def test_workers_of_other_versions_are_refused():
    with pytest.raises(PlatformError, match=r"a worker has numpy .*, and this process has 0\.0"):
        workers.computed(square, workers.versions() | {"numpy": "0.0"}, 1)


@pytest.mark.parametrize(
    ("cluster", "error", "sentence"),
    [
        ("local:0", ParameterError, "has no number of processes; give a positive one"),
        ("local:many", ParameterError, "has no number of processes; give a positive one"),
        ("nowhere://node:1", ParameterError, "give local:N or an address such as tcp://node:8786"),
        ("tcp://127.0.0.1:9", PlatformError, "no scheduler of Dask answers at 'tcp://127.0.0.1:9'"),
    ],
)
def test_clusters_that_are_not_there(cluster, error, sentence, monkeypatch):
    monkeypatch.setattr(workers, "PATIENCE", 1)
    with pytest.raises(error, match=sentence):
        next(workers.results(square, [1], cluster))


def test_the_missing_package_is_named(monkeypatch):
    gone = (platform.Package("distributed", "no_such_module", "clusters"),)
    monkeypatch.setitem(platform.EXTRAS, "cluster", gone)
    with pytest.raises(PlatformError, match="clusters need the package 'distributed'"):
        next(workers.results(square, [1], "local:2"))
