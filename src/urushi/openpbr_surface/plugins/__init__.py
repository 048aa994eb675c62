"""The Mitsuba plugins of the extension: `openpbr`, `openpbr_emission` and `materialx`."""

from urushi.mitsuba.register import PluginSet


def _load() -> dict:
    from urushi.mitsuba.surface import Surface
    from urushi.openpbr_surface.plugins import emission, materialx, openpbr

    return {
        "openpbr": openpbr.define(Surface),
        "materialx": materialx.define(),
        "openpbr_emission": emission.define(),
    }


PLUGINS = PluginSet(_load, bsdfs=("openpbr", "materialx"), emitters=("openpbr_emission",))
