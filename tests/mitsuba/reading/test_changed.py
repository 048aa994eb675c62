"""BSDFs of Mitsuba's that are made again, with other textures."""

import numpy as np
import pytest
from tests.mitsuba.probes import f

from urushi.core.probe_pairs import probe_pairs

WI, WO = probe_pairs(192)
PLASTIC = {"type": "roughplastic", "alpha": 0.3, "diffuse_reflectance": 0.8}
NONLINEAR = PLASTIC | {"nonlinear": True, "int_ior": 1.7, "ext_ior": 1.2}

GIVEN = {
    "both plastics": {"type": "blendbsdf", "weight": 0.4, "a": PLASTIC, "b": NONLINEAR},
    "specular": {"type": "principled", "specular": 0.9},
    "eta": {"type": "principled", "eta": 1.8, "clearcoat": 0.5},
    "pplastic": {"type": "pplastic", "int_ior": 1.3, "alpha_u": 0.3, "alpha_v": 0.2},
}


@pytest.mark.parametrize("name", GIVEN)
def test_a_bsdf_of_the_same_textures_reflects_the_same(rgb, name):
    from urushi.mitsuba.reading.changed import replaced

    bsdf = rgb.load_dict(GIVEN[name])
    np.testing.assert_array_equal(f(replaced(bsdf, lambda x: x), WI, WO), f(bsdf, WI, WO))
