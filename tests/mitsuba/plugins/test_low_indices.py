"""Coats of the index of the medium above them, or of a lower one: values and textures."""

import numpy as np
import pytest
from tests.mitsuba.probes import vector

from urushi.mitsuba.reading import probing
from urushi.walk import coat, diffuse, simulate

COAT = {"alpha": 0.2, "albedo": 0.7, "sigma_t": 0.8, "g": 0.3}


def layered(int_ior, ext_ior: float, base: dict | None = None, **extra) -> dict:
    """A coat over a bottom, by default a diffuse one."""
    bottom = base or {"type": "diffuse", "reflectance": 0.6}
    inside = {"int_ior": int_ior, "ext_ior": ext_ior}
    return {"type": "layered", **COAT, **inside, "base": bottom, **extra}


def mean_f_cos(mi, bsdf, wi: np.ndarray, wo: np.ndarray, walks: int = 1 << 16):
    """f cos and its standard error from walks at different uv."""
    a, b = (np.tile(w.astype(np.float32), (walks, 1)) for w in (wi, wo))
    si = probing.interaction(a, np.random.default_rng(0).random((walks, 2)))
    value = bsdf.eval(mi.BSDFContext(), si, vector(b))
    green = value[1].numpy().astype(np.float64)
    return green.mean(), green.std() / np.sqrt(walks)


@pytest.mark.parametrize("degrees", (10, 40, 75))
def test_the_plugin_is_the_walk(rgb, degrees):
    # 75 degrees are beyond the critical angle of 0.8, which is 53.
    theta = np.radians(degrees)
    wi = np.array([np.sin(theta), 0, np.cos(theta)])
    wo = np.array([0.0, 0.3, np.sqrt(0.91)])
    below = coat(diffuse(0.6), eta=1.2 / 1.5, **COAT)
    cases = (
        (layered(1.2, 1.5), below),
        (layered(1.5, 1.0, layered(1.2, 1.5)), coat(below, eta=1.5, **COAT)),
    )
    for described, stack in cases:
        f_cos, se = mean_f_cos(rgb, rgb.load_dict(described), wi, wo)
        f, se_f = simulate(stack, wi[None], wo[None], walks=1 << 17, progress=False)
        assert abs(f_cos - f[0, 0] * wo[2]) < 4 * np.hypot(se, se_f[0, 0] * wo[2])
        assert se < 0.02 * f_cos  # the comparison is sharp
