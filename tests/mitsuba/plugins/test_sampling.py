"""The plugins' densities are normalised and agree with their samples, for many materials."""

import numpy as np
import pytest

import urushi
from urushi.checks import CoatParameters
from urushi.material import Material
from urushi.material.layer import layer_material
from urushi.nets import weights

MATERIALS = 6
#: Angles of wi from the normal [degrees].
ANGLES = (0, 20, 45, 70, 85, 89)


def check(sampling, bsdfs) -> None:
    """Chi-squared test and integral of every density, each for one of the angles."""
    for index, bsdf in enumerate(bsdfs):
        test = sampling.chi_squared(bsdf, ANGLES[index % len(ANGLES)], seed=index)
        assert test.run(0.01, test_count=len(bsdfs), quiet=True), (index, test.messages)
        # the error is the quadrature's: the lobe of width 0.01 spans only a few of its points
        assert test.pdf_sum[0] == pytest.approx(1, abs=0.005)
        assert test.histogram_sum[0] == 1  # no sample fails


def test_neural_brdf(rgb, sampling, networks, model, codes, tmp_path):
    bsdfs = []
    for index in range(MATERIALS):
        z = codes(index, 2)
        z[:, 0] = (0.01, 0.1, 0.6)[index % 3]  # from the narrowest lobe on
        path = tmp_path / f"{index}.safetensors"
        Material(z, model).save(path)
        bsdfs.append(
            rgb.load_dict({"type": "neural_brdf", "filename": str(path), "weights": str(networks)})
        )
    check(sampling, bsdfs)


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


def test_neural_layered(rgb, sampling, networks):
    extra = {"type": "neural_layered", "weights": str(networks)}
    check(sampling, [rgb.load_dict(coat | extra) for coat in coats(MATERIALS)])


def test_layered(rgb, sampling):
    check(sampling, [rgb.load_dict(coat | {"type": "layered"}) for coat in coats(MATERIALS)])


@pytest.mark.slow
def test_weights_of_samples_of_the_shipped_networks_are_bounded():
    """Of metals and Lambertians under random coats."""
    model, rng, count = weights.default_model(), np.random.default_rng(0), 32
    bottoms = [urushi.conductor(alpha=alpha, r0=0.9) for alpha in (0.02, 0.1, 0.4)]
    bottoms += [urushi.diffuse(0.7), urushi.diffuse(0.05)]
    codes = np.concatenate([urushi.encode(bottom).latents for bottom in bottoms])
    low, high = np.array([(0.01, 1), (1.05, 2.5), (0, 1), (0, 4), (-0.5, 0.8)]).T
    coats = CoatParameters.of_columns((low + (high - low) * rng.random((count, 5))).T)
    below = Material(codes[np.arange(count) % len(codes)], model)
    coated = layer_material(coats, below, fast=True).latents
    materials = [Material(z[None], model) for z in coated]
    theta = np.radians(np.repeat([0, 30, 60, 75, 85], 200))
    wi = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=-1).astype(np.float32)
    for seed, material in enumerate(materials):
        wo, pdf = material.sample(wi, np.random.default_rng(seed).random(wi.shape, np.float32))
        f_cos = material.f(wi, wo)[:, 0] * wo[:, 2]
        assert (f_cos <= 50 * pdf).all()


def test_nested_layered(rgb, sampling):
    nested = [
        rgb.load_dict(outer | {"type": "layered", "base": inner | {"type": "layered"}})
        for outer, inner in zip(coats(4), reversed(coats(4)), strict=True)
    ]
    check(sampling, nested)
