"""Pictures have no bias: strategies agree, and extreme materials reflect their albedo."""

import drjit as dr
import numpy as np
import pytest

#: Materials at the ends of the parameters' ranges.
EXTREME = {
    "smooth on smooth": {"alpha": 0.01, "alpha_bottom": 0.01},
    "white and thick": {"alpha": 0.3, "albedo": 1.0, "sigma_t": 8.0},
    "black and thick": {"alpha": 0.01, "albedo": 0.0, "sigma_t": 8.0},
    "rough on smooth": {
        "alpha": 1.0,
        "alpha_bottom": 0.01,
        "g": 0.9,
        "sigma_t": 1.0,
        "albedo": 1.0,
    },
}


def described(alpha_bottom: float = 0.1, **coat) -> dict:
    return {
        "type": "neural_layered",
        "base": {"type": "roughconductor", "distribution": "ggx", "alpha": alpha_bottom},
        **coat,
    }


def scene(mi, bsdf, integrator: dict, side: int = 12):
    """A sphere under a sky with a bright spot."""
    sky = np.full((16, 32, 3), 0.2, np.float32)
    sky[3:6, 6:10] = 8
    look = mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0])
    film = {"type": "hdrfilm", "width": side, "height": side, "rfilter": {"type": "box"}}
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": integrator,
            "sensor": {"type": "perspective", "fov": 24, "to_world": look, "film": film},
            "light": {"type": "envmap", "bitmap": mi.Bitmap(sky)},
            "sphere": {"type": "sphere", "bsdf": bsdf},
        }
    )


def renders(mi, loaded, spp: int, seeds: range) -> np.ndarray:
    """Independent pictures (N, H, W, 3)."""
    return np.stack([mi.render(loaded, spp=spp, seed=seed).numpy() for seed in seeds])


def agree(a: np.ndarray, b: np.ndarray) -> None:
    """Z-test of the means of independent pictures (N, H, W, 3), pixel by pixel and as a whole."""
    error = np.sqrt(a.var(axis=0, ddof=1) / len(a) + b.var(axis=0, ddof=1) / len(b))
    z = (a.mean(axis=0) - b.mean(axis=0)) / np.maximum(error, 1e-6)
    # 432 values, Student's t of about 22 degrees of freedom: |z| > 6 in two of 10^5 tables
    assert np.abs(z).max() < 6
    total = [pictures.mean(axis=(1, 2)) for pictures in (a, b)]  # (N, 3)
    spread = np.sqrt(sum(t.var(axis=0, ddof=1) / len(t) for t in total))
    assert (np.abs(total[0].mean(axis=0) - total[1].mean(axis=0)) < 5 * spread).all()


@pytest.mark.parametrize("plugin", ["layered", "neural_layered"])
def test_light_bsdf_and_combined_sampling_give_the_same_picture(rgb, plugin):
    coat = described(alpha=0.15, albedo=0.7, sigma_t=0.5) | {"type": plugin}
    bsdf = rgb.load_dict(coat)
    pictures = []
    for light, bsdf_samples in ((1, 0), (0, 1), (1, 1)):
        integrator = {"type": "direct", "emitter_samples": light, "bsdf_samples": bsdf_samples}
        pictures.append(renders(rgb, scene(rgb, bsdf, integrator), 128, range(12)))
    agree(pictures[0], pictures[2])
    agree(pictures[1], pictures[2])


@pytest.mark.parametrize("name", EXTREME)
@pytest.mark.parametrize("degrees", (0, 60, 85, 89))
def test_extreme_materials_reflect_their_albedo(rgb, name, degrees):
    bsdf, count = rgb.load_dict(described(**EXTREME[name])), 1 << 16
    wi = np.array([[np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))]], np.float32)
    si = dr.zeros(rgb.SurfaceInteraction3f, count)
    si.wi = rgb.Vector3f(*wi[0].tolist())
    dr.make_opaque(si.wi)  # one kernel for all directions
    sampler = rgb.load_dict({"type": "independent"})
    sampler.seed(3, count)
    _, weight = bsdf.sample(rgb.BSDFContext(), si, sampler.next_1d(), sampler.next_2d())
    weight = weight.numpy()[0]
    assert np.isfinite(weight).all()
    assert (weight >= 0).all()
    assert weight.max() < 100  # 67 at 85 degrees, smooth on smooth
    expected = bsdf.latents.material.directional_albedo(wi)[0, 0]
    # the quadrature of the albedo has an error of a few parts in a thousand
    assert weight.mean() == pytest.approx(
        expected, abs=5 * weight.std() / np.sqrt(count) + 5e-3 * expected
    )
