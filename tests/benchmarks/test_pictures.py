"""Pictures: their comparison, spheres without noise, and what differs between scenes."""

import numpy as np
import pytest
from benchmarks import sphere
from benchmarks.pictures import BEST_PSNR, flip, psnr
from benchmarks.scenes import OWN, POINT, PRINCIPLED, SCENES, SKY, WALK, View, digest
from benchmarks.sphere import AZIMUTHS, ELEVATIONS

from urushi.core.error_metrics import srgb
from urushi.nets.weights import DEFAULT

WHITE = np.ones((ELEVATIONS, AZIMUTHS, 3))
SMALL = {"width": 16, "detail": 0.02}


def test_comparisons_are_of_display_values_inside_the_mask():
    whole = np.ones((24, 32), bool)
    a, b = (np.full((24, 32, 3), v) for v in (0.2, 0.3))
    expected = -20 * np.log10(srgb(np.array(0.3)) - srgb(np.array(0.2)))
    assert psnr(a, b, whole) == pytest.approx(expected, abs=0.01)
    mask, other = whole.copy(), a.copy()
    mask[12:], other[12:] = False, 0.5
    assert psnr(other, a, mask) == BEST_PSNR and flip(a, a) == 0
    # The largest value of FLIP; its colour term alone is near one here (Andersson et al. 2020).
    assert flip(0 * a + 1, 0 * a) == pytest.approx(1, abs=0.05)


def test_a_white_sphere_vanishes_in_a_white_furnace():
    white = sphere.transport(lambda wi, wo: np.full((len(wi), 1), 1 / np.pi))
    picture = sphere.picture(white, WHITE)
    inside = sphere.mask()
    np.testing.assert_allclose(picture[inside], 1, atol=1e-3)
    assert (picture[~inside] == 0).all()


@pytest.mark.parametrize("alpha", [0.005, 0.03, 0.1])
def test_narrow_lobes_are_integrated_whole(alpha):
    """Of GGX (Walter et al. 2007) without masking, whose projected area is that of the plane."""

    def f(wi, wo):
        wi, wo = wi.astype(np.float64), wo.astype(np.float64)
        half = (wi + wo) / np.linalg.norm(wi + wo, axis=1, keepdims=True)
        tangent2 = half[:, 0] ** 2 + half[:, 1] ** 2
        d = alpha**2 / (np.pi * (alpha**2 * half[:, 2] ** 2 + tangent2) ** 2)
        return d[:, None] / (4 * (half * wi).sum(1) * wo[:, 2])[:, None]

    # In front, where no normal that matters is cut off, the integral of D(h) h.n is 1, and that of
    # this lobe with it: dh = dwo / 4 (wi.h), and h.n is within 1 % of 1 for these widths.
    middle = sphere.picture(sphere.transport(f), WHITE)[sphere.RINGS, sphere.RINGS]
    np.testing.assert_allclose(middle, 1, atol=0.015)


def types(node):
    """The types of all nodes; of OpenPBR, the plugin of its coat."""
    yield node.get("reference", node["type"])
    for value in node.values():
        if isinstance(value, dict):
            yield from types(value)


@pytest.mark.parametrize("name", sorted({*SCENES} - {"library"}))  # saved materials, no coats
def test_methods_replace_every_coat_and_leave_the_rest(rgb, name, tmp_path):
    found = {
        method: list(types(View(name, **SMALL).described(method, tmp_path)))
        for method in (WALK, PRINCIPLED, DEFAULT)
    }
    coats = found[WALK].count("layered")
    assert coats > 0 and coats == found[DEFAULT].count("neural_layered")
    assert coats == found[PRINCIPLED].count("principled")
    assert not {"layered", "neural_layered"} & set(found[PRINCIPLED])
    assert found[WALK].count("bitmap") == found[PRINCIPLED].count("bitmap")
    assert [x for x in found[WALK] if x != "layered"] == [
        x for x in found[DEFAULT] if x != "neural_layered"
    ]


def test_the_hash_states_content_and_not_the_folder(rgb, tmp_path):
    def of(method=WALK, light=OWN, folder="a", **size):
        path = tmp_path / f"{folder}-{method}-{light}-{size}"
        return digest(View("caddy", light, **(SMALL | size)).described(method, path), path)

    assert of() == of(folder="b")
    others = [of(DEFAULT), of(PRINCIPLED), of(light=POINT), of(light=SKY), of(width=20)]
    assert len({of(), *others}) == 1 + len(others)
