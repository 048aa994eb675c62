"""`layered` with two widths: the walk's values, densities, and the frame that all layers share."""

import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, check_walk, walked

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
    return mi.load_dict({"type": "layered", **COAT, "base": bottom} | parameters)


def values(bsdf, walks: int) -> np.ndarray:
    """f (walks, channels) [1/sr] of a pair, by walks of their own."""
    return walked(bsdf, WI[None], WO[None], walks)[:, 0]


def test_the_plugin_is_the_walk(rgb):
    degrees, bottom = 30, conductor(eta=0.2, k=3.9, alpha_u=0.1, alpha_v=0.4)
    turn, wide = {"rotation": float(degrees)}, {"alpha_u": 0.2, "alpha_v": 0.5}
    inner = {"type": "layered", "alpha": 0.3, "int_ior": 1.8, "base": metal()}
    for base, widths, below in (
        (None, WIDTHS, diffuse(0.6)),
        (metal(), WIDTHS, bottom),
        (inner, wide, coat(bottom, 0.3, 1.2)),
    ):
        stack = coat(below, **MEDIUM, **widths)
        check_walk(layered(rgb, base, **widths, **turn), stack, degrees)


def test_the_proposal_follows_an_anisotropic_bottom(rgb):
    from urushi.mitsuba.plugins.stack import BottomLobes

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


def test_equal_widths_are_one_width_and_textures_are_numbers(rgb):
    one, two = (
        values(layered(rgb, metal(), **x), 512)
        for x in ({"alpha": 0.2}, {"alpha_u": 0.2, "alpha_v": 0.2})
    )
    np.testing.assert_array_equal(one, two)
    numbers = {**WIDTHS, "rotation": 25.0}
    plain = values(layered(rgb, **numbers), 1 << 14)
    textures = {name: bitmap(np.full((4, 4, 1), value)) for name, value in numbers.items()}
    # A rounding of the filter may send a walk another way.
    changed = values(layered(rgb, **textures), 1 << 14) - plain
    assert abs(changed.mean()) < 0.01 * plain.mean()
    assert np.median(np.abs(changed)) < 1e-5 * plain.mean()


def test_widths_that_are_colours_are_walks_of_their_own(rgb):
    """The mean of every channel is that of a coat of its width."""
    widths = np.array([[0.5, 0.2, 0.1], [0.1, 0.3, 0.6]])
    u, v = ({"type": "rgb", "value": row.tolist()} for row in widths)
    inner = {"type": "layered", "alpha": 0.3, "base": metal()}
    turned = {"base": inner, "rotation": 20.0}
    both = values(layered(rgb, alpha_u=u, alpha_v=v, **turned), 1 << 15)
    for channel, (alpha_u, alpha_v) in enumerate(widths.T):
        one = values(layered(rgb, alpha_u=alpha_u, alpha_v=alpha_v, **turned), 1 << 15)
        error = np.hypot(both[:, channel].std(), one[:, channel].std()) / np.sqrt(len(one))
        # The same random numbers: the same walks, up to the rounding of another kernel.
        assert abs(both[:, channel].mean() - one[:, channel].mean()) < error
    assert both.mean(axis=0).std() > 0.05 * both.mean()


def test_monochromatic_variants_read_the_luminance_of_a_colour(rgb):
    """By the weights of Rec. 709."""
    rgb.set_variant("llvm_ad_mono")
    color = {"type": "rgb", "value": [0.1, 0.4, 0.7]}
    parameters = rgb.traverse(layered(rgb, alpha_u=color, alpha_v=0.2))
    luminance = 0.2126 * 0.1 + 0.7152 * 0.4 + 0.0722 * 0.7
    assert parameters["alpha_u.value"][0] == pytest.approx(luminance, rel=1e-3)
