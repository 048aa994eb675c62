"""Images by sampling lights, by sampling the BSDF and by both have the same expectation."""

import numpy as np
import pytest

from urushi.material import Material

RUNS, SIZE, BLOCK = 12, 16, 4


def scene(mi, bsdf: dict, emitter_samples: int, bsdf_samples: int):
    """A sphere, facing its light on one side and lit at grazing angles on the other."""
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {
                "type": "direct",
                "emitter_samples": emitter_samples,
                "bsdf_samples": bsdf_samples,
                "hide_emitters": True,
            },
            "sensor": {
                "type": "perspective",
                "fov": 24,
                "to_world": mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]),
                "film": {
                    "type": "hdrfilm",
                    "width": SIZE,
                    "height": SIZE,
                    "rfilter": {"type": "box"},
                },
            },
            "light": {
                "type": "sphere",
                "center": [3, 2, 4],
                "radius": 1.5,
                "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [8, 6, 4]}},
            },
            "object": {"type": "sphere", "material": bsdf},
        }
    )


def blocks(mi, bsdf: dict, emitter_samples: int, bsdf_samples: int) -> np.ndarray:
    """Means over blocks of pixels, (RUNS, blocks)."""
    loaded = scene(mi, bsdf, emitter_samples, bsdf_samples)
    count = SIZE // BLOCK
    images = [mi.render(loaded, spp=256, seed=seed).numpy() for seed in range(RUNS)]
    cut = np.reshape(images, (RUNS, count, BLOCK, count, BLOCK, 3))
    return cut.mean(axis=(2, 4)).reshape(RUNS, -1)


def assert_same_mean(a: np.ndarray, b: np.ndarray) -> None:
    """Welch's t-test of every block, at 1 % for all of them together (Šidák)."""
    from scipy import stats

    lit = a.mean(axis=0) + b.mean(axis=0) > 1e-3
    p = stats.ttest_ind(a[:, lit], b[:, lit], equal_var=False).pvalue
    assert lit.sum() > 10
    assert p.min() > 1 - 0.99 ** (1 / lit.sum())
    # and over the whole image, where a small bias would add up
    assert stats.ttest_ind(a.mean(axis=1), b.mean(axis=1), equal_var=False).pvalue > 1e-3


@pytest.mark.parametrize("name", ("layered", "neural_layered", "neural_brdf"))
def test_lights_bsdf_and_both_agree(rgb, networks, model, codes, tmp_path, name):
    path = tmp_path / "material.safetensors"
    Material(codes(), model).save(path)
    coat = {
        "alpha": 0.15,
        "sigma_t": {"type": "rgb", "value": [0.2, 1.0, 2.0]},
        "albedo": 0.7,
        "g": 0.4,
        "base": {"type": "roughconductor", "distribution": "ggx", "alpha": 0.3},
    }
    bsdf = {
        "layered": {"type": name, **coat},
        "neural_layered": {"type": name, "weights": str(networks), **coat},
        "neural_brdf": {"type": name, "weights": str(networks), "filename": str(path)},
    }[name]
    lights, sampled, both = (blocks(rgb, bsdf, *samples) for samples in ((1, 0), (0, 1), (1, 1)))
    assert_same_mean(lights, sampled)
    assert_same_mean(lights, both)
