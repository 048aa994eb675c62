"""Where training data are computed: on this machine's cores, or by the workers of a cluster.

Shards of data are pure functions of a specification and of their number, so that it does not matter
who computes them, how often, and in which order. Clusters are those of Dask (Rocklin 2015), whose
scheduler gives the work of a lost worker to another one.
"""

import contextlib
import functools
import itertools
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from importlib.metadata import version
from multiprocessing import get_context
from typing import TypeVar

from urushi.errors import ParameterError, PlatformError
from urushi.parallel import one_blas_thread
from urushi.platform import available_cores, require_extra

#: Tasks of each worker that wait or run: the next one is there when a worker has ended one.
DEPTH = 2

#: Packages whose versions decide the bytes of the data.
PACKAGES = ("urushi", "numpy", "drjit")

#: The environment of a worker, which has one core: JAX is slower by half with more threads there.
ENVIRONMENT = {
    "XLA_FLAGS": f"{os.environ.get('XLA_FLAGS', '')} --xla_cpu_multi_thread_eigen=false".strip()
}

#: Seconds to wait for a scheduler.
PATIENCE = 20

Task = TypeVar("Task")
Result = TypeVar("Result")


def results(
    make: Callable[[Task], Result],
    tasks: Iterable[Task],
    cluster: str | None = None,
    processes: int | None = None,
) -> Iterator[tuple[Task, Result]]:
    """Yield every task with make(task), in the order in which they are done.

    At most `DEPTH` tasks a worker are under way, and results are handed back one by one, so that
    memory holds a few of them only. Stopping the iteration cancels the tasks that are left.

    Args:
        make: a function that processes can import, or a partial of one; it runs on one core.
        tasks: its arguments.
        cluster: the address of a scheduler of Dask, such as "tcp://node:8786", or "local:N": a
            cluster of N processes on this machine. None: processes without a cluster.
        processes: their number without a cluster, default one for each core; 1: this process.

    Raises:
        ParameterError: the address cannot be read.
        PlatformError: the scheduler does not answer, or a process without a cluster was killed, or
            a worker has other versions of Urushi, NumPy or Dr.Jit, which might compute other bytes.
    """
    compute = functools.partial(computed, make, versions())
    if cluster is None and processes == 1:
        yield from ((task, compute(task)) for task in tasks)
        return
    left = iter(tasks)
    running: dict[Future, Task] = {}
    try:
        with contextlib.ExitStack() as stack:
            pool, workers = _pool(stack, cluster, processes)
            while True:
                for task in itertools.islice(left, max(DEPTH * workers() - len(running), 0)):
                    running[pool.submit(compute, task)] = task
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    yield running.pop(future), future.result()
    except BrokenExecutor as error:
        raise PlatformError(
            "a process that computed data was killed, perhaps for lack of memory; run the command "
            "again, which continues, or with --cluster local:1, which needs less"
        ) from error


def versions() -> dict[str, str]:
    """The versions of `PACKAGES` in this process."""
    return {name: version(name) for name in PACKAGES}


def computed(make: Callable[[Task], Result], expected: dict[str, str], task: Task) -> Result:
    """make(task), in a process with the expected versions."""
    for name, found in versions().items():
        if found != expected[name]:
            raise PlatformError(
                f"a worker has {name} {found}, and this process has {expected[name]}, which may "
                "compute other data; install the same version everywhere"
            )
    with one_blas_thread():
        return make(task)


def _begin_worker() -> None:
    os.environ.update(ENVIRONMENT)


def _pool(
    stack: contextlib.ExitStack, cluster: str | None, processes: int | None
) -> tuple[Executor, Callable[[], int]]:
    """What computes tasks until the stack ends, and the present number of its workers.

    What has not begun by then is cancelled.
    """
    if cluster is None:
        count = processes or available_cores()
        pool: Executor = ProcessPoolExecutor(count, get_context("spawn"), _begin_worker)
        stack.callback(pool.shutdown, cancel_futures=True)
        return pool, lambda: count
    require_extra("cluster")
    import distributed

    address, (kind, _, number) = cluster, cluster.partition(":")
    if kind == "local":
        if not number.isdecimal() or int(number) < 1:
            raise ParameterError(
                f"'{cluster}' has no number of processes; give a positive one, such as local:4"
            )
        local = distributed.LocalCluster(
            n_workers=int(number),
            threads_per_worker=1,
            dashboard_address="127.0.0.1:0",
            env=ENVIRONMENT,
        )
        address = stack.enter_context(local).scheduler_address
    try:
        client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except ValueError as error:
        raise ParameterError(
            f"the cluster '{cluster}' has no known form; give local:N or an address such as "
            "tcp://node:8786"
        ) from error
    except OSError as error:
        raise PlatformError(
            f"no scheduler of Dask answers at '{cluster}'; start one with `dask scheduler` and "
            "workers with `dask worker`, or correct the address"
        ) from error
    pool = stack.enter_context(client).get_executor(pure=False)
    stack.callback(pool.shutdown, wait=False)
    # A cluster without workers may be about to get some.
    return pool, lambda: max(sum(client.nthreads().values()), 1)
