"""`layered` by the bidirectional estimator: the means of `simulate` and of the default."""

import numpy as np
import pytest

from urushi.walk import coat, conductor, simulate

WALKS = 1 << 15
WI = np.array([0.5, 0.2, np.sqrt(0.71)])
WO = np.array([-0.3, 0.4, np.sqrt(0.75)])
R0 = np.array([0.9, 0.5, 0.2])
ALBEDO = (0.95, 0.6, 0.2)
#: sigma_t of the coat, by whether its channels share walks.
DEPTHS = {"shared": 2.0, "separate": (2.0, 1.0, 0.3)}


def color(values) -> dict:
    return {"type": "rgb", "value": list(values)}


def metal() -> dict:
    """A roughconductor of the reflectances R0, exactly: a conductor of the index 1."""
    # r0 = k^2 / (4 + k^2) of the complex index 1 + ik
    k = 2 * np.sqrt(R0 / (1 - R0))
    return {
        "type": "roughconductor",
        "distribution": "ggx",
        "alpha": 0.4,
        "eta": color([1.0] * 3),
        "k": color(k),
    }


def described(depth="shared", estimator="bidirectional", base=None, **extra) -> dict:
    """A coat of a medium that scatters forward."""
    sigma_t = DEPTHS[depth]
    return {
        "type": "layered",
        "alpha": 0.1,
        "int_ior": 1.5,
        "ext_ior": 1.0,
        "albedo": color(ALBEDO),
        "sigma_t": sigma_t if np.isscalar(sigma_t) else color(sigma_t),
        "g": 0.8,
        "estimator": estimator,
        "base": base or metal(),
        **extra,
    }


def values(mi, bsdf, walks: int = WALKS) -> np.ndarray:
    """f (channels, walks) of the pair WI, WO, by walks at different uv."""
    from urushi.mitsuba.reading import probing

    si = probing.interaction(
        np.tile(WI.astype(np.float32), (walks, 1)), np.random.default_rng(0).random((walks, 2))
    )
    value = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(*WO.tolist()))
    return value.numpy().astype(np.float64) / WO[2]


def mean(f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means and standard errors of the channels."""
    return f.mean(axis=-1), f.std(axis=-1) / np.sqrt(f.shape[-1])


def stacks():
    """By name: the plugin's dictionary, and the same stack."""
    bottom = conductor(eta=1.0, k=2 * np.sqrt(R0 / (1 - R0)), alpha=0.4)
    found = {
        depth: (
            described(depth),
            coat(bottom, 0.1, 1.5, albedo=ALBEDO, sigma_t=DEPTHS[depth], g=0.8),
        )
        for depth in DEPTHS
    }
    inner = {"alpha": 0.3, "int_ior": 1.3, "ext_ior": 1.0, "albedo": 0.9, "sigma_t": 0.5}
    nested = {"type": "layered", **inner, "base": metal()}
    two = coat(bottom, 0.3, 1.3, albedo=0.9, sigma_t=0.5)
    found["two coats"] = (
        described(base=nested),
        coat(two, 0.1, 1.5, albedo=ALBEDO, sigma_t=2.0, g=0.8),
    )
    widths = {"alpha_u": 0.1, "alpha_v": 0.4}
    found["anisotropic"] = (
        {name: v for name, v in described(**widths).items() if name != "alpha"},
        coat(bottom, eta=1.5, albedo=ALBEDO, sigma_t=2.0, g=0.8, **widths),
    )
    return found


@pytest.mark.parametrize("name", ["shared", "separate", "two coats", "anisotropic"])
def test_values_agree_with_the_simulation(rgb, name):
    description, stack = stacks()[name]
    f, se = mean(values(rgb, rgb.load_dict(description)))
    expected, expected_se = simulate(
        stack, WI[None], WO[None], walks=WALKS, progress=False, estimator="bidirectional"
    )
    assert (np.abs(f - expected[0]) < 4 * np.hypot(se, expected_se[0])).all()
    assert (se < 0.02 * f).all()  # the comparison is sharp


def test_channels_that_share_walks_have_the_values_of_walks_of_their_own(rgb):
    """Walks of one pair are the same but for roulette, which follows the brightest channel."""
    together = values(rgb, rgb.load_dict(described(sigma_t=2.0)))
    apart = values(rgb, rgb.load_dict(described(sigma_t=color([2.0] * 3))))
    (one, se_one), (other, se_other) = mean(together), mean(apart)
    assert (np.abs(one - other) < 4 * np.hypot(se_one, se_other)).all()
    # the first channel is the brightest
    np.testing.assert_allclose(one[0], other[0], rtol=1e-4)


def test_forward_scattering_has_less_noise(rgb):
    both, one = (
        values(rgb, rgb.load_dict(described(estimator=name))).var(axis=1)
        for name in ("bidirectional", "unidirectional")
    )
    assert (both < 0.5 * one).all()


def test_directions_and_their_density_are_those_of_the_default(rgb):
    from urushi.mitsuba.reading import probing

    found = []
    rng = np.random.default_rng(1)
    u = rng.random((3, 256), np.float32)
    for name in ("bidirectional", "unidirectional"):
        bsdf = rgb.load_dict(described(estimator=name))
        si = probing.interaction(np.tile(WI.astype(np.float32), (256, 1)), u[:2].T)
        bs, _ = bsdf.sample(rgb.BSDFContext(), si, rgb.Float(u[2]), rgb.Point2f(u[:2]))
        found.append((bs.wo.numpy(), bs.pdf.numpy(), bsdf.pdf(rgb.BSDFContext(), si, bs.wo)))
    for a, b in zip(*found, strict=True):
        np.testing.assert_array_equal(a, b)


def picture(mi, bsdf: dict) -> np.ndarray:
    """Independent pictures (12, 4, 3) of a sphere under a lamp, as means over its quarters."""
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 3, "hide_emitters": True},
            "sensor": {
                "type": "perspective",
                "fov": 20,
                "to_world": mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]),
                "film": {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}},
            },
            "sky": {"type": "constant", "radiance": 0.2},
            "lamp": {
                "type": "sphere",
                "center": [3, 2, 4],
                "radius": 1.5,
                "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [8, 6, 4]}},
            },
            "object": {"type": "sphere", "material": bsdf},
        }
    )
    pictures = [mi.render(scene, spp=128, seed=seed).numpy() for seed in range(12)]
    cut = np.reshape(pictures, (12, 2, 4, 2, 4, 3))
    return cut.mean(axis=(2, 4)).reshape(12, 4, 3)


@pytest.mark.parametrize("depth", DEPTHS)
def test_pictures_have_the_same_mean(rgb, depth):
    from scipy import stats

    both, one = (
        picture(rgb, described(depth, name)) for name in ("bidirectional", "unidirectional")
    )
    p = stats.ttest_ind(both, one, equal_var=False).pvalue
    assert p.min() > 1 - 0.99 ** (1 / p.size)  # 1 % for all blocks together (Šidák)
    whole = stats.ttest_ind(both.mean(axis=(1, 2)), one.mean(axis=(1, 2)), equal_var=False)
    assert whole.pvalue > 1e-3


@pytest.mark.parametrize("variant", ["llvm_ad_mono", "llvm_ad_spectral"])
@pytest.mark.parametrize("depth", DEPTHS)
def test_other_variants(variant, depth):
    import mitsuba as mi

    import urushi  # noqa: F401  (registers the plugins)

    if variant not in mi.variants():
        pytest.skip(f"Mitsuba has no variant {variant}")
    mi.set_variant(variant)
    both, one = (
        mean(values(mi, mi.load_dict(described(depth, name))))
        for name in ("bidirectional", "unidirectional")
    )
    assert (np.abs(both[0] - one[0]) < 4 * np.hypot(both[1], one[1])).all()
    assert (both[0] > 0).all()


def test_a_change_through_traverse(rgb):
    bsdf = rgb.load_dict(described())
    parameters = rgb.traverse(bsdf)
    parameters["sigma_t.value"] = 0.5
    parameters.update()
    np.testing.assert_array_equal(
        values(rgb, bsdf, 64), values(rgb, rgb.load_dict(described(sigma_t=0.5)), 64)
    )


def test_xml_is_the_dictionary(rgb):
    xml = """<bsdf type="layered" version="3.0.0">
        <string name="estimator" value="bidirectional"/>
        <float name="sigma_t" value="1"/><float name="albedo" value="0.9"/>
        <bsdf type="diffuse"/>
    </bsdf>"""
    inside = {"base": {"type": "diffuse"}, "sigma_t": 1.0, "albedo": 0.9}
    a = rgb.load_string(xml)
    b = rgb.load_dict({"type": "layered", "estimator": "bidirectional", **inside})
    assert "estimator = bidirectional" in str(a)
    assert str(a) == str(b)
    np.testing.assert_array_equal(values(rgb, a, 64), values(rgb, b, 64))


@pytest.mark.parametrize(
    ("value", "shown"), [("both", "'both'"), (2.0, "2.0"), (True, "True"), ("", "''")]
)
def test_an_unknown_estimator_is_refused(rgb, value, shown):
    with pytest.raises(RuntimeError) as caught:
        rgb.load_dict(described(estimator=value))
    sentence = f"layered: estimator is {shown}; it is 'unidirectional' or 'bidirectional'"
    assert sentence in str(caught.value)
