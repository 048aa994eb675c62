"""`layered` with two widths: the walk's values, densities, and the frame that all layers share."""

import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, check_walk, vector

from urushi.mitsuba.reading import probing
from urushi.walk import coat, conductor, diffuse

COAT = {"int_ior": 1.5, "ext_ior": 1.0, "albedo": 0.7, "sigma_t": 0.5, "g": 0.3}
MEDIUM = {"eta": 1.5, "albedo": 0.7, "sigma_t": 0.5, "g": 0.3}
BRUSHED = {"type": "roughconductor", "distribution": "ggx", "alpha_u": 0.1, "alpha_v": 0.4}
WIDTHS = {"alpha_u": 0.5, "alpha_v": 0.1}
WI = np.array([0.5, 0.2, np.sqrt(0.71)])
WO = np.array([-0.3, 0.4, np.sqrt(0.75)])


def spectrum(value: float) -> dict:
    return {"type": "rgb", "value": [value] * 3}


def metal(eta: float = 0.2, k: float = 3.9) -> dict:
    """A roughconductor of two widths."""
    return BRUSHED | {"eta": spectrum(eta), "k": spectrum(k)}


def layered(mi, base: dict | None = None, **parameters):
    """A coat over a bottom, by default a diffuse one."""
    bottom = base or {"type": "diffuse", "reflectance": 0.6}
    return mi.load_dict({"type": "layered", **COAT, "base": bottom, **parameters})


def values(mi, bsdf, wi: np.ndarray = WI, wo: np.ndarray = WO, walks: int = 1) -> np.ndarray:
    """f cos (walks,) of the green channel, by walks at different uv."""
    a, b = (np.tile(w.astype(np.float32), (walks, 1)) for w in (wi, wo))
    si = probing.interaction(a, np.random.default_rng(0).random((walks, 2)))
    value = bsdf.eval(mi.BSDFContext(), si, vector(b))
    return value[1].numpy().astype(np.float64)


def test_the_plugin_is_the_walk(rgb):
    degrees = 30
    turn = {"rotation": float(degrees)}
    bottom = conductor(eta=0.2, k=3.9, alpha_u=0.1, alpha_v=0.4)
    one = coat(diffuse(0.6), **MEDIUM, **WIDTHS)
    check_walk(layered(rgb, **WIDTHS, **turn), one, degrees)
    both = coat(bottom, **MEDIUM, **WIDTHS)
    check_walk(layered(rgb, metal(), **WIDTHS, **turn), both, degrees)
    three = coat(coat(bottom, 0.3, 1.2), alpha_u=0.2, alpha_v=0.5, **MEDIUM)
    inner = {"type": "layered", "alpha": 0.3, "int_ior": 1.8, "base": metal()}
    check_walk(layered(rgb, inner, alpha_u=0.2, alpha_v=0.5, **turn), three, degrees)


def test_the_proposal_follows_an_anisotropic_bottom(rgb):
    from urushi.mitsuba.plugins.bottom_lobes import BottomLobes

    for widths in ((0.1, 0.04), (0.02, 0.08)):
        two = {"alpha_u": widths[0], "alpha_v": widths[1]}
        lobes = BottomLobes(rgb.load_dict(metal() | two))
        # A reflector of one GGX lobe gives its widths twice. The quantiles of 16384 samples have
        # errors of 1.5 %, and the horizon cuts 1 % of the samples off, more of wider lobes.
        for alpha in lobes.alphas:
            found = alpha.u.numpy()[0], alpha.v.numpy()[0]
            np.testing.assert_allclose(found, widths, rtol=0.08)
    isotropic = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2}
    for alpha in BottomLobes(rgb.load_dict(isotropic)).alphas:
        assert alpha.numpy()[0] == pytest.approx(0.2, rel=0.1)


def test_equal_widths_are_one_width(rgb):
    one = values(rgb, layered(rgb, metal(), alpha=0.2), walks=512)
    two = values(rgb, layered(rgb, metal(), alpha_u=0.2, alpha_v=0.2), walks=512)
    np.testing.assert_array_equal(one, two)


def test_textures_are_numbers_at_each_point(rgb):
    def texture(value: float) -> dict:
        pixels = np.full((4, 4, 1), value, np.float32)
        return bitmap(pixels)

    numbers = {**WIDTHS, "rotation": 25.0}
    plain = values(rgb, layered(rgb, **numbers), walks=1 << 14)
    textured = layered(rgb, **{name: texture(value) for name, value in numbers.items()})
    # A rounding of the filter may send a walk another way.
    changed = values(rgb, textured, walks=1 << 14) - plain
    assert abs(changed.mean()) < 0.01 * plain.mean()
    assert np.median(np.abs(changed)) < 1e-5 * plain.mean()


def picture(mi, bsdf, degrees: float) -> np.ndarray:
    """Independent pictures (8, 3) of a plate turned about its normal, as means over the pixels."""
    transform = mi.ScalarTransform4f
    sky = np.full((8, 16, 3), 0.05, np.float32)
    sky[1, 5] = 20
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "direct"},
            "sensor": {
                "type": "perspective",
                "fov": 10,  # only the plate is seen
                "to_world": transform().look_at([0, -3, 3], [0, 0, 0], [0, 0, 1]),
                "film": {"type": "hdrfilm", "width": 4, "height": 4},
            },
            "light": {
                "type": "envmap",
                "bitmap": mi.Bitmap(sky),
                "to_world": transform().rotate([1, 0, 0], 90),
            },
            "plate": {
                "type": "rectangle",
                "to_world": transform().rotate([0, 0, 1], degrees),
                "bsdf": bsdf,
            },
        }
    )
    return np.stack(
        [mi.render(scene, spp=256, seed=seed).numpy().mean(axis=(0, 1)) for seed in range(8)]
    )


def test_the_tangent_turns_with_the_shape_and_the_rotation(rgb):
    """A shape turned by a quarter, a rotation by a quarter, and exchanged widths are the same."""

    def plate(degrees: float, **parameters) -> np.ndarray:
        return picture(rgb, layered(rgb, metal(), **parameters), degrees)

    both = {"alpha_u": 0.15, "alpha_v": 0.5}
    crossed = metal() | {"alpha_u": 0.4, "alpha_v": 0.1}
    pictures = [
        plate(90, **both),
        plate(0, **both, rotation=90.0),
        plate(40, **both, rotation=50.0),
        picture(rgb, layered(rgb, crossed, alpha_u=0.5, alpha_v=0.15), 0),
    ]
    straight = plate(0, **both)
    first = pictures[0]
    for other in pictures[1:]:
        error = np.sqrt((first.var(axis=0, ddof=1) + other.var(axis=0, ddof=1)) / len(first))
        assert (np.abs(first.mean(axis=0) - other.mean(axis=0)) < 5 * error).all()
    # Without the turn, the plate looks different, by far more than the noise.
    assert (np.abs(first.mean(axis=0) / straight.mean(axis=0) - 1) > 0.1).all()


@pytest.mark.parametrize(
    ("properties", "sentence"),
    [
        ({"alpha": 0.1, "alpha_u": 0.2}, "layered: alpha is given together with alpha_u or alph"),
        ({"alpha_u": 0.2}, "layered: alpha_v is missing; alpha_u and alpha_v go together"),
        ({"alpha_u": 0.2, "alpha_v": 0.0}, "alpha_v is 0; it must be a GGX width in [0.01, 1]"),
        ({"rotation": float("inf")}, "rotation is inf; it must be an angle in degrees, finite"),
        ({"rotation": "east"}, "rotation must be a number, a spectrum or a texture"),
        (
            {"base": {"type": "layered", "rotation": 10.0, "base": {"type": "diffuse"}}},
            "layered: the nested coat has its own rotation, but all layers share one",
        ),
    ],
)
def test_mistakes_are_named(rgb, properties, sentence):
    with pytest.raises(RuntimeError) as caught:
        layered(rgb, **properties)
    assert sentence in str(caught.value)


def test_widths_that_are_colours_are_walks_of_their_own(rgb):
    """The mean of every channel is that of a coat of its width."""
    widths = np.array([[0.5, 0.2, 0.1], [0.1, 0.3, 0.6]])
    u, v = ({"type": "rgb", "value": row.tolist()} for row in widths)
    inner = {"type": "layered", "alpha": 0.3, "base": metal()}
    bsdf = layered(rgb, inner, alpha_u=u, alpha_v=v, rotation=20.0)
    both = three_channels(rgb, bsdf, 1 << 15)
    for channel in range(3):
        alone = layered(
            *(rgb, inner), alpha_u=widths[0, channel], alpha_v=widths[1, channel], rotation=20.0
        )
        one = three_channels(rgb, alone, 1 << 15)[channel]
        error = np.hypot(both[channel].std(), one.std()) / np.sqrt(len(one))
        # The same random numbers: the same walks, up to the rounding of another kernel.
        assert abs(both[channel].mean() - one.mean()) < error
    assert both.mean(axis=1).std() > 0.05 * both.mean()


def three_channels(mi, bsdf, walks: int) -> np.ndarray:
    """f cos (3, walks) of all channels."""
    a = np.tile(WI.astype(np.float32), (walks, 1))
    si = probing.interaction(a, np.random.default_rng(0).random((walks, 2)))
    return bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(*WO.tolist())).numpy().astype(np.float64)


def test_monochromatic_variants_read_the_luminance_of_a_colour():
    import mitsuba as mi

    import urushi  # noqa: F401  (registers the plugins)

    if "llvm_ad_mono" not in mi.variants():
        pytest.skip("Mitsuba has no variant llvm_ad_mono")
    mi.set_variant("llvm_ad_mono")
    color = {"type": "rgb", "value": [0.1, 0.4, 0.7]}
    parameters = mi.traverse(layered(mi, alpha_u=color, alpha_v=0.2))
    # Rec. 709: the weights of red, green and blue.
    luminance = 0.2126 * 0.1 + 0.7152 * 0.4 + 0.0722 * 0.7
    assert parameters["alpha_u.value"][0] == pytest.approx(luminance, rel=1e-3)
