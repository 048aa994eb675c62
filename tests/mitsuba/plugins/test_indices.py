"""Absolute indices: of nested coats, and of conductors below them, in all forms."""

import functools

import numpy as np
import pytest
from tests.mitsuba.probes import f, strip, walked

import urushi
from urushi.core import fresnel
from urushi.core.direction_sets import cosine_pairs
from urushi.core.namespace import NUMPY

WI = np.array([[0.6, 0, 0.8]] * 3, np.float32)
WO = np.array([[-0.6, 0, 0.8], [0, 0.6, 0.8], [-0.5, 0.1, np.sqrt(0.74)]], np.float32)
GOLD = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2, "eta": 0.2, "k": 3.9}
BRUSHED = {k: v for k, v in GOLD.items() if k != "alpha"} | {"alpha_u": 0.05, "alpha_v": 0.3}
KINDS = "layered", "neural_layered"


def values(mi, description: dict, walks: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """f [1/sr] of the pairs and its standard error."""
    f = walked(mi.load_dict(description), WI, WO, walks)[..., 0]
    return f.mean(axis=0), f.std(axis=0) / np.sqrt(walks)


@pytest.mark.parametrize("base", [GOLD, GOLD | {"distribution": "beckmann"}])
@pytest.mark.parametrize("inner", KINDS)
@pytest.mark.parametrize("outer", KINDS)
def test_a_coat_of_the_index_above_has_no_interface(rgb, outer, inner, base):
    """Whatever its width. A walk of two coats has other random numbers; codes of walks are fitted,
    within 5 % of those of the bottom."""
    nested = {"type": inner, "alpha": 0.4, "int_ior": 1.5, "base": base}
    walks = 1 << 14 if outer == "layered" else 1
    one, se_one = values(rgb, {"type": outer, "int_ior": 1.5, "base": base}, walks)
    two, se_two = values(rgb, {"type": outer, "int_ior": 1.5, "base": nested}, walks)
    own = outer == inner
    np.testing.assert_array_less(
        np.abs(two - one), 4 * np.hypot(se_one, se_two) + one * (1e-5 if own else 0.05)
    )


@pytest.mark.parametrize("base", [BRUSHED, {"type": "roughplastic"}])
def test_a_textured_medium_without_an_interface_is_beers_law(rgb, base):
    """To rounding, over any bottom: here over two that codes represent badly."""
    data = np.float32([0.1, 0.4, 1.0])
    depth = strip(*data, filter_type="nearest")
    coat = {"type": "neural_layered", "alpha": 0.3, "int_ior": 1.0, "sigma_t": depth, "base": base}
    uv = np.array([[1 / 6, 0.5], [1 / 2, 0.5], [5 / 6, 0.5]])
    found, bare = (f(rgb.load_dict(bsdf), WI, WO, uv) for bsdf in (coat, base))
    path = data * (1 / WI[:, 2] + 1 / WO[:, 2])
    np.testing.assert_allclose(found, bare * np.exp(-path)[:, None], rtol=1e-5)


@pytest.mark.parametrize("inner", [(1.3, 2.2), (1.8, 1.4)])
def test_metals_below_two_textured_indices_are_those_below_numbers(rgb, few_points, inner):
    def loaded(outer, inner):
        coat = {"type": "neural_layered", "alpha": 0.3, "int_ior": inner, "bottom": GOLD}
        return rgb.load_dict(coat | {"int_ior": outer, "bottom": coat})

    outer = 1.3, 2.2
    varying = loaded(*(strip(*x, filter_type="nearest") for x in (outer, inner)))
    wi, wo = cosine_pairs(np.random.default_rng(3), 64, lowest_cosine=0.1)
    for place, indices in enumerate(zip(outer, inner, strict=True)):
        found, expected = f(varying, wi, wo, (0.25 + place / 2, 0.5)), f(loaded(*indices), wi, wo)
        np.testing.assert_allclose(found.mean(axis=0), expected.mean(axis=0), rtol=0.02)


def test_ext_ior_is_kept_where_it_is_given(rgb):
    """An explicit air gap; and a textured index above, where it has the same value."""
    for kind in KINDS:
        inner = {"type": kind, "alpha": 0.3, "int_ior": 1.3, "base": GOLD}
        outer = {"type": kind, "int_ior": 1.6}
        derived, _ = values(rgb, outer | {"base": inner})
        given, _ = values(rgb, outer | {"base": inner | {"ext_ior": 1.6}})
        gap, _ = values(rgb, outer | {"base": inner | {"ext_ior": 1.0}})
        np.testing.assert_allclose(derived, given, rtol=1e-4)
        assert (np.abs(gap / derived - 1) > 0.01).any()
    layered = {"type": "layered", "int_ior": strip(1.4, 1.6, filter_type="nearest")}
    textured = rgb.load_dict(layered | {"base": inner | {"type": "layered"}})
    for u, index in ((0.25, 1.4), (0.75, 1.6)):
        alone = rgb.load_dict(layered | {"int_ior": index, "base": inner | {"type": "layered"}})
        found = (f(bsdf, WI, WO, (u, 0.5)) for bsdf in (textured, alone))
        np.testing.assert_allclose(*found, rtol=1e-4)


def normal_map(inner: dict, **switches) -> dict:
    """A `normalmap` that tilts the surface by 17 degrees."""
    texture = strip([0.64, 0.5, 0.98])
    return {"type": "normalmap", "normalmap": texture, "inner": inner} | switches


def bump_map(inner: dict) -> dict:
    """A `bumpmap` of a slope along u."""
    texture = strip(*(np.arange(8) / 8), wrap_mode="mirror")
    return {"type": "bumpmap", "heights": texture, "inner": inner, "scale": 0.7}


WRAPPERS = {
    "twosided": lambda inner: {"type": "twosided", "inner": inner},
    "blendbsdf": lambda inner: {
        "type": "blendbsdf",
        "weight": {"type": "checkerboard", "color0": 0.2, "color1": 0.9},
        "first": inner,
        "second": {"type": "twosided", "inner": inner},
    },
    "normalmap": normal_map,
    "without shadowing": functools.partial(normal_map, use_shadowing_function=False),
    "without flips": functools.partial(normal_map, flip_invalid_normals=False),
    "bumpmap": bump_map,
}


@pytest.mark.parametrize("wrapper", WRAPPERS)
def test_metals_and_coats_in_wrappers_keep_their_indices(rgb, wrapper):
    """Below a medium of 1.5 a metal's f is that in air times the ratio of Fresnel's terms at the
    half vector, which no tilt of the normal changes; a coat of 1.5 over it has no interface."""
    from urushi.mitsuba.reading.changed import relative_to_index

    uv, index = np.array([[0.3, 0.6], [0.8, 0.2], [0.1, 0.7]]), 1.5 / 1.000277
    cosine = np.sqrt(0.5 + 0.5 * np.sum(WI * WO, axis=1, dtype=np.float64))
    air, medium = (fresnel.exact(cosine, 0.2 / n, 3.9 / n, NUMPY) for n in (1, index))
    coat = {"type": "neural_layered", "alpha": 0.4, "int_ior": 1.5, "base": GOLD}
    bare = f(rgb.load_dict(WRAPPERS[wrapper](GOLD)), WI, WO, uv)
    for inner in (GOLD, coat):
        wrapped = relative_to_index(rgb.load_dict(WRAPPERS[wrapper](inner)), index)
        found = f(wrapped, WI, WO, uv)
        np.testing.assert_allclose(found, bare * (medium / air)[:, None], rtol=1e-4)


@pytest.mark.parametrize("plugin", KINDS)
def test_an_opaque_mask_under_a_coat_is_none(rgb, plugin):
    """f is that of the coat over the BSDF in the mask. Other masks transmit light: an error."""
    masked = {"type": "mask", "inner": GOLD, "opacity": 1.0}
    found, expected = (
        f(rgb.load_dict({"type": plugin, "base": base}), WI, WO) for base in (masked, GOLD)
    )
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_python_plugins_and_the_walk_agree(rgb):
    """Two coats of other indices over gold: networks within 15 % of the walk at each pair, plugin
    and Python, nested by hand, by file and by a new coat, to rounding."""
    description = urushi.conductor(0.2, eta=0.2, k=3.9)
    stack = urushi.coat(urushi.coat(description, 0.3, ior=1.7), ior=1.4)
    assert stack.coats[1].eta == pytest.approx(1.7 / 1.4)
    assert stack.bottom.k == pytest.approx(3.9 * 1.000277 / 1.7)
    walk, _ = urushi.simulate(stack, WI, WO, walks=1 << 15, progress=False)
    inner = {"type": "neural_layered", "alpha": 0.3, "int_ior": 1.7, "base": GOLD}
    plugin, _ = values(rgb, {"type": "neural_layered", "int_ior": 1.4, "base": inner})
    lower = urushi.layer(urushi.dielectric(0.3, ior=1.7), description)
    material = urushi.layer(urushi.dielectric(ior=1.4), lower)
    np.testing.assert_allclose(material.f(WI, WO)[:, 0], plugin, rtol=0.02)  # tables of the plugin
    np.testing.assert_allclose(plugin, walk[:, 0], rtol=0.15)


def test_files_remember_their_coats(tmp_path, rgb):
    lower = urushi.layer(urushi.dielectric(0.3, ior=1.5), urushi.diffuse(0.5))
    lower.save(tmp_path / "lower.safetensors")
    read = urushi.load(tmp_path / "lower.safetensors")
    assert read == lower
    top = urushi.dielectric(0.1, ior=1.5)
    once = urushi.layer(top, urushi.diffuse(0.5))
    for bottom in (lower, read):
        np.testing.assert_allclose(urushi.layer(top, bottom).latents, once.latents, atol=1e-6)
    inner = {"type": "neural_brdf", "filename": str(tmp_path / "lower.safetensors")}
    plugin = rgb.load_dict({"type": "neural_layered", "alpha": 0.1, "int_ior": 1.5, "base": inner})
    codes = plugin.latents.at(np.zeros((1, 2)))[0]
    np.testing.assert_allclose(codes[0], once.latents[0], atol=1e-3)
