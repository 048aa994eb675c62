"""Fixtures that every floor's tests share."""

import os
import subprocess
import sys
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="session")
def test_data() -> Path:
    """The folder of test data that is not part of the repository; skips where there is none."""
    folder = Path(os.environ.get("URUSHI_TEST_DATA", ROOT.parent / "shared"))
    if not folder.is_dir():
        pytest.skip(f"no test data in '{folder}'; set URUSHI_TEST_DATA to the folder that has them")
    return folder


@pytest.fixture(scope="session")
def oracle(test_data: Path) -> Mapping[str, np.ndarray]:
    """Reference values of an independent simulator, by name (see its README)."""
    path = test_data / "oracle" / "reference_values.npz"
    if not path.is_file():
        pytest.skip(f"'{path}' is missing")
    with np.load(path) as archive:
        return dict(archive)


@cache
def has_cuda() -> bool:
    """Whether a CUDA kernel runs here (asked in another process: a driver may abort this one)."""
    probe = "import drjit.cuda as c; assert (c.Float([1, 2]) + 1)[1] == 3"
    run = subprocess.run([sys.executable, "-c", probe], capture_output=True, timeout=120)
    return run.returncode == 0


@pytest.fixture(params=["llvm_ad_rgb", "cuda_ad_rgb"])
def variant(request: pytest.FixtureRequest) -> str:
    """Run the test once in each Mitsuba variant that this machine can run."""
    name = request.param
    if name.startswith("cuda") and not has_cuda():
        pytest.skip("no NVIDIA GPU that Dr.Jit can use")
    import mitsuba as mi

    import urushi  # noqa: F401  (registers the plugins)

    mi.set_variant(name)
    return name
