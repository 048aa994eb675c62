"""Bases under coats without walks: of two widths, and coated ones below another coat."""

import numpy as np
import pytest
from tests.openpbr_surface.probes import loaded, sampled, toward, values

from urushi.mitsuba.reading import probing
from urushi.nets import lobe as lobes

pytestmark = pytest.mark.usefixtures("rgb")


@pytest.mark.slow
def test_a_grey_base_of_two_widths_under_a_smooth_coat_is_as_bright_as_walks():
    """Its albedo within 2.5 %, of which 0.5 % is the noise of walks."""
    material = {
        "base_color": (0.5, 0.5, 0.5),
        "specular_roughness": 0.5,
        "specular_roughness_anisotropy": 0.7,
        "coat_weight": 1.0,
        "energy_compensation": False,
    }
    wi = np.array([toward(cosine, 30.0) for cosine in (0.95, 0.7, 0.4)])
    found, expected = (
        sampled(loaded(**material, reference=walks), wi, 1 << 13)[0][..., 0].mean(1)
        for walks in (False, True)
    )
    np.testing.assert_allclose(found, expected, rtol=0.025)


def test_a_smooth_coat_tells_the_coat_above_it_its_lobe():
    """Over black, f in the mirrored direction is the lobe, up to single precision."""
    black = {"base_weight": 0.0, "specular_weight": 0.0}
    bsdf, wi = loaded(**black, coat_weight=1.0, coat_ior=0.69), np.array([toward(0.9)])
    wo = wi * [-1.0, -1.0, 1.0]
    lobe = probing.known_lobes(bsdf, np.array([[0.5, 0.5]]))[0]
    np.testing.assert_allclose(values(bsdf, wi, wo)[0], lobes.f(lobe, wi, wo), rtol=1e-5)
