"""The platform: the choice of libLLVM for Dr.Jit, available cores, and optional packages.

Dr.Jit compiles for the CPU with a libLLVM of the system: the one that the variable
DRJIT_LIBLLVM_PATH names, or else the first that it finds. With version 14 its LLVM backend is
disabled. With 15 and 16 it starts, but the process aborts when a kernel needs an instruction that
they lack, which no `except` can catch. Urushi therefore reads the version without loading the
library, chooses one of version 17 or newer before Dr.Jit loads any, and refuses older ones.
"""

import ctypes
import glob
import importlib
import importlib.metadata
import math
import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import NamedTuple

from urushi.errors import PlatformError

#: Environment variable that names the library for Dr.Jit.
LLVM_VARIABLE = "DRJIT_LIBLLVM_PATH"
#: The oldest major version that compiles every kernel.
OLDEST_LLVM = 17

_LIBATOMIC = "libatomic.so.1"
_LLVM_PATTERNS = {
    "linux": (
        "/usr/lib/*-linux-gnu/libLLVM*.so*",
        "/usr/lib/wsl/lib/libLLVM*.so*",
        "/usr/lib64/libLLVM*.so*",
        "/usr/lib64/llvm*/lib/libLLVM*.so*",
        "/usr/lib/libLLVM*.so*",
        "/usr/lib/llvm*/lib/libLLVM*.so*",
        "/usr/local/lib/libLLVM*.so*",
    ),
    "darwin": (
        "/opt/homebrew/Cellar/llvm*/*/lib/libLLVM.dylib",
        "/opt/homebrew/opt/llvm*/lib/libLLVM.dylib",
        "/usr/local/Cellar/llvm*/*/lib/libLLVM.dylib",
        "/usr/local/opt/llvm*/lib/libLLVM.dylib",
    ),
    "win32": (r"C:\Program Files\LLVM\bin\LLVM-C.dll",),
}
_INSTALL_LLVM = {
    "linux": "install it (Debian: apt install libllvm19)",
    "darwin": "install it (brew install llvm)",
    "win32": "install it (winget install LLVM.LLVM)",
}
# libLLVM-14.so.1, libLLVM.so.19.1, libLLVM-17.so, and Homebrew's .../Cellar/llvm/19.1.7/lib/...
_VERSION_IN_NAME = re.compile(
    r"libLLVM-(\d+)|libLLVM\.so\.(\d+)|/Cellar/llvm[^/]*/(\d+)[^/]*/lib/libLLVM\.dylib"
)
# LLVMGetVersion was added in LLVM 16; a library without it is older.
_ASK_LIBRARY = """
import ctypes, sys
library, version = ctypes.CDLL(sys.argv[1]), [ctypes.c_uint() for _ in range(3)]
if not hasattr(library, "LLVMGetVersion"):
    print(15)
else:
    library.LLVMGetVersion(*map(ctypes.byref, version))
    print(version[0].value)
"""

#: File of control groups, version 2: a container's limit of processor time in microseconds, or
#: "max", and the period that it applies to.
CGROUP_CPU_MAX = Path("/sys/fs/cgroup/cpu.max")


class LlvmStatus(NamedTuple):
    """The libLLVM that Dr.Jit uses, or would use, in this process."""

    path: Path | None  # the library's file, or None if none was found
    version: int | None  # its major version, or None if it is missing or unreadable
    problem: str | None  # in one sentence with the cure; None if every kernel can be compiled


def choose_llvm() -> None:
    """Let Dr.Jit use the newest suitable libLLVM of the system, unless the user has named one.

    It has no effect after the import of Dr.Jit, which loads the library.
    """
    if "drjit" in sys.modules or os.environ.get(LLVM_VARIABLE):
        return
    path, version = _newest_llvm()
    if (version or 0) >= OLDEST_LLVM:
        os.environ[LLVM_VARIABLE] = str(path)


@cache
def missing_library() -> str | None:
    """The missing system library to which Dr.Jit's wheel is linked, or None.

    Without the library, `import drjit` fails with an error that does not name it.
    """
    if sys.platform != "linux":
        return None
    try:
        ctypes.CDLL(_LIBATOMIC)
    except OSError:
        return _LIBATOMIC
    return None


def require_drjit() -> None:
    """Raise PlatformError, in one sentence with the cure, if Dr.Jit cannot be imported here."""
    library = missing_library()
    if library is not None:
        raise PlatformError(
            f"{library}, which Mitsuba needs, was not found; install it "
            "(Debian: apt install libatomic1)"
        )


def llvm_status() -> LlvmStatus:
    """Find the libLLVM that is or would be in use, without loading it."""
    named = os.environ.get(LLVM_VARIABLE)
    set_variable = f"set {LLVM_VARIABLE} to the file of libLLVM {OLDEST_LLVM} or newer"
    cure = f"{_INSTALL_LLVM.get(sys.platform, 'install it')} or {set_variable}"
    loaded = _loaded_llvm()
    if loaded is not None:
        path, version = loaded
        if not named and (_newest_llvm()[1] or 0) >= OLDEST_LLVM:
            cure = f"import urushi before mitsuba and drjit, to use a newer one, or {set_variable}"
    elif named:
        path, version = Path(named), llvm_version_of(Path(named))
        cure = f"{set_variable}, or unset it to let Urushi look for one"
    else:
        path, version = _newest_llvm()
    if version is not None and version >= OLDEST_LLVM:
        return LlvmStatus(path, version, None)
    if version is not None:
        problem = f"LLVM {version} ('{path}') is too old for Dr.Jit, which would abort with it"
    elif path is not None:
        problem = f"'{path}' is missing or no LLVM library"
    else:
        problem = f"libLLVM {OLDEST_LLVM} or newer, which Mitsuba needs, was not found"
    return LlvmStatus(path, version, f"{problem}; {cure}")


def require_llvm() -> None:
    """Raise PlatformError, in one sentence with the cure, without a suitable libLLVM."""
    require_drjit()
    problem = llvm_status().problem
    if problem is not None:
        raise PlatformError(problem)


@cache
def llvm_version_of(path: Path) -> int | None:
    """The major version of a libLLVM, from its file name or from a process that loads it.

    None if the file is missing or is no LLVM library.
    """
    target = path
    if path.name != str(path):  # the dynamic linker searches for a bare name
        try:
            target = path.resolve(strict=True)
        except OSError:
            return None
        found = _VERSION_IN_NAME.search(target.as_posix())
        if found:
            return int(next(group for group in found.groups() if group))
    try:
        run = subprocess.run(
            [sys.executable, "-S", "-c", _ASK_LIBRARY, str(target)],
            capture_output=True,
            text=True,
            timeout=30,
        )
        return int(run.stdout)
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return None


def _newest_llvm() -> tuple[Path | None, int | None]:
    """The system's newest libLLVM and its major version."""
    patterns = list(_LLVM_PATTERNS.get(sys.platform, ()))
    if sys.platform == "linux":
        folders = [*os.environ.get("LD_LIBRARY_PATH", "").split(":"), f"{sys.prefix}/lib"]
        patterns += [f"{glob.escape(f)}/libLLVM*.so*" for f in folders if f]
    # Parts of LLVM (libLLVMCore.so, ...) and archives are no candidates.
    libraries = {
        Path(name).resolve()
        for pattern in patterns
        for name in glob.glob(pattern)
        if re.fullmatch(r"(libLLVM(-\d+)?(\.so[\d.]*|\.dylib)|LLVM-C\.dll)", Path(name).name)
    }
    versions = {path: llvm_version_of(path) for path in sorted(libraries)}
    return max(versions.items(), key=lambda item: item[1] or 0, default=(None, None))


def _loaded_llvm() -> tuple[Path | None, int | None] | None:
    """The library that Dr.Jit has loaded, or None if Dr.Jit is not imported."""
    drjit = sys.modules.get("drjit")
    detail = getattr(drjit, "detail", None)
    if detail is None:
        return None
    version = detail.llvm_version()[0]
    if version < 0:  # found none, or refused it
        named = os.environ.get(LLVM_VARIABLE)
        path = Path(named) if named else None
        return (path, llvm_version_of(path)) if path else (None, None)
    try:  # the file in this process's memory, known on Linux only
        maps = Path("/proc/self/maps").read_text()
    except OSError:
        return None, version
    found = re.search(r"/\S*libLLVM[^/\s]*$", maps, re.MULTILINE)
    return Path(found.group()) if found else None, version


def available_cores() -> int:
    """Number of cores that this process may use, at least 1.

    It is the number in the affinity mask, limited by the processor time of a container.
    """
    if hasattr(os, "sched_getaffinity"):
        count = len(os.sched_getaffinity(0))
    else:
        count = os.cpu_count() or 1
    try:
        share, period = CGROUP_CPU_MAX.read_text(encoding="ascii").split()
        return max(min(count, math.ceil(int(share) / int(period))), 1)
    except (OSError, ValueError):  # no such file, or no limit
        return count


class Package(NamedTuple):
    """An optional package: as pip installs it, as Python imports it, and what it is used for."""

    name: str
    module: str
    purpose: str


#: Packages by the extra of this package that asks for them.
EXTRAS = {
    "train": (
        Package("jax", "jax", "gradients of training"),
        Package("optax", "optax", "optimisers of training"),
    ),
    "cluster": (Package("distributed", "distributed", "clusters"),),
    "materialx": (
        Package("materialx", "MaterialX", "MaterialX documents"),
        Package("openimageio", "OpenImageIO", "images and colours of MaterialX documents"),
    ),
}


def require_extra(extra: str) -> None:
    """Raise PlatformError unless the packages of an extra can be imported."""
    for package in EXTRAS[extra]:
        try:
            importlib.import_module(package.module)
        except ImportError as error:
            raise PlatformError(
                f"{package.purpose} need the package '{package.name}', which is missing; install "
                f"it: {install_command(extra)}"
            ) from error


def install_command(extra: str) -> str:
    """The command that installs the packages of an extra, in the versions that this one needs."""
    mark = f"extra == '{extra}'"
    wanted = [line.partition(";") for line in importlib.metadata.requires("urushi") or ()]
    names = [f"'{name.strip()}'" for name, _, condition in wanted if mark in condition]
    return f"pip install {' '.join(names)}"
