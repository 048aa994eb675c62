"""Random materials and those at the ends of their ranges: densities, samples and albedos."""

import numpy as np
import pytest
from tests.directions import in_plane
from tests.mitsuba import sampling
from tests.mitsuba.probes import sampled

#: Angles of wi from the normal [degrees], one for each material.
ANGLES = (0, 20, 45, 70, 85, 89)

#: Materials at the ends of the parameters' ranges: the coat, and its bottom's width.
EXTREME = {
    "smooth on smooth": ({"alpha": 0.01}, 0.01),
    "white and thick": ({"alpha": 0.3, "albedo": 1.0, "sigma_t": 8.0}, 0.1),
    "black and thick": ({"alpha": 0.01, "albedo": 0.0, "sigma_t": 8.0}, 0.1),
    "rough on smooth": ({"alpha": 1.0, "g": 0.9, "sigma_t": 1.0, "albedo": 1.0}, 0.01),
}


def coats(count: int) -> list[dict]:
    """Coats over the range of every parameter, over bottoms of several kinds."""
    rng = np.random.default_rng(1)
    bottoms = (
        {"type": "roughconductor", "distribution": "ggx", "alpha": 0.02},
        {"type": "diffuse"},
        {"type": "principled", "metallic": 0.5, "roughness": 0.3},
    )
    return [
        {
            "alpha": 0.01 if index % 4 == 0 else float(np.exp(rng.uniform(np.log(0.01), 0))),
            "int_ior": float(rng.uniform(1.05, 2.5)),
            "ext_ior": 1.0,
            "albedo": float(rng.uniform()),
            "sigma_t": float(rng.exponential()),
            "g": float(rng.uniform(-0.7, 0.7)),
            "base": bottoms[index % len(bottoms)],
        }
        for index in range(count)
    ]


@pytest.mark.parametrize("kind", ["neural_layered", "layered", "nested"])
def test_samples_follow_the_density(rgb, networks, kind):
    weights = {"weights": str(networks)} if kind == "neural_layered" else {}
    plugin = {"type": "layered" if kind == "nested" else kind} | weights
    described = [coat | plugin for coat in coats(len(ANGLES))]
    if kind == "nested":
        described = [a | {"base": b} for a, b in zip(described, reversed(described), strict=True)]
    for degrees, material in zip(ANGLES, described, strict=True):
        sampling.check(rgb.load_dict(material), [degrees], len(ANGLES))


@pytest.mark.parametrize("name", EXTREME)
@pytest.mark.parametrize("degrees", (0, 60, 85, 89))
def test_extreme_materials_reflect_their_albedo(rgb, name, degrees):
    (coat, alpha), wi, count = EXTREME[name], in_plane([degrees]), 1 << 16
    bottom = {"type": "roughconductor", "distribution": "ggx", "alpha": alpha}
    bsdf = rgb.load_dict({"type": "neural_layered", **coat, "base": bottom})
    weight = sampled(bsdf, wi, count, mode="Radiance")[0][0, :, 0]
    assert np.isfinite(weight).all() and (weight >= 0).all()
    assert weight.max() < 100  # 67 at 85 degrees, smooth on smooth
    expected = bsdf.latents.material.directional_albedo(wi)[0, 0]
    # the quadrature of the albedo has an error of a few parts in a thousand
    error = 5 * weight.std() / np.sqrt(count) + 5e-3 * expected
    assert weight.mean() == pytest.approx(expected, abs=error)
