"""Parameters of one texture lie along one axis, if one is a function of the other."""

import drjit as dr
import numpy as np
import pytest
from tests.mitsuba.probes import bitmap

COUNT = 1 << 18


def texture(mi, channels: int, seed: int = 0):
    data = np.random.default_rng(seed).uniform(0.1, 0.9, (8, 8, channels)).astype(np.float32)
    return mi.load_dict(bitmap(data))


def coats(mi) -> dict[str, tuple[dict, set[str]]]:
    """Coats, and the names of their axes."""
    shared, other = texture(mi, 1), texture(mi, 1, seed=1)
    metal = {"type": "roughconductor", "distribution": "ggx", "material": "Au"}
    return {
        "a pigment's colour": (
            {"body": 0.6, "body_color": texture(mi, 3), "base": metal | {"alpha": 0.2}},
            {"albedo"},
        ),
        "two roughnesses": ({"alpha": shared, "base": metal | {"alpha": shared}}, {"alpha"}),
        "two textures": (
            {"alpha": shared, "base": metal | {"alpha": other}},
            {"alpha", "bottom.alpha"},
        ),
    }


@pytest.mark.parametrize("name", ["a pigment's colour", "two roughnesses", "two textures"])
def test_axes_and_albedos(rgb, name):
    """Albedos as of the walk within 1 %, of which its noise is a half."""
    described, expected = coats(rgb)[name]
    described = {"alpha": 0.1, "int_ior": 1.5} | described
    rng = np.random.default_rng(0)
    si = dr.zeros(rgb.SurfaceInteraction3f, COUNT)
    si.uv = rgb.Point2f(*np.float32(rng.random((2, COUNT))))
    si.wi = rgb.Vector3f(0.6, 0, 0.8)
    numbers = (
        rgb.Float(np.float32(rng.random(COUNT))),
        rgb.Point2f(*np.float32(rng.random((2, COUNT)))),
    )
    found = []
    for plugin in ("neural_layered", "layered"):
        bsdf = rgb.load_dict(described | {"type": plugin})
        found.append(bsdf.sample(rgb.BSDFContext(), si, *numbers)[1].numpy().mean(axis=1))
        if plugin == "neural_layered":
            assert {axis.name for axis in bsdf.latents.baked.axes} == expected
    np.testing.assert_allclose(*found, rtol=0.01)


def test_an_edit_of_texels_keeps_the_codes_unless_the_relation_changes(rgb):
    colour = texture(rgb, 3)
    described = {"type": "neural_layered", "body": 0.6, "body_color": colour}
    bsdf = rgb.load_dict(described | {"base": {"type": "diffuse"}})
    parameters, baked = rgb.traverse(bsdf), bsdf.latents.baked
    texels = np.array(parameters["body_color.data"])
    parameters["body_color.data"] = rgb.TensorXf(texels[::-1, ::-1].copy())
    parameters.update()
    assert bsdf.latents.baked is baked
    parameters["body.value"] = 0.4  # of the same colours, other depths
    parameters.update()
    assert bsdf.latents.baked is not baked
