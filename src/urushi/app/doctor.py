"""`urushi doctor`: check this machine, and report what is missing and how to fix it.

Every Mitsuba variant is tried in a process of its own, because a bad LLVM library or driver may
abort the process.
"""

import importlib.metadata
import platform
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from urushi.errors import UrushiError
from urushi.platform import EXTRAS, install_command, llvm_status, require_drjit

VARIANTS = ("scalar_rgb", "llvm_ad_rgb", "llvm_ad_mono", "llvm_ad_spectral", "cuda_ad_rgb")
_PROBE = """
import sys
import urushi, mitsuba as mi
mi.set_variant(sys.argv[1])
assert mi.Point3f(1, 2, 3).z * 2 == 6
"""
#: Longest time for a variant to start [s].
_TIMEOUT = 120


@dataclass(frozen=True)
class Finding:
    """The result of one check."""

    name: str  # what was checked
    found: str  # its version or state
    problem: str | None = None  # what is wrong and the cure, or None if all is well
    essential: bool = False  # whether Urushi cannot work without it


def examine() -> list[Finding]:
    """Run all checks, the most basic first."""
    names = VARIANTS if shutil.which("nvidia-smi") else VARIANTS[:-1]
    with ThreadPoolExecutor(len(names)) as pool:
        variants = list(pool.map(_variant, names))
    return [
        Finding("Python", f"{platform.python_version()} ({sys.executable})"),
        _package("mitsuba", (3, 9), (3, 10)),
        _drjit(),
        _llvm(),
        _gpu(),
        *variants,
        *_weights(),
        *_extras(),
    ]


def _package(
    name: str, oldest: tuple[int, int] = (0, 0), below: tuple[int, int] = (99, 0)
) -> Finding:
    version = _version(name)
    if version is None:
        return Finding(name, "missing", f"install it (pip install {name})", True)
    numbers = re.match(r"(\d+)\.(\d+)", version)
    fits = numbers is None or oldest <= (int(numbers[1]), int(numbers[2])) < below
    wanted = f">={'.'.join(map(str, oldest))},<{'.'.join(map(str, below))}"
    cure = f"unsupported version; install another (pip install '{name}{wanted}')"
    return Finding(name, version, None if fits else cure, True)


def _drjit() -> Finding:
    try:
        require_drjit()
    except UrushiError as error:
        return Finding("drjit", _version("drjit") or "missing", str(error), True)
    return _package("drjit")


def _llvm() -> Finding:
    path, version, problem = llvm_status()
    found = "missing" if problem and path is None else f"{version or '?'} ({path})"
    return Finding("LLVM", found, problem, True)


def _variant(name: str) -> Finding:
    """Start a variant in a process of its own."""
    label, essential = f"variant {name}", name == "llvm_ad_rgb"
    try:
        probe = [sys.executable, "-c", _PROBE, name]
        run = subprocess.run(probe, capture_output=True, text=True, timeout=_TIMEOUT)
    except subprocess.TimeoutExpired:
        return Finding(label, "not usable", f"no answer in {_TIMEOUT} seconds", essential)
    except OSError as error:
        return Finding(label, "not usable", f"{sys.executable}: {error.strerror}", essential)
    if run.returncode == 0:
        return Finding(label, "usable", essential=essential)
    reason = (run.stderr.strip().splitlines() or [f"exit code {run.returncode}"])[-1]
    return Finding(label, "not usable", reason, essential)


def _gpu() -> Finding:
    query = ["nvidia-smi", "--query-gpu=name,driver_version", "--format=csv,noheader"]
    try:
        run = subprocess.run(query, capture_output=True, text=True, timeout=30)
        found = "; ".join((run.stdout or run.stderr).split("\n")).strip("; ")
    except (OSError, subprocess.TimeoutExpired):
        found = "no NVIDIA driver; the LLVM variants run on the CPU"
    return Finding("GPU", found)


def _weights() -> Iterator[Finding]:
    from urushi.nets import weights

    folder = weights.SHIPPED
    files = sorted(folder.glob("*.safetensors"))
    if not files:
        yield Finding("weights", "missing", f"'{folder}' has none; install urushi again", True)
    for file in files:
        name = f"weights {file.stem}"
        try:
            model = weights.read(file)
        except UrushiError as error:
            yield Finding(name, "not usable", str(error), True)
            continue
        metrics = model.header.get("metrics", {}).items()
        details = [f"fingerprint {model.fingerprint}", *(f"{k} {x:.3g}" for k, x in metrics)]
        yield Finding(name, ", ".join(details), None, True)


def _extras() -> Iterator[Finding]:
    """The optional packages, one finding each."""
    for extra, packages in EXTRAS.items():
        for package in packages:
            version, name = _version(package.name), f"extra {extra}: {package.name}"
            cure = f"needed for {package.purpose}: {install_command(extra)}"
            found = f"{version or 'missing'} ({package.purpose})"
            yield Finding(name, found, None if version else cure)


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


@dataclass(frozen=True)
class Doctor:
    """Check this machine: print what Urushi finds, what is wrong, and how to fix it.

    Checks Python, Mitsuba, Dr.Jit, LLVM, the GPU, Mitsuba's variants, the shipped weights and every
    optional package. The exit code is 1 if something is wrong that Urushi cannot work without.

    Example: urushi doctor
    """

    def run(self) -> int:
        findings = examine()
        width = max(len(finding.name) for finding in findings)
        for finding in findings:
            print(f"{finding.name:<{width}}  {finding.found}")
            if finding.problem:
                kind = "PROBLEM" if finding.essential else "note"
                print(f"{'':<{width}}  {kind}: {finding.problem}")
        wrong = [finding.name for finding in findings if finding.problem and finding.essential]
        print(f"\nProblems: {', '.join(wrong)}." if wrong else "\nAll essential parts work.")
        return 1 if wrong else 0
