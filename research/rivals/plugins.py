"""The plugins `layered_belcour` and `layered_weidlich`, in every variant that is set."""

from research.rivals.layered_belcour import LayeredBelcour
from research.rivals.layered_weidlich import LayeredWeidlich
from urushi.mitsuba.register import PluginSet
from urushi.mitsuba.register import register as register_plugins


def register() -> None:
    """Register both plugins in the current variant, if any, and in all that are set later."""
    plugins = {"layered_belcour": LayeredBelcour, "layered_weidlich": LayeredWeidlich}
    register_plugins(PluginSet(lambda: plugins, (*plugins,)))
