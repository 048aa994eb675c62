"""Settings of the test run, and fixtures that tests of several floors share."""

import importlib.util
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from tests.directions import pairs_near_mirrors
from tests.fast import skip_optional_passes

from urushi.platform import available_cores

ROOT = Path(__file__).resolve().parents[1]

# JAX reads these when it is imported, which the conftest of a folder may do before
# `pytest_configure`. It compiles each training step once, though many tests and workers use it.
if "PYTEST_XDIST_WORKER" not in os.environ:
    os.environ["JAX_COMPILATION_CACHE_DIR"] = tempfile.mkdtemp(prefix="urushi-test-jax-")
    os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0.2"
    os.environ["JAX_DISABLE_MOST_OPTIMIZATIONS"] = "1"  # compiling takes longer than running


skip_optional_passes()


def pytest_configure(config: pytest.Config) -> None:
    """Settings that all workers and the processes started by tests inherit."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # a shell's background job
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if hasattr(config, "workerinput"):
        return
    cache = os.environ["JAX_COMPILATION_CACHE_DIR"]
    config.add_cleanup(lambda: shutil.rmtree(cache, ignore_errors=True))
    workers = config.getoption("numprocesses", None) or 1
    if workers > 1:  # each has its share of the cores: threads that wait for a core spin
        threads = max(available_cores() // workers, 1)
        os.environ.setdefault("OPENBLAS_NUM_THREADS", str(threads))
        if threads == 1:
            os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false")


#: Folders of tests by their tier: a marker, and the subjects that no user's machine needs to prove.
TIERS = {
    "slow": ("train", "fan2022"),  # each loss and stage compiles for seconds
    "research": ("benchmarks", "gallery", "research"),  # not in the wheel
}


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out folders of a tier that `-m` deselects: importing their modules takes seconds."""
    folder = collection_path.relative_to(ROOT / "tests").parts[:1]
    tiers = [tier for tier in TIERS if {*folder} & {*TIERS[tier]}]
    return any(f"not {tier}" in config.option.markexpr for tier in tiers) or None


#: Tests and cases by their tier, file and name; see the file's first lines.
CASES = tomllib.loads((ROOT / "tests" / "tiers.toml").read_text())


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark the tests of whole folders, and those that `tiers.toml` names.

    The files of commands come last. They are short: at the end, one worker waits for the other.
    """
    items.sort(key=lambda item: item.path.relative_to(ROOT / "tests").parts[0] == "app")
    found = set()
    for item in items:
        path = item.path.relative_to(ROOT / "tests")
        name, _, case = item.name.removesuffix("]").partition("[")
        for tier in TIERS:
            cases = CASES[tier].get(path.as_posix(), {}).get(name, [])
            if path.parts[0] in TIERS[tier] or cases is True or case in cases:
                item.add_marker(tier)
                found.add((tier, path.as_posix(), name, case))
    if any("::" in argument for argument in config.args):
        return  # some tests alone
    collected = {item.path.relative_to(ROOT / "tests").as_posix() for item in items}
    for tier, files in CASES.items():
        for path in files.keys() & collected:
            for name, cases in files[path].items():
                named = {entry[3] for entry in found if entry[:3] == (tier, path, name)}
                missing = not named if cases is True else set(cases) - named
                if missing:
                    raise pytest.UsageError(f"tiers.toml: {path} has no {name} {missing}")


#: Folders whose tests compute with Dr.Jit, and those among them that read EXR files, for which
#: Mitsuba waits for ever if it has one thread.
COMPUTING = ("fan2022", "material", "measured", "mitsuba", "openpbr_surface", "walk")
READING = "materialx"


@pytest.fixture(autouse=True, scope="module")
def _share_of_the_cores(request: pytest.FixtureRequest):
    """Give Dr.Jit one thread beside other workers: its threads spin while they wait."""
    folders = request.path.relative_to(ROOT / "tests").parts
    alone = "PYTEST_XDIST_WORKER" not in os.environ
    if alone or folders[0] not in COMPUTING or READING in folders:
        yield
        return
    import drjit as dr

    before = dr.thread_count()
    dr.set_thread_count(max(before // int(os.environ["PYTEST_XDIST_WORKER_COUNT"]), 1))
    yield
    dr.set_thread_count(before)


@pytest.fixture(scope="session")
def stored() -> Callable[[str], Path]:
    """A function: the path of a file or folder of test data outside the repository.

    Without it, the test is skipped.
    """

    def path(name: str) -> Path:
        found = Path(os.environ.get("URUSHI_TEST_DATA", ROOT.parent / "shared"), name)
        if not found.exists():
            pytest.skip(f"'{found}' is missing; set URUSHI_TEST_DATA to the folder of test data")
        return found

    return path


Sphere = Callable[[np.ndarray], np.ndarray]


@pytest.fixture(scope="session")
def sphere_test() -> Callable[[np.ndarray, Sphere], float]:
    """Pearson's chi-squared test of directions on the sphere: see `sphere_p_value`."""
    return sphere_p_value


def sphere_p_value(samples: np.ndarray, pdf: Sphere, *, cells: int = 24, fine: int = 48) -> float:
    """The p-value of the hypothesis that `samples` (N, 3) have the density `pdf` [1/sr].

    Rows of NaN are failed samples; their share must equal one minus the integral of the density.
    The sphere is divided into `cells` x `cells` of equal solid angle, and the density is integrated
    over each by `fine` x `fine` Gauss points. Cells that expect fewer than 10 samples are pooled.
    """
    from scipy import stats

    count = len(samples)
    node, weight = np.polynomial.legendre.leggauss(fine)
    ends = np.add.outer(np.arange(cells), (node + 1) / 2).ravel() / cells
    z, phi = np.meshgrid(2 * ends - 1, 2 * np.pi * ends - np.pi, indexing="ij")
    r = np.sqrt(1 - z * z)
    points = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1).reshape(-1, 3)
    density = np.asarray(pdf(points.astype(np.float32)), np.float64)
    blocks = np.einsum("iajb,a,b", density.reshape(cells, fine, cells, fine), weight, weight) / 4
    expected = (blocks * (4 * np.pi / cells**2) * count).ravel()
    found = samples[~np.isnan(samples[:, 0])].astype(np.float64)
    row = np.clip((found[:, 2] + 1) / 2 * cells, 0, cells - 1).astype(int)
    angle = np.arctan2(found[:, 1], found[:, 0])
    column = np.clip((angle / np.pi + 1) / 2 * cells, 0, cells - 1).astype(int)
    observed = np.bincount(row * cells + column, minlength=cells**2).astype(np.float64)
    # At critical angles the density has kinks; the error of the quadrature is up to 0.2 %.
    share, missing = 1 - len(found) / count, 1 - expected.sum() / count
    assert abs(share - missing) < 5 * np.sqrt(share / count) + 2e-3
    expected *= len(found) / expected.sum()
    small = expected < 10
    expected = np.append(expected[~small], expected[small].sum())
    observed = np.append(observed[~small], observed[small].sum())
    kept = expected > 0
    assert not observed[~kept].any()
    return float(stats.chisquare(observed[kept], expected[kept]).pvalue)


@cache
def has_cuda() -> bool:
    """Whether CUDA kernels run here. Another process tries: a driver may abort its process."""
    probe = "import drjit.cuda as c; assert (c.Float([1, 2]) + 1)[1] == 3"
    run = subprocess.run([sys.executable, "-c", probe], capture_output=True, timeout=120)
    return run.returncode == 0


@pytest.fixture(params=["llvm_ad_rgb", "cuda_ad_rgb"])
def variant(request: pytest.FixtureRequest) -> str:
    """The variant of Mitsuba; the test runs once in each that this machine supports."""
    name = request.param
    if name.startswith("cuda") and not has_cuda():
        pytest.skip("no NVIDIA GPU that Dr.Jit can use")
    import mitsuba as mi

    import urushi  # noqa: F401  (registers the plugins)

    mi.set_variant(name)
    return name


@pytest.fixture
def rgb():
    """Mitsuba in the variant llvm_ad_rgb."""
    import mitsuba as mi

    import urushi  # noqa: F401  (registers the plugins)

    mi.set_variant("llvm_ad_rgb")
    return mi


@pytest.fixture(scope="session")
def jit():
    """A module of Dr.Jit array types, `drjit.llvm` or `drjit.cuda`."""
    from urushi.walk.monte_carlo import backend

    return backend()


@pytest.fixture
def spectral(rgb):
    """Mitsuba in the variant llvm_ad_spectral, until the test ends."""
    rgb.set_variant("llvm_ad_spectral")
    yield rgb
    rgb.set_variant("llvm_ad_rgb")


@pytest.fixture
def few_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """Coats with textures by few points and nodes, for what does not depend on their numbers."""
    counts = {1: (5, 8, 12, 24, 48, 96), 2: (3, 6, 10, 20, 30, 40)}
    monkeypatch.setattr("urushi.textures.point_codes.POINTS", counts)
    monkeypatch.setattr("urushi.textures.baking.NODES", 1 << 10)


@pytest.fixture
def few_paths(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tables of slabs by few paths of straight light, for what does not depend on their number."""
    monkeypatch.setattr("urushi.material.slab_light.PATHS", 64)


@pytest.fixture(scope="session")
def pairs() -> tuple[np.ndarray, np.ndarray]:
    """2,003 pairs on the upper hemisphere: random, near the mirror direction, grazing, normal."""
    corners = [[[0, 0, 1], [1, 0, 0], [1, 0, 0]], [[0, 0, 1], [-1, 0, 0], [1, 0, 0]]]
    return tuple(np.concatenate([pairs_near_mirrors(2000), np.float32(corners)], axis=1))


@pytest.fixture(scope="session")
def directions() -> np.ndarray:
    """1,000 float32 unit vectors over the whole sphere; a tenth of them are grazing."""
    vectors = np.random.default_rng(43).normal(size=(1000, 3))
    vectors[::10, 2] *= 1e-3
    return np.float32(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


@pytest.fixture(scope="session")
def tool(stored):
    """The module that writes stand-ins for files of the MERL database."""
    path = stored("tools/merl_from_nbrdf.py")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
