"""The choice of libLLVM, by fakes and by old real ones in other processes; the number of cores."""

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
        ("Cellar/llvm/19.1.7_1/lib/libLLVM.dylib", 19),  # of Homebrew
    ],
)
def test_version_is_read_from_the_name_and_through_links(machine, tmp_path, name, version):
    (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
    assert platform.llvm_version_of(machine(name)) == version
    link = tmp_path / "libLLVM-18.so"
    link.symlink_to(tmp_path / name)
    assert platform.llvm_version_of(link) == version


def test_version_is_read_from_the_library_if_its_name_lacks_it(tmp_path):
    real = _real(at_least=platform.OLDEST_LLVM)
    link = tmp_path / "LLVM-C.dll"
    try:
        link.hardlink_to(real)  # a symbolic link would be resolved to a name with the version
    except OSError:
        pytest.skip("temporary files lie on another disk than libLLVM")
    assert platform.llvm_version_of(link) == platform.llvm_version_of(Path(real))


def test_no_library_at_all(machine):
    assert platform.llvm_status()[:2] == (None, None)
    with pytest.raises(PlatformError, match="was not found; install it .*libllvm19"):
        platform.require_llvm()


@pytest.mark.parametrize("name", ["nowhere/libLLVM.so.19.1", "something.so"])
def test_a_named_file_that_is_missing_or_no_library(machine, monkeypatch, tmp_path, name):
    machine("libLLVM.so.19.1")
    (tmp_path / "something.so").write_text("no library")
    monkeypatch.setenv(platform.LLVM_VARIABLE, str(tmp_path / name))
    with pytest.raises(PlatformError, match=f"{name}' is missing or no LLVM library; set "):
        platform.require_llvm()


@pytest.mark.parametrize("name", ["libLLVM-14.so.1", "libLLVM-15.so.1", "libLLVM-16.so.1"])
def test_an_old_library_is_refused_in_one_sentence(machine, name):
    path = machine(name)
    platform.choose_llvm()
    assert platform.LLVM_VARIABLE not in os.environ
    with pytest.raises(PlatformError) as caught:
        platform.require_llvm()
    parts = str(path), "too old", "17 or newer"
    assert all(part in str(caught.value) for part in parts) and "\n" not in str(caught.value)


def test_the_newest_fit_library_is_chosen_or_the_users(machine, monkeypatch):
    """Empty counts as unset; the last name is of a part, not of the whole."""
    names = "-14.so.1", "-17.so.1", ".so.19.1", "-16.so.1", "Core.so.20"
    files = [machine(f"libLLVM{name}") for name in names]
    for given, chosen in (("", files[2]), (str(files[1]), files[1])):
        monkeypatch.setenv(platform.LLVM_VARIABLE, given)
        platform.choose_llvm()
        assert os.environ[platform.LLVM_VARIABLE] == str(chosen)
        assert platform.llvm_status().path == chosen
        platform.require_llvm()


def test_a_bare_machine_imports_urushi_and_a_missing_libatomic_is_named():
    """A bare Debian lacks it, and LLVM; Dr.Jit's own error does not say so."""
    code = (
        "import ctypes\n"
        "def missing(name): raise OSError(name)\n"
        "ctypes.CDLL = missing\n"
        "import urushi, sys; assert 'mitsuba' not in sys.modules\n"
        "assert not urushi.platform.llvm_status().version\n"
        "for use in (urushi.platform.require_llvm, lambda: urushi.simulate):\n"
        "    try: use()\n"
        "    except urushi.errors.PlatformError as error: print(error)"
    )
    run = _python(code, **{platform.LLVM_VARIABLE: "/nowhere"})
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


@pytest.mark.parametrize(
    "code",
    [
        "import drjit, urushi; urushi.platform.require_llvm()",
        "import urushi, mitsuba as mi; mi.set_variant('llvm_ad_rgb')",
        "import mitsuba as mi, urushi; mi.set_variant('llvm_ad_rgb')",
        "from urushi.app import cli; raise SystemExit(cli.main(['render', 'caddy']))",
    ],
)
def test_an_old_library_is_refused_before_it_aborts_the_process(code):
    """Dr.Jit would start with LLVM 15, and abort the process at a later kernel."""
    old = _real(at_least=15, below=platform.OLDEST_LLVM)
    run = _python(code, **{platform.LLVM_VARIABLE: old})
    assert run.returncode in (1, 2)  # of Python, and of the command
    last = run.stderr.splitlines()[-1]
    assert last.startswith(("urushi.errors.PlatformError: LLVM 1", "urushi: LLVM 1"))
    assert "is too old" in last


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


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("max 100000\n", 8),
        ("200000 100000\n", 2),
        ("150000 100000\n", 2),  # one and a half are worth two threads
        ("5000 100000\n", 1),
        ("9900000 100000\n", 8),
        ("", 8),
        (None, 8),
    ],
)
def test_cores_are_those_of_the_mask_and_of_a_containers_limit(
    text, expected, tmp_path, monkeypatch
):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)), raising=False)
    monkeypatch.setattr(platform, "CGROUP_CPU_MAX", tmp_path / "cpu.max")
    if text is not None:
        platform.CGROUP_CPU_MAX.write_text(text)
    assert platform.available_cores() == expected
