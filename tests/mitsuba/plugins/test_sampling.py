"""The plugins' densities are normalised and agree with their samples, for many materials."""

import numpy as np
import pytest

from urushi.material import Material

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


def test_nested_layered(rgb, sampling):
    nested = [
        rgb.load_dict(outer | {"type": "layered", "base": inner | {"type": "layered"}})
        for outer, inner in zip(coats(4), reversed(coats(4)), strict=True)
    ]
    check(sampling, nested)
