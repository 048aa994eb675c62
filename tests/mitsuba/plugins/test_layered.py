"""`layered` is the walk of the stack that it describes, in the frame that all layers share."""

import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, check_walk, f, walked

import urushi

GREY = {"type": "diffuse", "reflectance": 0.6}
METAL = {"type": "roughconductor", "distribution": "ggx", "eta": 0.2, "k": 3.9}
METAL |= {"alpha_u": 0.1, "alpha_v": 0.4}
BOTTOMS = {
    "grey": (GREY, urushi.diffuse(0.6)),
    "metal": (METAL, urushi.conductor(eta=0.2, k=3.9, alpha_u=0.1, alpha_v=0.4)),
    "orange": (
        GREY | {"reflectance": {"type": "rgb", "value": [0.8, 0.4, 0.1]}},
        urushi.diffuse((0.8, 0.4, 0.1)),
    ),
}

WI, WO = np.array([[0.5, 0.2, 0.71**0.5]]), np.array([[-0.3, 0.4, 0.75**0.5]])

MEDIUM = {"albedo": 0.7, "sigma_t": 0.5, "g": 0.3}
SMOOTH = {"alpha": 0.25, "ior": 1.4}
WIDTHS = {"alpha_u": 0.5, "alpha_v": 0.1}
COLOURED = {"alpha_u": (0.5, 0.2, 0.1), "alpha_v": (0.1, 0.3, 0.6)}
LOOK = {"color": (0.9, 0.5, 0.2), "body": 0.4, "body_color": (0.3, 0.6, 0.8), "thickness": 1.5}

#: Bottoms, and the coats on them from below.
STACKS = {
    "two widths": ("grey", MEDIUM | WIDTHS),
    "two widths over a metal": ("metal", MEDIUM | WIDTHS),
    "nested": ("metal", {"alpha": 0.3, "ior": 1.8}, MEDIUM | {"alpha_u": 0.2, "alpha_v": 0.5}),
    "coloured widths": ("metal", {"alpha": 0.3, "ior": 1.5046}, MEDIUM | COLOURED),
    "lower index": ("grey", MEDIUM | {"alpha": 0.2, "ior": 0.8}),
    "lower index inside": ("grey", MEDIUM | {"alpha": 0.2, "ior": 1.2}, MEDIUM | {"alpha": 0.2}),
    "appearance": ("grey", LOOK | {"alpha": 0.2, "g": 0.3}),
    "measured": ("measured", MEDIUM | {"alpha": 0.2}),
    # a rough top: light leaves by sampled phase directions as often as by connections
    "g, rough": (
        "orange",
        {"alpha": 1.0, "ior": 1.4, "albedo": 0.95, "sigma_t": 2.0, "g": (-0.8, 0.0, 0.9)},
    ),
    "index below one": (
        "orange",
        SMOOTH | {"ior": 0.7, "albedo": (0.9, 0.5, 1.0), "sigma_t": (0.0, 2.0, 5.0), "g": 0.4},
    ),
    "hardly scattering over another": (
        "orange",
        SMOOTH | {"ior": 1.96, "albedo": (0.02, 0.1, 0.9), "sigma_t": (3.0, 0.0, 1.0)},
        SMOOTH | {"albedo": 0.1, "sigma_t": (0.0, 1.0, 2.0), "g": 0.5},
    ),
    "deep": ("orange", SMOOTH | {"albedo": 1.0, "sigma_t": (13.0, 20.0, 50.0)}),
}


def coated(base: dict, ior: float = 1.5, **parameters) -> dict:
    """A coat over a bottom; tuples are colours."""
    for name, value in parameters.items():
        if isinstance(value, tuple):
            parameters[name] = {"type": "rgb", "value": list(value)}
    return {"type": "layered", "int_ior": ior, "base": base, **parameters}


@pytest.mark.parametrize("name", STACKS)
def test_the_plugin_is_the_walk(rgb, merl_file, name):
    """Also where some directions are beyond the critical angle; all layers are turned.

    The plugin's walks carry a colour, those of `simulate` one channel.
    """
    kind, *coats = STACKS[name]
    if kind == "measured":
        described = {"type": "measured_brdf", "filename": str(merl_file)}
        stack = urushi.load_measured(merl_file)
    else:
        described, stack = BOTTOMS[kind]
    for coat in coats:
        described, stack = coated(described, **coat), urushi.coat(stack, **{"ior": 1.5} | coat)
    check_walk(rgb.load_dict(described | {"rotation": 30.0}), stack, degrees=30)


def test_the_proposal_follows_an_anisotropic_bottom(rgb):
    """A reflector of one GGX lobe gives its widths twice. The quantiles of 16384 samples have
    errors of 1.5 %, and the horizon cuts 1 % of the samples off, more of wider lobes."""
    from urushi.mitsuba.plugins.stack import BottomLobes

    for widths in ((0.1, 0.04), (0.02, 0.08), (0.1, 0.1)):
        two = {"alpha_u": widths[0], "alpha_v": widths[1]}
        for alpha in BottomLobes(rgb.load_dict(METAL | two)).alphas:
            one = widths[0] == widths[1]
            found = alpha.numpy() if one else [alpha.u.numpy()[0], alpha.v.numpy()[0]]
            np.testing.assert_allclose(found, widths[: len(found)], rtol=0.08)


def test_equal_widths_are_one_width_and_textures_are_numbers(rgb):
    """The same random numbers; a rounding of a filter may send a walk another way."""

    def values(base=GREY, walks=1 << 14, **coat) -> np.ndarray:
        return walked(rgb.load_dict(coated(base, **MEDIUM, **coat)), WI, WO, walks)

    one, two = (values(METAL, 512, **x) for x in ({"alpha": 0.2}, {"alpha_u": 0.2, "alpha_v": 0.2}))
    np.testing.assert_array_equal(one, two)
    numbers = WIDTHS | {"rotation": 25.0}
    plain = values(**numbers)
    textures = {name: bitmap(np.full((4, 4, 1), value)) for name, value in numbers.items()}
    changed = values(**textures) - plain
    assert abs(changed.mean()) < 0.01 * plain.mean()
    assert np.median(np.abs(changed)) < 1e-5 * plain.mean()


def test_one_word_changes_networks_to_walks(rgb):
    """`layered` ignores what `neural_layered` adds."""
    extended = coated(GREY, alpha=0.2, resolution=64, weights="default")
    plain = coated(GREY, alpha=0.2)
    np.testing.assert_array_equal(*(f(rgb.load_dict(x), WI, WO) for x in (extended, plain)))


def test_monochromatic_variants_read_the_luminance_of_a_colour(rgb):
    """By the weights of Rec. 709."""
    rgb.set_variant("llvm_ad_mono")
    parameters = rgb.traverse(rgb.load_dict(coated(GREY, alpha_u=(0.1, 0.4, 0.7), alpha_v=0.2)))
    luminance = 0.2126 * 0.1 + 0.7152 * 0.4 + 0.0722 * 0.7
    assert parameters["alpha_u.value"][0] == pytest.approx(luminance, rel=1e-3)
