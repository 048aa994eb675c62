"""The writers of test files."""

import pytest
from tests.measured import writers as module


@pytest.fixture(scope="session")
def writers():
    return module
