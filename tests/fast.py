"""Dr.Jit's kernels without LLVM's optional passes, here or in a script: python -m tests.fast SCRIPT

In tests, most kernels compile for longer than they run.
"""

import ctypes
import runpy
import sys

from urushi.platform import llvm_status


def skip_optional_passes() -> None:
    """Set an option of the library LLVM, which all kernels of this process share."""
    path = llvm_status().path
    if path is None:
        return
    options = [b"pytest", b"-opt-bisect-limit=0", b"-opt-bisect-verbose=0"]
    texts = (ctypes.c_char_p * len(options))(*options)
    ctypes.CDLL(str(path)).LLVMParseCommandLineOptions(len(options), texts, None)


if __name__ == "__main__":
    skip_optional_passes()
    del sys.argv[0]
    runpy.run_path(sys.argv[0], run_name="__main__")
