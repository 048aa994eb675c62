"""Derivatives of the plugins: equal values, slopes of the walk, and finite everywhere."""

import drjit as dr
import numpy as np
import pytest
from benchmarks.quality.gradients import SLOPES, coated, slopes, spread

#: Cases of the first tier and of the second; the others are for the third, at the ends of ranges.
FIRST = ("black diffuse", "white diffuse", "rough gold")
SECOND = ("openpbr", "absent coat", "white medium", "no medium")
RARE = {name: pytest.mark.slow if name in SECOND else pytest.mark.research for name in SLOPES}


@pytest.mark.parametrize(
    "case", [pytest.param(name, marks=() if name in FIRST else RARE[name]) for name in SLOPES]
)
def test_slopes_are_those_of_the_walk(rgb, case):
    """With the same bits of f as without gradients."""
    found = slopes(case)
    tolerance = SLOPES[case][-1] * found.size
    assert found.derivative == pytest.approx(found.walk, abs=tolerance)


TEXTURED = {"type": "checkerboard", "color0": 0.2, "color1": 0.8}
METAL = {"type": "roughconductor", "distribution": "ggx"}
PLUGINS = {
    "constant": coated({"type": "diffuse"}, sigma_t=0.3, albedo=0.5),
    "textured": coated({"type": "diffuse"}, sigma_t=0.3, albedo=TEXTURED),
    "total reflection": coated(METAL, int_ior=1.0, ext_ior=1.5),
    "anisotropic": {
        "type": "neural_layered",
        "alpha_u": 0.1,
        "alpha_v": 0.3,
        "bottom": {"type": "diffuse"},
    },
    "openpbr": {
        "type": "openpbr",
        "base_metalness": 0.5,
        "specular_roughness_anisotropy": 0.5,
        "base_diffuse_roughness": 0.5,
    },
}


def special_pairs() -> tuple[np.ndarray, np.ndarray]:
    """Pairs at which arguments of roots, logarithms or divisions become zero."""
    a, b = spread(200, 3), spread(200, 4)
    normal, low = np.tile([0.0, 0.0, 1.0], (200, 1)), a * [1, 1, 1e-4]
    low /= np.linalg.norm(low, axis=-1, keepdims=True)
    mirror = np.array([-1.0, -1.0, 1.0])
    pairs = [
        (a, b), (normal, b), (a, normal), (normal, normal), (a, a), (a, a * mirror), (low, b),
        (low, low), (low, low * mirror),
    ]  # fmt: skip
    return tuple(np.concatenate(side) for side in zip(*pairs, strict=True))


@pytest.mark.parametrize("name", PLUGINS)
def test_derivatives_by_directions_are_finite(rgb, name):
    from urushi.mitsuba.reading import probing

    wi, wo = (side.astype(np.float32) for side in special_pairs())
    bsdf = rgb.load_dict(PLUGINS[name])
    si = probing.interaction(wi, np.full((len(wi), 2), 0.3))
    ends = rgb.Vector3f(si.wi), rgb.Vector3f(np.ascontiguousarray(wo.T))
    dr.enable_grad(*ends)
    si.wi = ends[0]
    f, pdf = bsdf.eval_pdf(rgb.BSDFContext(), si, ends[1])
    dr.backward(dr.sum(f.x + f.y + f.z + pdf))
    for end in ends:
        assert np.isfinite(dr.grad(end).numpy()).all()
