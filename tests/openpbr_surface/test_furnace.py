"""White furnaces of `openpbr` over random parameters: what the base reflects of even light."""

import itertools
from dataclasses import dataclass

import mitsuba as mi
import numpy as np
import pytest

from urushi.mitsuba.reading import probing

pytestmark = pytest.mark.usefixtures("rgb")

WHITE = {"type": "rgb", "value": [1.0, 1.0, 1.0]}

#: Materials of a sweep, by rows and columns, and samples of each.
SIDE, SAMPLES = 4, 1 << 16

#: Ranges of what is drawn.
RANGES = {
    "specular_roughness": (0, 1),
    "specular_ior": (1.1, 2.5),
    "specular_roughness_anisotropy": (0, 0.9),
    "base_metalness": (0, 1),
    "base_diffuse_roughness": (0, 1),
    "thin_film_thickness": (0, 1),
    "thin_film_ior": (1.2, 2.4),
}

#: A film of which index and thickness vary.
FILM = ("thin_film_thickness", "thin_film_ior")


def drawn(names, seed):
    """Textures of random values, one texel for each material."""
    rng = np.random.default_rng(seed)
    return {
        name: {
            "type": "bitmap",
            "bitmap": mi.Bitmap(rng.uniform(*RANGES[name], (SIDE, SIDE, 1)).astype(np.float32)),
            "raw": True,
            "filter_type": "nearest",
        }
        for name in names
    }


def light(bsdf, cosine, uv, samples, azimuth=50.0):
    """Shares (N,) of the light that is reflected at points of uv (N, 2), by quasi-random samples,
    and their standard errors.

    azimuth: [degrees].
    """
    count, phi = len(uv) * samples, np.radians(azimuth)
    sine = (1 - cosine**2) ** 0.5
    wi = np.array([sine * np.cos(phi), sine * np.sin(phi), cosine])
    si = probing.interaction(np.tile(wi, (count, 1)), np.repeat(uv, samples, 0), np.arange(count))
    index = np.tile(np.arange(samples), len(uv))
    u = [((index + 0.5) * 1.2207440846057596**-k % 1).astype(np.float32) for k in (1, 2, 3)]
    _, weight = bsdf.sample(mi.BSDFContext(), si, mi.Float(u[0]), mi.Point2f(u[1], u[2]))
    weights = weight[0].numpy().reshape(len(uv), samples).astype(np.float64)
    return weights.mean(axis=1), weights.std(axis=1) / samples**0.5


@pytest.mark.parametrize(
    ("names", "constants", "tolerance"),
    [
        (("specular_roughness", "specular_ior"), {}, 0.003),
        (("specular_roughness",), {"base_metalness": 1.0}, 0.006),
        (("specular_roughness", "specular_ior", "base_metalness"), {}, 0.005),
        (("specular_roughness", "specular_roughness_anisotropy"), {"base_metalness": 1.0}, 0.006),
        pytest.param(
            ("specular_roughness", "specular_ior", "specular_roughness_anisotropy"),
            *({}, 0.008),
            marks=pytest.mark.slow,
        ),
        (("specular_roughness", "specular_roughness_anisotropy"), {"specular_ior": 2.2}, 0.003),
        (("specular_roughness", "specular_ior", "base_diffuse_roughness"), {}, 0.003),
        (("specular_roughness", "specular_ior"), {"base_diffuse_roughness": 1.0}, 0.003),
        (("specular_roughness",), {"base_diffuse_roughness": 1.0, "specular_ior": 1.0}, 0.005),
        (("specular_roughness",), {"base_diffuse_roughness": 1.0, "specular_ior": 0.9}, 0.005),
        pytest.param(
            ("specular_roughness", *FILM), {"thin_film_weight": 1.0}, 0.005, marks=pytest.mark.slow
        ),
    ],
)
def test_a_white_base_reflects_all_light(names, constants, tolerance):
    """The samples of rough metals have an error of up to 0.4 %; the tables of
    two widths have few indices. Below an index of one the tables follow the edge of total
    reflection. Four facets stand for all under a film."""
    bsdf = mi.load_dict({"type": "openpbr", "base_color": WHITE, **drawn(names, 7), **constants})
    axis = (np.arange(SIDE) + 0.5) / SIDE
    uv = np.stack(np.meshgrid(axis, axis), -1).reshape(-1, 2)
    for cosine in (1.0, 0.6, 0.3, 0.2):
        assert np.abs(light(bsdf, cosine, uv, SAMPLES)[0] - 1).max() < tolerance


@dataclass
class Furnace:
    """A white material under a coat, or a film, and how close to one its albedo is."""

    parameters: dict
    tolerance: float = 0.01
    cosines: tuple = (1.0, 0.6, 0.3, 0.2)
    azimuths: tuple = (50.0,)
    tier: str = ""  # "" for the first
    u: tuple = (0.5,)

    @property
    def walks(self) -> bool:
        return self.parameters.get("reference", False)


def texels(*values):
    """A row of texels."""
    bitmap = mi.Bitmap(np.float32([values])[..., None])
    return {"type": "bitmap", "raw": True, "filter_type": "nearest", "bitmap": bitmap}


METAL, WALKS = {"base_metalness": 1.0}, {"reference": True}
FILMED = {"thin_film_weight": 1.0, "thin_film_ior": 1.8, "coat_weight": 0.0}
ROUGH = {"specular_roughness": 0.596, "coat_roughness": 0.16, "coat_ior": 2.5}
COATED_METAL = METAL | {"specular_roughness": 0.385, "coat_roughness": 0.895, "coat_ior": 1.9}
MIXTURE = {"base_metalness": 0.5, "specular_roughness": 0.26, "coat_roughness": 0.81}
THIN = {"specular_roughness": 0.935, "coat_roughness": 0.849, "coat_ior": 1.2}
STRONG = {"specular_roughness": 0.89, "specular_ior": 1.92, "coat_roughness": 0.47}
SMOOTH = {"specular_roughness": 0.43, "specular_ior": 1.36, "coat_roughness": 0.19, "coat_ior": 2.2}
BRUSHED = {"coat_roughness": 0.6, "coat_roughness_anisotropy": 0.7}
FURNACES = {
    "dielectric": Furnace(ROUGH, 0.003, tier="slow"),
    "metal": Furnace(COATED_METAL, tier="slow"),
    "thin coat": Furnace(THIN, 0.003, tier="slow"),
    "mixture": Furnace(MIXTURE),
    "one side": Furnace(STRONG | {"coat_ior": 2.18}, 0.005, tier="slow"),
    # What returns of the loss is over its mean, which must be the mean of the same table.
    "smooth coat": Furnace(SMOOTH, 0.005, (0.25, 0.15), tier="slow"),
    # The loss is linear between nodes; a texel of each is beside the middle.
    "varying index": Furnace(
        {"coat_roughness": 0.5, "coat_ior": (1.2, 2.2)}, 0.01, (0.9, 0.3), u=(0.25, 0.75),
        tier="slow",
    ),
    "varying anisotropy": Furnace(
        {"coat_roughness": 0.5, "coat_roughness_anisotropy": (0.0, 0.8)}, 0.01, (0.9, 0.3),
        u=(0.25, 0.75), tier="slow",
    ),
    # Interpolation of the loss, and noise of the walks.
    "brushed": Furnace(BRUSHED, 0.015, (0.3,), (0.0, 45.0, 90.0), "slow"),
    "brushed, walks": Furnace(BRUSHED | WALKS, 0.015, (0.3,), (0.0, 45.0, 90.0)),
    # The loss of walks has a noise of some 0.5 %.
    "walks": Furnace({"coat_roughness": 0.1} | WALKS, 0.015, (1.0, 0.6, 0.3)),
    "rough walks": Furnace({"coat_roughness": 1.0} | WALKS, 0.015, (1.0, 0.6, 0.3)),
    "walks over metal": Furnace(METAL | {"coat_roughness": 0.7} | WALKS, 0.015, (1.0, 0.6, 0.3)),
    # Codes of textures: 0.4 % of their own.
    "two textures": Furnace(
        {"coat_roughness": (0.2, 0.8), "specular_roughness": (0.7, 0.3)}, 0.01, (0.7,),
        u=(0.25, 0.75),
    ),
    "metal under a texture": Furnace(
        METAL | {"specular_roughness": 0.7, "coat_roughness": (0.3, 0.3001)}, 0.01, (1.0, 0.4)
    ),
    "film": Furnace(FILMED | {"specular_roughness": 1.0}, 0.02, (1.0, 0.6, 0.3), tier="slow"),
    "filmed metal": Furnace(FILMED | METAL, 0.02, (1.0, 0.6, 0.3)),
}  # fmt: skip


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(x, marks=getattr(pytest.mark, y.tier) if y.tier else ())
        for x, y in FURNACES.items()
    ],
)
def test_a_white_material_under_a_coat_reflects_all_light(name):
    """A pair of numbers is a texture of two texels. Walks have noise: four standard errors."""
    case = FURNACES[name]
    given = {k: texels(*x) if isinstance(x, tuple) else x for k, x in case.parameters.items()}
    bsdf = mi.load_dict({"type": "openpbr", "base_color": WHITE, "coat_weight": 1.0, **given})
    uv = np.column_stack([case.u, np.full(len(case.u), 0.5)])
    for cosine, azimuth in itertools.product(case.cosines, case.azimuths):
        found, error = light(bsdf, cosine, uv, SAMPLES, azimuth)
        assert (np.abs(found - 1) < case.tolerance + 4 * case.walks * error).all()


@pytest.mark.parametrize("ior", [0.6, 1.0, 1.5])
def test_a_rough_slab_is_reciprocal_and_never_negative(ior):
    """Up to rounding in single precision; at grazing angles its later reflections have a bound."""
    rng = np.random.default_rng(5)
    cosine = np.concatenate([rng.uniform(0.01, 1, (2, 300)), rng.uniform(0.01, 0.1, (2, 100))], 1)
    azimuth, sine = 2 * np.pi * rng.random((2, 400)), np.sqrt(1 - cosine**2)
    wi, wo = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine], -1)
    bsdf = mi.load_dict(
        {
            "type": "openpbr",
            "base_color": {"type": "rgb", "value": [1.0, 0.5, 0.1]},
            "base_diffuse_roughness": 1.0,
            "specular_ior": ior,
            "specular_roughness": 0.6,
        }
    )
    uv = np.full((400, 2), 0.5)
    f = probing.bsdf_values(bsdf, wi, wo, uv)
    np.testing.assert_allclose(f, probing.bsdf_values(bsdf, wo, wi, uv), rtol=1e-4, atol=1e-6)
    assert f.min() >= 0


@pytest.mark.parametrize("ior", [0.7, 1.0, 1.5])
def test_a_rough_slab_becomes_the_closed_form_as_its_roughness_vanishes(ior):
    """A roughness of zero by a texture, which the plugin cannot know, is that by a number."""
    texels = np.float32([0, 0, 0, 1e-9]).reshape(2, 2, 1)
    zero = {"type": "bitmap", "raw": True, "bitmap": mi.Bitmap(texels)}
    rng = np.random.default_rng(6)
    wi, wo = rng.normal(size=(2, 300, 3)) * [1, 1, 0] + [0, 0, 1]
    wi, wo = (w / np.linalg.norm(w, axis=1, keepdims=True) for w in (wi, wo))
    found = []
    for rough in (0.0, zero):
        shared = {"specular_ior": ior, "specular_roughness": 0.5, "base_diffuse_roughness": rough}
        bsdf = mi.load_dict({"type": "openpbr", **shared})
        found.append(probing.bsdf_values(bsdf, wi, wo, np.full((300, 2), 0.5)))
    np.testing.assert_allclose(found[1], found[0], rtol=2e-5)
