"""The choice of libLLVM: fakes stand in for libraries, and old real ones run in other processes."""

import glob
import os
import subprocess
import sys
from pathlib import Path

import pytest

from urushi import platform
from urushi.errors import PlatformError


@pytest.fixture
def machine(monkeypatch, tmp_path):
    """A machine without libLLVM and without Dr.Jit loaded; returns a maker of fake libraries."""
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv(platform.LLVM_VARIABLE, raising=False)
    monkeypatch.delenv("LD_LIBRARY_PATH", raising=False)
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "nowhere"))
    monkeypatch.setitem(platform._LLVM_PATTERNS, "linux", (f"{tmp_path}/libLLVM*.so*",))
    monkeypatch.delitem(sys.modules, "drjit", raising=False)

    def library(name: str) -> Path:
        path = tmp_path / name
        path.write_bytes(b"\x7fELF")
        return path

    return library


@pytest.mark.parametrize(
    ("name", "version"),
    [
        ("libLLVM-14.so.1", 14),
        ("libLLVM-15.so", 15),
        ("libLLVM.so.19.1", 19),
        ("libLLVM.so.22.1", 22),
        ("libLLVM-17.so.1", 17),
    ],
)
def test_version_is_read_from_the_name(machine, name, version):
    assert platform.llvm_version_of(machine(name)) == version


def test_version_is_read_through_links(machine, tmp_path):
    target = machine("libLLVM.so.19.1")
    link = tmp_path / "libLLVM-18.so"
    link.symlink_to(target)
    assert platform.llvm_version_of(link) == 19


def test_homebrew_names_the_version_in_the_folder(tmp_path):
    library = tmp_path / "Cellar" / "llvm" / "19.1.7_1" / "lib" / "libLLVM.dylib"
    library.parent.mkdir(parents=True)
    library.touch()
    assert platform.llvm_version_of(library) == 19


def test_version_is_read_from_the_library_if_its_name_lacks_it(tmp_path):
    real = _real(at_least=platform.OLDEST_LLVM)
    link = tmp_path / "LLVM-C.dll"
    try:
        link.hardlink_to(real)  # a symbolic link would be resolved to a name with the version
    except OSError:
        pytest.skip("temporary files lie on another disk than libLLVM")
    assert platform.llvm_version_of(link) == platform.llvm_version_of(Path(real))


def test_no_library_at_all(machine):
    status = platform.llvm_status()
    assert (status.path, status.version) == (None, None)
    assert "libllvm19" in status.problem
    with pytest.raises(PlatformError, match="was not found; install it"):
        platform.require_llvm()


def test_a_missing_named_library(machine, monkeypatch):
    machine("libLLVM.so.19.1")
    monkeypatch.setenv(platform.LLVM_VARIABLE, "/nowhere/libLLVM.so.19.1")
    with pytest.raises(PlatformError, match="'/nowhere/libLLVM.so.19.1' is missing or no LLVM"):
        platform.require_llvm()


def test_a_foreign_named_library(machine, monkeypatch, tmp_path):
    foreign = tmp_path / "something.so"
    foreign.write_text("no library")
    monkeypatch.setenv(platform.LLVM_VARIABLE, str(foreign))
    with pytest.raises(PlatformError, match="is missing or no LLVM library"):
        platform.require_llvm()


@pytest.mark.parametrize("name", ["libLLVM-14.so.1", "libLLVM-15.so.1", "libLLVM-16.so.1"])
def test_an_old_library_is_refused_in_one_sentence(machine, name):
    path = machine(name)
    platform.choose_llvm()
    assert platform.LLVM_VARIABLE not in os.environ
    with pytest.raises(PlatformError) as caught:
        platform.require_llvm()
    assert str(path) in str(caught.value)
    assert "too old" in str(caught.value)
    assert "17 or newer" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_newest_fit_library_is_chosen(machine, monkeypatch):
    monkeypatch.setenv(platform.LLVM_VARIABLE, "")  # so that it is restored; empty counts as unset
    machine("libLLVM-14.so.1")
    machine("libLLVM-17.so.1")
    newest = machine("libLLVM.so.19.1")
    machine("libLLVM-16.so.1")
    machine("libLLVMCore.so.20")  # a part, not the whole
    platform.choose_llvm()
    assert os.environ[platform.LLVM_VARIABLE] == str(newest)
    assert platform.llvm_status().version == 19
    platform.require_llvm()


def test_the_users_choice_is_respected(machine, monkeypatch):
    machine("libLLVM.so.19.1")
    chosen = machine("libLLVM-17.so.1")
    monkeypatch.setenv(platform.LLVM_VARIABLE, str(chosen))
    platform.choose_llvm()
    assert os.environ[platform.LLVM_VARIABLE] == str(chosen)
    assert platform.llvm_status().path == chosen


def test_a_missing_libatomic_is_named():
    """A bare Debian lacks it; Dr.Jit's own error does not say so."""
    code = (
        "import ctypes\n"
        "def missing(name): raise OSError(name)\n"
        "ctypes.CDLL = missing\n"
        "import urushi, sys; assert 'mitsuba' not in sys.modules\n"
        "for use in (urushi.platform.require_llvm, lambda: urushi.simulate):\n"
        "    try: use()\n"
        "    except urushi.errors.PlatformError as error: print(error)"
    )
    run = _python(code)
    assert run.returncode == 0, run.stderr
    sentence = "libatomic.so.1, which Mitsuba needs, was not found; install it"
    assert run.stdout.count(sentence) == (2 if sys.platform == "linux" else 0)


def test_import_chooses_before_drjit_loads():
    _real(at_least=platform.OLDEST_LLVM)
    code = (
        "import urushi, sys, os; assert 'jax' not in sys.modules;"
        "from urushi import platform; assert not platform.llvm_status().problem;"
        "import mitsuba as mi; mi.set_variant('llvm_ad_rgb');"
        "assert not platform.llvm_status().problem;"
        "import drjit; assert drjit.detail.llvm_version()[0] >= 17"
    )
    run = _python(code, **{platform.LLVM_VARIABLE: ""})
    assert run.returncode == 0, run.stderr


def test_an_old_library_that_is_already_loaded_is_told():
    old = _real(below=platform.OLDEST_LLVM)
    code = (
        "import drjit, urushi; from urushi import platform, errors\n"
        "try: platform.require_llvm()\n"
        "except errors.PlatformError as error: print(error)"
    )
    run = _python(code, **{platform.LLVM_VARIABLE: old})
    assert run.returncode == 0, run.stderr
    assert "is too old" in run.stdout


@pytest.mark.parametrize("order", ["import urushi, mitsuba as mi", "import mitsuba as mi, urushi"])
def test_an_old_library_is_refused_when_a_variant_is_set(order):
    """Dr.Jit would start with LLVM 15, and abort the process at a later kernel."""
    old = _real(at_least=15, below=platform.OLDEST_LLVM)
    code = (
        f"{order}\n"
        "try: mi.set_variant('llvm_ad_rgb')\n"
        "except urushi.errors.PlatformError as error: print(error)"
    )
    run = _python(code, **{platform.LLVM_VARIABLE: old})
    assert run.returncode == 0, run.stderr
    assert "is too old" in run.stdout


def test_an_old_library_does_not_abort_the_command_line(tmp_path):
    old = _real(below=platform.OLDEST_LLVM)
    scene = tmp_path / "scene.xml"
    scene.write_text('<scene version="3.0.0"/>')
    run = _python(
        f"from urushi.app import cli; raise SystemExit(cli.main(['render', {str(scene)!r}]))",
        **{platform.LLVM_VARIABLE: old},
    )
    assert run.returncode == 2
    assert run.stderr.splitlines()[-1].startswith("urushi: LLVM ")


def test_import_without_any_library():
    run = _python(
        "import urushi; urushi.platform.llvm_status()", **{platform.LLVM_VARIABLE: "/nowhere"}
    )
    assert run.returncode == 0, run.stderr


def _python(code: str, **environment: str) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        timeout=120,
    )


def _real(*, at_least: int = 0, below: int = 1000) -> str:
    """A libLLVM of this machine in a range of versions; skips where there is none."""
    for pattern in platform._LLVM_PATTERNS.get(sys.platform, ()):
        for name in glob.glob(pattern):
            if not Path(name).name.startswith(("libLLVM-", "libLLVM.")) or name.endswith(".a"):
                continue
            version = platform.llvm_version_of(Path(name))
            if version is not None and at_least <= version < below:
                return str(Path(name).resolve())
    pytest.skip(f"this machine has no libLLVM in [{at_least}, {below})")
