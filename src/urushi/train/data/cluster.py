"""Function calls on a Dask cluster; no other module imports Dask (the optional extra `cluster`)."""

import contextlib
import pkgutil
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

from urushi.errors import PlatformError
from urushi.version import __version__

#: Seconds to wait for the scheduler, and then for its first worker.
PATIENCE = 20.0

#: Number of tasks submitted for every worker process: one runs, and one waits there for it to end.
IN_FLIGHT = 2

#: Held by the running task of a worker process, because a task uses all cores.
_alone = threading.Lock()


def run(
    address: str, function: Callable[..., Any], arguments: Sequence[tuple]
) -> Iterator[tuple[int, Any]]:
    """Call a pure function for many arguments on the cluster's workers.

    Args:
        address: the scheduler's address, as `dask scheduler` prints it: "tcp://host:8786".
        function: a function of a module that the workers can import. Its result must not depend on
            the worker, because the tasks of a worker that dies run again on another one.
        arguments: the arguments of each call.

    Yields:
        (index, result) of each call, in the order of completion. At most `IN_FLIGHT` tasks of each
        worker are submitted at a time, which bounds the memory on both sides.

    Raises:
        PlatformError: there is no such scheduler, it has no worker, it or a worker lacks this
            Urushi, or a task killed its workers again and again.
        Exception: raised by a call.
    """
    from distributed import KilledWorker, as_completed

    with _connected(address) as client:
        _check_scheduler(client)
        waiting = iter(range(len(arguments)))
        indices: dict[Any, int] = {}
        checked: set[str] = set()

        def hand_over() -> list[Any]:
            workers = set(client.nthreads())
            _check_workers(client, workers - checked)
            checked.update(workers)
            room = IN_FLIGHT * max(1, len(workers)) - len(indices)
            chosen = [index for _, index in zip(range(room), waiting, strict=False)]
            new = [client.submit(_call, function, arguments[k], pure=False) for k in chosen]
            indices.update(zip(new, chosen, strict=True))
            return new

        done = as_completed(hand_over(), loop=client.loop)
        for future in done:
            try:
                result = future.result()
            except KilledWorker as error:
                raise PlatformError(
                    f"a task on the cluster at '{address}' repeatedly killed its worker; "
                    "give each worker more memory"
                ) from error
            yield indices.pop(future), result
            done.update(hand_over())


def _call(function: Callable[..., Any], arguments: tuple) -> Any:
    with _alone:
        return function(*arguments)


@contextlib.contextmanager
def _connected(address: str) -> Iterator[Any]:
    """A client of a cluster with at least one worker; its tasks are cancelled at the end."""
    from distributed import Client

    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:  # a timeout is an OSError
        raise PlatformError(
            f"there is no Dask scheduler at '{address}'; start one with `dask scheduler`, "
            "and give the address that it prints"
        ) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError as error:
            raise PlatformError(
                f"the Dask scheduler at '{address}' has no worker; "
                f"start at least one with `dask worker {address}`"
            ) from error
        yield client


#: A call that returns the version of Urushi in a remote process. It uses the standard library only,
#: because a process that cannot import Urushi would never finish a call of Urushi's own function.
_VERSION = pkgutil.resolve_name, "urushi:__version__"


def _check_scheduler(client: Any) -> None:
    """Check that the scheduler, which also unpickles the tasks, has this version of Urushi."""
    try:
        found = client.run_on_scheduler(*_VERSION)
    except ImportError as error:
        found = error
    _check("scheduler", client.scheduler.address, found)


def _check_workers(client: Any, workers: Iterable[str]) -> None:
    """Check that workers have this version of Urushi; workers that have left are ignored."""
    chosen = sorted(workers)
    if chosen:
        for address, found in client.run(*_VERSION, workers=chosen, on_error="return").items():
            if isinstance(found, str | ImportError):
                _check("worker", address, found)


def _check(kind: str, address: str, found: str | ImportError) -> None:
    wanted = __version__
    if isinstance(found, ImportError):
        raise PlatformError(
            f"the Dask {kind} at '{address}' cannot import Urushi ({found}); install Urushi "
            f"{wanted} in the environment that `dask {kind}` runs in"
        )
    if found != wanted:
        raise PlatformError(
            f"the Dask {kind} at '{address}' has Urushi {found}, but here it is {wanted}; "
            "install the same version everywhere"
        )
