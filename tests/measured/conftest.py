"""Fixtures that load the writers of test files."""

import importlib.util
from pathlib import Path

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
