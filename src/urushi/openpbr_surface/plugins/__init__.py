"""The Mitsuba plugins of the extension: `openpbr`, `openpbr_emission` and `materialx`."""

from urushi.mitsuba.register import PluginSet


def _load() -> dict:
    from urushi.openpbr_surface.plugins import emission
    from urushi.openpbr_surface.plugins.materialx import materialx
    from urushi.openpbr_surface.plugins.openpbr import openpbr

    return {"openpbr": openpbr, "materialx": materialx, "openpbr_emission": emission.define()}


PLUGINS = PluginSet(_load, bsdfs=("openpbr", "materialx"), emitters=("openpbr_emission",))
