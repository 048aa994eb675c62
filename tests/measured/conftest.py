"""Writers of test files, and directions."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest


def _load_module(path: Path):
    """Import a Python file that is not part of a package."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def load_module():
    return _load_module


@pytest.fixture(scope="session")
def writers():
    return _load_module(Path(__file__).with_name("writers.py"))


@pytest.fixture(scope="session")
def random_directions():
    """A function (count, seed) -> float32 (count, 3), uniform over the upper hemisphere."""

    def draw(count, seed, least_cosine=0.0):
        rng = np.random.default_rng(seed)
        z = rng.uniform(least_cosine, 1, count)
        phi = rng.uniform(0, 2 * np.pi, count)
        r = np.sqrt(1 - z * z)
        return np.stack([r * np.cos(phi), r * np.sin(phi), z], 1).astype(np.float32)

    return draw


@pytest.fixture(scope="session")
def tool(test_data):
    """The tool that writes stand-ins for the database's files, as a module."""
    path = test_data / "tools" / "merl_from_nbrdf.py"
    if not path.is_file():
        pytest.skip(f"'{path}' is missing")
    return _load_module(path)
