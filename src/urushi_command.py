"""The console script `urushi`: an interrupt is one sentence, also while Python still imports.

It is no part of the package, because importing any part of that imports Mitsuba first.

Python raises KeyboardInterrupt between two of its own instructions. A call of Mitsuba, Dr.Jit, JAX
or NumPy may take minutes. A thread therefore waits for the signal too, and ends the process if the
exception has not done so.
"""

import io
import os
import signal
import sys
import threading
from typing import NoReturn

INTERRUPTED = 130  # 128 + SIGINT, as shells report it

#: How long the exception may take to end the command [s].
GRACE = 0.5


def main() -> int:
    """`urushi.app.cli.main`, with its exit code for an interrupt, which ends the process."""
    if sys.stderr is None:  # closed: progress bars and sentences go nowhere
        sys.stderr = io.StringIO()
    if isinstance(sys.stdout, io.TextIOWrapper):  # None if it is closed
        sys.stdout.reconfigure(errors="backslashreplace")  # as of standard error
    finished = threading.Event()
    _watch(finished)
    handler = signal.getsignal(signal.SIGINT)
    if callable(handler):  # no exception while packages start: some abort the process by it
        signal.signal(signal.SIGINT, lambda *_: _interrupt())
    from urushi.app import cli

    signal.signal(signal.SIGINT, handler)
    code = cli.main()
    finished.set()
    if code == INTERRUPTED:
        _end()  # at the end of the interpreter, Dr.Jit would wait for kernels that still run
    return code


def _watch(finished: threading.Event) -> None:
    """Start the thread that ends an unfinished process soon after an interrupt."""
    receiver, sender = os.pipe()
    os.set_blocking(sender, False)
    signal.set_wakeup_fd(sender, warn_on_full_buffer=False)

    def wait() -> None:
        while os.read(receiver, 1) != bytes([signal.SIGINT]):
            pass
        if not finished.wait(GRACE):
            _interrupt()

    threading.Thread(target=wait, daemon=True).start()


def _interrupt() -> NoReturn:
    try:
        if sys.stderr.isatty():
            print(file=sys.stderr)  # after a progress bar
        print("urushi: interrupted; nothing half-written was left behind", file=sys.stderr)
    finally:
        _end()


def _end() -> NoReturn:
    """End the process at once, without temporary files and half-printed lines."""
    try:
        if "urushi.files" in sys.modules:
            sys.modules["urushi.files"].remove_temporary_files()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
    finally:  # also if a stream is closed, or its disk is full
        os._exit(INTERRUPTED)


if __name__ == "__main__":
    sys.exit(main())
