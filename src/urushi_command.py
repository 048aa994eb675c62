"""The console script `urushi`: an interrupt is one sentence, also while Python still imports.

It is no part of the package, because importing any part of that imports Mitsuba first.

Python raises KeyboardInterrupt between two of its own instructions. A call of Mitsuba, Dr.Jit, JAX
or NumPy may take minutes. A thread therefore waits for the signal too, and ends the process if the
exception has not done so.
"""

import _signal  # built in: Python's `signal`, `threading` and `typing` import for 20 ms
import io
import os
import sys

INTERRUPTED = 130  # 128 + SIGINT, as shells report it

#: How long the exception may take to end the command [s].
GRACE = 0.5


def main() -> int:
    """`urushi.app.cli.main`, with its exit code for an interrupt, which ends the process."""
    handler = _signal.getsignal(_signal.SIGINT)
    if callable(handler):  # no exception while packages start: some abort the process by it
        _signal.signal(_signal.SIGINT, lambda *_: _interrupt())
    if sys.stderr is None:  # closed: progress bars and sentences go nowhere
        sys.stderr = io.StringIO()
    if isinstance(sys.stdout, io.TextIOWrapper):  # None if it is closed
        sys.stdout.reconfigure(errors="backslashreplace")  # as of standard error
    import threading

    finished = threading.Event()
    receiver, sender = os.pipe()
    os.set_blocking(sender, False)
    _signal.set_wakeup_fd(sender, warn_on_full_buffer=False)

    def watch() -> None:
        """End an unfinished process soon after an interrupt."""
        while os.read(receiver, 1) != bytes([_signal.SIGINT]):
            pass
        if not finished.wait(GRACE):
            _interrupt()

    threading.Thread(target=watch, daemon=True).start()
    from urushi.app import cli

    _signal.signal(_signal.SIGINT, handler)
    code = cli.main()
    finished.set()
    if code == INTERRUPTED:
        _end()  # at the end of the interpreter, Dr.Jit would wait for kernels that still run
    return code


def _interrupt() -> None:
    try:
        if sys.stderr.isatty():
            print(file=sys.stderr)  # after a progress bar
        print("urushi: interrupted; nothing half-written was left behind", file=sys.stderr)
    finally:
        _end()


def _end() -> None:
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
