"""An extension's plugin: a class of `Surface`, and Mitsuba's BSDF that holds it."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from urushi.core.mixture import Mixture
from urushi.errors import ParameterError
from urushi.mitsuba.reading import probing
from urushi.mitsuba.register import PluginSet, register
from urushi.mitsuba.surface import Surface, bsdf_of, surface_of


class Grey(Surface):
    """A Lambertian surface of one reflectance."""

    PROPERTIES = ("reflectance",)

    def _load(self, props):
        self.reflectance = mi.Float(props.get("reflectance", 0.5))

    def _f(self, vertex, ctx, si, wo, active):
        return mi.Spectrum(self.reflectance * dr.inv_pi)

    def _proposal(self, vertex, si, active):
        return Mixture([0.0, 1.0], [1.0])

    def traverse(self, callback):
        callback.put("reflectance", self.reflectance, mi.ParamFlags.Differentiable)

    def _update(self, keys):
        if dr.any(self.reflectance > 1):
            raise ParameterError(f"{self._where}: reflectance is above 1")


@pytest.fixture
def grey(rgb):
    register(PluginSet(lambda: {"grey": Grey}, ("grey",)))
    return rgb.load_dict({"type": "grey", "reflectance": 0.4})


def test_a_surface_is_evaluated_as_a_bsdf(rgb, grey):
    """Alone and within a BSDF of Mitsuba's, as `diffuse`."""
    wi, wo = (np.float32([w, w]) for w in ([0.6, 0, 0.8], [0, 0.8, 0.6]))
    uv, diffuse = np.full((2, 2), 0.5), {"type": "diffuse", "reflectance": 0.4}
    expected = probing.bsdf_values(rgb.load_dict(diffuse), wi, wo, uv)
    for bsdf in (grey, rgb.load_dict({"type": "twosided", "side": grey}), surface_of(grey)):
        np.testing.assert_allclose(probing.bsdf_values(bsdf, wi, wo, uv), expected, 1e-6)
    assert grey.class_name() == str(grey)[:-2] == "Grey"
    assert surface_of(bsdf_of(surface_of(grey))) is surface_of(grey)
    assert surface_of(rgb.load_dict(diffuse)) is None


def test_updates_reach_the_surface_or_are_refused(grey):
    parameters = mi.traverse(grey)
    parameters["reflectance"] = 0.7
    parameters.update()
    assert grey.reflectance == 0.7  # what Mitsuba does not ask for is the surface's own
    parameters["reflectance"] = 1.5
    with pytest.raises(ParameterError, match="above 1"):
        parameters.update()
    assert grey.reflectance == 0.7
