"""Albedos of coats over texels of a mask, and between texels, against the walk.

All are at a cosine of 0.8 and any azimuth, because one of four texels is drawn by a hash of wi.
"""

import numpy as np
import pytest

SILVER = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2, "material": "Ag"}
RUST = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.3, 0.1, 0.05]}}
COUNT = 1 << 15


def texels(mi, *values: float, **options) -> dict:
    """A row of texels."""
    data = np.array(values, np.float32).reshape(1, -1, 1)
    return {
        "type": "bitmap",
        "bitmap": mi.Bitmap(data),
        "raw": True,
        "wrap_mode": "clamp",
    } | options


def albedo(mi, description: dict, u: float) -> np.ndarray:
    """Albedo of each channel at the coordinate u of a row, by the plugin's own samples."""
    from urushi.mitsuba.reading import probing

    rng = np.random.default_rng(0)
    phi = rng.uniform(0, 2 * np.pi, COUNT)
    wi = np.stack([0.6 * np.cos(phi), 0.6 * np.sin(phi), np.full(COUNT, 0.8)], axis=-1)
    si = probing.interaction(wi, np.tile([u, 0.5], (COUNT, 1)))
    numbers = mi.Float(rng.random(COUNT)), mi.Point2f(np.float32(rng.random((2, COUNT))))
    return mi.load_dict(description).sample(mi.BSDFContext(), si, *numbers)[1].numpy().mean(axis=1)


@pytest.mark.parametrize("alpha", [0.1, 0.6])
@pytest.mark.parametrize("weight", [0.0, 0.05, 1.0])
def test_masks_of_metal_and_rust(rgb, alpha, weight):
    """Within 2 %: codes of coated metals and Lambertians err by one, noise is below one."""
    blend = {"type": "blendbsdf", "metal": SILVER, "rust": RUST}
    mask = texels(rgb, 0.0, 0.05, 1.0, filter_type="nearest")
    coat = {"alpha": alpha, "int_ior": 1.5}
    found = albedo(
        rgb,
        {"type": "neural_layered", "base": blend | {"weight": mask}} | coat,
        (0.5 + [0.0, 0.05, 1.0].index(weight)) / 3,
    )
    walk = albedo(rgb, {"type": "layered", "base": blend | {"weight": weight}} | coat, 0.5)
    np.testing.assert_allclose(found, walk, rtol=0.02)


@pytest.mark.parametrize("name", ["reflectance", "sigma_t", "albedo"])
def test_half_way_between_two_texels(rgb, name):
    """Within 5 %; the walk has the mean parameter there."""
    data = {"reflectance": (0.05, 0.9), "sigma_t": (0.0, 5.0), "albedo": (0.1, 0.98)}[name]
    row = texels(rgb, *data)
    coat = {"alpha": 0.1, "int_ior": 1.5, "base": SILVER} | {
        "reflectance": {"base": {"type": "diffuse", "reflectance": row}},
        "sigma_t": {"sigma_t": row},
        "albedo": {"albedo": row, "sigma_t": 2.0, "base": RUST},
    }[name]
    found, walk = (albedo(rgb, coat | {"type": x}, 0.5) for x in ("neural_layered", "layered"))
    np.testing.assert_allclose(found, walk, rtol=0.05)
