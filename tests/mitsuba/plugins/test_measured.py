"""The plugin `measured_brdf`: alone, and under the walk's and the networks' coats."""

import numpy as np
import pytest

import urushi

COAT = {"alpha": 0.2, "albedo": 0.8, "sigma_t": 0.7, "g": 0.3}


def pairs(count, seed):
    rng = np.random.default_rng(seed)
    z, phi = rng.uniform(0.1, 1, (2, count)), rng.uniform(0, 2 * np.pi, (2, count))
    r = np.sqrt(1 - z * z)
    wi, wo = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1).astype(np.float32)
    return wi, wo


def test_values_are_those_of_the_reader(rgb, merl_file):
    from urushi.mitsuba.reading import probing

    wi, wo = pairs(2000, 0)
    bsdf = rgb.load_dict({"type": "measured_brdf", "filename": str(merl_file)})
    f = probing.bsdf_values(bsdf, wi, wo, np.zeros((len(wi), 2)))
    np.testing.assert_allclose(f, urushi.load_measured(merl_file).f(wi, wo), rtol=1e-3)


def test_under_layered_values_agree_with_the_simulation(rgb, merl_file):
    from urushi.mitsuba.reading import probing

    walks, (wi, wo) = 4096, pairs(12, 1)
    bsdf = rgb.load_dict(
        {
            "type": "layered",
            "int_ior": 1.5,
            "ext_ior": 1.0,
            **COAT,
            "base": {"type": "measured_brdf", "filename": str(merl_file)},
        }
    )
    # The walks' seeds are hashes that include the position; the BSDF does not depend on it.
    uv = np.random.default_rng(3).random((len(wi) * walks, 2))
    every = probing.bsdf_values(bsdf, np.repeat(wi, walks, 0), np.repeat(wo, walks, 0), uv)
    every = every.reshape(len(wi), walks, 3)
    stack = urushi.coat(urushi.load_measured(merl_file), eta=1.5, **COAT)
    f, se = urushi.simulate(stack, wi, wo, walks=walks, progress=False)
    z = (every.mean(1) - f) / np.hypot(se, every.std(1) / walks**0.5)
    assert np.abs(z).max() < 4.5  # of 36
    assert np.mean(z**2) < 2


def test_errors_name_mistakes(rgb, tmp_path):
    with pytest.raises(RuntimeError, match="measured_brdf has no filename; give a MERL or RGL"):
        rgb.load_dict({"type": "measured_brdf"})
    with pytest.raises(RuntimeError, match="there is no file"):
        rgb.load_dict({"type": "measured_brdf", "filename": str(tmp_path / "none.binary")})
