"""White furnaces of coats, films and panes of `openpbr`, and weights of its samples.

`test_laws` has the furnaces of bases.
"""

import itertools
from typing import NamedTuple

import numpy as np
import pytest
from tests.mitsuba.probes import sampled, strip
from tests.openpbr_surface.probes import WHITE, loaded, pairs, toward, values

pytestmark = pytest.mark.usefixtures("rgb")

#: Samples of a material.
SAMPLES = 1 << 16


class Furnace(NamedTuple):
    """A white or clear material and how close to one its albedo is."""

    parameters: dict
    tolerance: float = 0.01
    cosines: tuple = (1.0, 0.6, 0.3, 0.2)
    azimuths: tuple = (50.0,)
    most: float | None = None  # excess over one that is allowed; None: the tolerance


PANE = {"geometry_thin_walled": True, "transmission_weight": 1.0, "interior": True}
PANE |= {"coat_weight": 0.0}
GLASS = {"transmission_weight": 1.0, "interior": True, "coat_roughness": 0.5}
METAL, WALKS = {"base_metalness": 1.0}, {"reference": True}
FILMED = {"thin_film_weight": 1.0, "thin_film_ior": 1.8, "coat_weight": 0.0}
ROUGH = {"specular_roughness": 0.596, "coat_roughness": 0.16, "coat_ior": 2.5}
COATED_METAL = METAL | {"specular_roughness": 0.385, "coat_roughness": 0.895, "coat_ior": 1.9}
MIXTURE = {"base_metalness": 0.5, "specular_roughness": 0.26, "coat_roughness": 0.81}
THIN = {"specular_roughness": 0.935, "coat_roughness": 0.849, "coat_ior": 1.2}
STRONG = {"specular_roughness": 0.89, "specular_ior": 1.92, "coat_roughness": 0.47}
SMOOTH = {"specular_roughness": 0.43, "specular_ior": 1.36, "coat_roughness": 0.19, "coat_ior": 2.2}
ETCHED = {"specular_roughness": (0.05, 0.9)}
BRUSHED = {"coat_roughness": 0.6, "coat_roughness_anisotropy": 0.7}
TURNS, SIDES = (0.0, 45.0, 90.0), (0.87, 0.34, -0.34)
FURNACES = {
    "dielectric": Furnace(ROUGH, 0.003),
    "metal": Furnace(COATED_METAL),
    "thin coat": Furnace(THIN, 0.003),
    "mixture": Furnace(MIXTURE),
    "one side": Furnace(STRONG | {"coat_ior": 2.18}, 0.005),
    # Tables of coats whose index is nearly one have errors of 4 % at grazing angles.
    "faint coat": Furnace({"coat_ior": 1.005, "coat_roughness": 0.0}, 0.005, (0.15, 0.1)),
    "faint coat, metal": Furnace(
        METAL | {"coat_ior": 1.02, "coat_roughness": 0.0}, 0.015, (0.2, 0.15, 0.1), most=0.005
    ),
    # What returns of the loss is over its mean, which must be the mean of the same table.
    "smooth coat": Furnace(SMOOTH, 0.005, (0.25, 0.15)),
    # The loss is linear between nodes; a texel of each is beside the middle.
    "varying index": Furnace({"coat_roughness": 0.5, "coat_ior": (1.2, 2.2)}, 0.01, (0.9, 0.3)),
    "varying anisotropy": Furnace(
        {"coat_roughness": 0.5, "coat_roughness_anisotropy": (0.0, 0.8)}, 0.01, (0.9, 0.3)
    ),
    # Interpolation of the loss, and noise of the walks.
    "brushed": Furnace(BRUSHED, 0.015, (0.3,), TURNS),
    "brushed, walks": Furnace(BRUSHED | WALKS, 0.015, (0.3,), TURNS),
    # The loss of walks has a noise of some 0.5 %.
    "walks": Furnace({"coat_roughness": 0.1} | WALKS, 0.015, (1.0, 0.6, 0.3)),
    "rough walks": Furnace({"coat_roughness": 1.0} | WALKS, 0.015, (1.0, 0.6, 0.3)),
    "walks over metal": Furnace(METAL | {"coat_roughness": 0.7} | WALKS, 0.015, (1.0, 0.6, 0.3)),
    # Codes of textures: 0.4 % of their own.
    "two textures": Furnace(
        {"coat_roughness": (0.2, 0.8), "specular_roughness": (0.7, 0.3)}, 0.01, (0.7,)
    ),
    "metal under a texture": Furnace(
        METAL | {"specular_roughness": 0.7, "coat_roughness": (0.3, 0.3001)}, 0.01, (1.0, 0.4)
    ),
    "film": Furnace(FILMED | {"specular_roughness": 1.0}, 0.02, (1.0, 0.6, 0.3)),
    # Both reflect totally at most angles: nothing is left to be passed by the mean of the facets.
    "film over air": Furnace(
        FILMED | {"thin_film_ior": 3.0, "specular_ior": 0.4, "specular_roughness": 0.0}, 0.02
    ),
    # The film reflects totally where the base does not.
    "low film": Furnace(FILMED | {"thin_film_ior": 0.5}, 0.015, (1.0, 0.85, 0.5)),
    "low film on glass": Furnace(
        {"transmission_weight": 1.0, "interior": True, "specular_roughness": 1.0}
        | FILMED
        | {"thin_film_ior": 0.7},
        *(0.15, (1.0, 0.2, 0.1, -0.5)),
        most=0.03,
    ),
    "filmed metal": Furnace(FILMED | METAL, 0.02, (1.0, 0.6, 0.3)),
    # The loss is linear between nine roughnesses, and between five azimuths of brushed panes.
    "etched pane": Furnace(PANE | ETCHED, 0.02, SIDES),
    "coat on etched glass": Furnace(GLASS | ETCHED, 0.02, SIDES),
    "brushed pane": Furnace(
        PANE | {"specular_roughness": 0.6, "specular_roughness_anisotropy": 0.9},
        *(0.02, (0.31,), TURNS),
    ),
    # The albedo changes most towards the wide width, near the edge of total reflection.
    "brushed glass": Furnace(
        {"transmission_weight": 1.0, "interior": True, "coat_weight": 0.0, "specular_ior": 2.0}
        | {"specular_roughness": 0.84, "specular_roughness_anisotropy": 1.0},
        *(0.02, (0.6, -0.1, -0.3), (*TURNS, 30.0)),
    ),
}


@pytest.mark.parametrize("name", FURNACES)
def test_white_and_clear_materials_return_all_light(few_paths, name):
    """A pair of numbers is a texture of two texels. Noise: four standard errors."""
    case = FURNACES[name]
    given = {
        k: strip(*x, filter_type="nearest") if isinstance(x, tuple) else x
        for k, x in case.parameters.items()
    }
    bsdf = loaded(**{"base_color": WHITE, "coat_weight": 1.0, **given})
    # Walks are noisy, and narrow coats from inside.
    noisy = bool({"reference", "interior"} & given.keys())
    textured, most = given != case.parameters, case.most or case.tolerance
    uv = np.array([[0.25, 0.5], [0.75, 0.5]] if textured else [[0.5, 0.5]])
    for cosine, azimuth in itertools.product(case.cosines, case.azimuths):
        wi = np.tile(toward(cosine, azimuth), (len(uv), 1))
        weight = sampled(bsdf, wi, SAMPLES, uv)[0][..., 0]
        found, noise = weight.mean(1), 4 * noisy * weight.std(1) / SAMPLES**0.5
        assert (found - 1 < most + noise).all()
        assert (1 - found < case.tolerance + noise).all()


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_codes_of_a_white_base_under_a_smooth_coat_lose_hardly_any_light(share):
    """Not compensated. Codes along axes that are too bright at grazing angles lose it there only:
    what white codes lose is given to coloured ones, which are not too bright."""
    smooth = {"base_metalness": share, "coat_weight": 1.0, "coat_ior": 1.5}
    smooth |= {"base_diffuse_roughness": strip(0.0, 0.1), "energy_compensation": False}
    bsdf = loaded(base_color=WHITE, **smooth)
    wi = np.stack([toward(cosine) for cosine in (1.0, 0.7, 0.4)])
    assert sampled(bsdf, wi, SAMPLES)[0].mean((1, 2)) == pytest.approx(1, abs=0.03)


@pytest.mark.parametrize("ior", [0.7, 1.0, 1.5])
def test_a_rough_slab_becomes_the_closed_form_as_its_roughness_vanishes(ior):
    """A roughness of zero by a texture, which the plugin cannot know, is that by a number."""
    zero = strip(0.0, 1e-9)
    shared = {"specular_ior": ior, "specular_roughness": 0.5}
    number, texture = (
        values(loaded(**shared, base_diffuse_roughness=x), *pairs(300)) for x in (0.0, zero)
    )
    np.testing.assert_allclose(texture, number, rtol=2e-5)


FUZZ = {"fuzz_weight": 1.0, "base_color": (0.02, 0.02, 0.02)}
CLEAR = {"transmission_weight": 1.0, "interior": True}


@pytest.mark.parametrize(
    ("parameters", "most"),
    [
        # Of both shares, what is below the fuzz has the least weights.
        (FUZZ | {"fuzz_roughness": 0.2}, 1.5),
        (FUZZ | {"fuzz_roughness": 1.0}, 1.5),
        # Light that meets several facets leaves by no lobe of the proposal.
        (CLEAR, 5),
        (CLEAR | {"thin_film_weight": 1.0, "thin_film_ior": 1.8, "thin_film_thickness": 0.4}, 5),
        (CLEAR | {"specular_roughness": 0.8}, 5),
    ],
)
def test_no_sample_has_a_large_weight(parameters, most):
    """f cos over the density is the albedo, at most one, where the density has the shape of f.

    Light from 20, 50, 65 and 80 degrees, on each side that light comes from.
    """
    bsdf, mode = loaded(**parameters), "Importance" if "interior" in parameters else "Radiance"
    for side in (1, -1) if "interior" in parameters else (1,):
        wi = np.stack([toward(side * np.cos(np.radians(x)), 0.0) for x in (20, 50, 65, 80)])
        assert sampled(bsdf, wi, 1 << 14, mode=mode)[0].max() < most
