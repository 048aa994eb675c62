"""The Dr.Jit backend that the tests of this floor run on."""

from types import ModuleType

import pytest

from urushi.walk.monte_carlo import backend


@pytest.fixture(scope="session")
def jit() -> ModuleType:
    """A module of Dr.Jit array types, `drjit.llvm` or `drjit.cuda`."""
    return backend()
