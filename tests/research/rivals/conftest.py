"""The rivals' plugins, registered."""

import pytest


@pytest.fixture(scope="session", autouse=True)
def rivals_plugins():
    """Register `layered_belcour` and `layered_weidlich`."""
    from research.rivals import plugins

    plugins.register()
