"""Networks by plugins against walks: coats over textures by axes of parameters, and dielectrics."""

import mitsuba as mi
import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, strip

from urushi.core.direction_sets import cosine_pairs
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading import probing
from urushi.nets.transmittance import both_ways
from urushi.textures.principal import LARGEST_ERROR

COUNT = 1 << 18

SILVER = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2, "material": "Ag"}
RUST = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.3, 0.1, 0.05]}}
GOLD = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2, "material": "Au"}


def square():
    """A square whose corners have the colours `vertex_color`, and numbers that are the same."""
    mesh = mi.Mesh("square", vertex_count=4, face_count=2)
    params = mi.traverse(mesh)
    params["vertex_positions"] = [0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0]
    params["faces"] = [0, 1, 2, 0, 2, 3]
    params.update()
    colours = [0.9, 0.1, 0.1, 0.1, 0.8, 0.2, 0.2, 0.1, 0.9, 0.7, 0.7, 0.05]
    mesh.add_attribute("vertex_color", 3, colours)
    mesh.add_attribute("vertex_value", 1, [0.3] * 4)
    mesh.add_attribute("vertex_index", 1, [1.3] * 4)
    return mesh


def interactions(shape=None, u=None):
    """Surface interactions, half of them inside a shape, seen at a cosine of 0.8.

    u: where all of them are; None: everywhere.
    """
    rng = np.random.default_rng(0)
    ray = mi.Ray3f(mi.Point3f(*np.float32(rng.random((2, COUNT))), 1), mi.Vector3f(0, 0, -1))
    unit = mi.ScalarTransform4f().translate([0.5, 0.5, 0]).scale(0.5)
    shape = shape or mi.load_dict({"type": "rectangle", "to_world": unit})
    si = mi.load_dict({"type": "scene", "shape": shape}).ray_intersect(ray)
    phi = rng.uniform(0, 2 * np.pi, COUNT)
    si.wi = mi.Vector3f(*np.float32([0.6 * np.cos(phi), 0.6 * np.sin(phi), 0 * phi + 0.8]))
    if u is not None:
        si.uv = mi.Point2f(u, 0.5)
    return si


def albedo(bsdf, si) -> np.ndarray:
    """The mean albedo over interactions by a plugin's own samples."""
    u = np.random.default_rng(1).random((3, COUNT), np.float32)
    _, weight = bsdf.sample(mi.BSDFContext(), si, mi.Float(u[0]), mi.Point2f(u[1:]))
    return weight.numpy().mean(axis=1)


def noise(channels: int, seed: int = 0):
    """A texture that several parameters may share."""
    return mi.load_dict(bitmap(np.random.default_rng(seed).uniform(0.1, 0.9, (8, 8, channels))))


def eight_bits(raw: bool) -> dict:
    """A bitmap as of a file: whole numbers, which Mitsuba keeps; of colours unless they are raw."""
    texels = np.random.default_rng(0).integers(40, 160, (8, 8, 1 if raw else 3)).astype(np.uint8)
    return {"type": "bitmap", "bitmap": mi.Bitmap(texels), "raw": raw}


BOARD = {"type": "checkerboard", "color0": 0.05, "color1": 0.8}
VERTICES = {"type": "mesh_attribute", "name": "vertex_color"}
PAINTED = {"type": "principled", "base_color": VERTICES, "roughness": 0.4}
DIFFUSE, WHITE = {"type": "diffuse"}, {"type": "diffuse", "reflectance": 0.8}
NEAR_ONE = {"alpha": 0.3, "ext_ior": 1.0, "base": WHITE}


def two_transforms() -> dict:
    turned = mi.ScalarTransform3f().rotate(30).scale([3, 2])
    return {"alpha": strip(0.05, 0.4, to_uv=turned), "base": GOLD | {"alpha": strip(0.1, 0.5, 0.3)}}


def two_roughnesses() -> dict:
    shared = noise(1)
    return {"alpha": shared, "base": GOLD | {"alpha": shared}}


def brushed() -> dict:
    """Some pairs of directions see nothing of it below a coat."""
    metal = {"type": "principled", "metallic": 1.0, "roughness": 0.4, "anisotropic": 0.6}
    return {"alpha": 0.35, "sigma_t": strip(0.1, 2.0), "base": metal | {"base_color": noise(1)}}


def tints() -> dict:
    """Its channels depend on each other, by the luminance."""
    tinted = {"spec_tint": 0.8, "metallic": strip(0.1, 0.6), "sheen": 0.5, "sheen_tint": 0.9}
    return {"base": {"type": "principled", "base_color": noise(3), **tinted}}


#: Coats with textures that texels of one grid represent badly, and the names of their axes. Those
#: of one texture lie along one axis, if one is a function of the other.
VARNISHES = {
    "checkerboard": (lambda: {"base": DIFFUSE | {"reflectance": BOARD}}, "bottom.reflectance"),
    "two transforms": (two_transforms, "alpha bottom.alpha"),
    "indices near one": (
        lambda: NEAR_ONE | {"int_ior": strip(1.01, 1.1, 2.5, filter_type="nearest")},
        "eta",
    ),
    "texels of eight bits": (
        lambda: {"alpha": eight_bits(True), "base": DIFFUSE | {"reflectance": eight_bits(False)}},
        "alpha bottom.reflectance",
    ),
    "vertex colours": (lambda: {"base": PAINTED}, "bottom.base_color"),
    "vertex colours of a dye": (lambda: {"color": VERTICES, "base": WHITE}, "sigma_t"),
    "a brushed metal": (brushed, "sigma_t bottom.base_color"),
    "a pigment's colour": (lambda: {"body": 0.6, "body_color": noise(3), "base": GOLD}, "albedo"),
    "tints": (tints, "bottom.metallic bottom.base_color bottom.base_color/luminance"),
    "two roughnesses": (two_roughnesses, "alpha"),
    "two textures": (
        lambda: {"alpha": noise(1), "base": GOLD | {"alpha": noise(1, seed=1)}},
        "alpha bottom.alpha",
    ),
}


def check(coat: dict, rtol: float, u=None, shape=None):
    """The albedo by networks is that by walks, of the same coat."""
    width = {} if "alpha_u" in coat else {"alpha": 0.1}
    coat, si = width | {"int_ior": 1.5} | coat, interactions(shape, u)
    bsdf = mi.load_dict(coat | {"type": "neural_layered"})
    truth = mi.load_dict(coat | {"type": "layered"})
    np.testing.assert_allclose(*(albedo(x, si) for x in (bsdf, truth)), rtol=rtol)
    return bsdf


@pytest.mark.parametrize("name", VARNISHES)
def test_albedos_agree_with_the_walk(rgb, name):
    """Within 1 %: the walk's noise is half of it."""
    described, axes = VARNISHES[name]
    mesh = square() if name.startswith("vertex") else None  # lives as long as its points
    bsdf = check(described(), 0.01, shape=mesh)
    assert {axis.name for axis in bsdf.latents.baked.axes} == set(axes.split())


SLOW, TWO_WIDTHS = pytest.mark.slow, {"alpha_u": 0.05, "alpha_v": 0.3}
PLASTIC = {"type": "roughplastic", "distribution": "ggx", "alpha": 0.05, "int_ior": 1.9}
PRINCIPLED = {"type": "principled", "clearcoat": 1.0, "clearcoat_gloss": 0.9}


def openpbr(metalness: float, roughness: float) -> dict:
    return {"type": "openpbr", "base_metalness": metalness, "specular_roughness": roughness}


@pytest.mark.parametrize(
    ("bottom", "textured", "coat", "rtol"),
    [
        # Tables err by 2 %, networks by up to 7 %; with a fitted lobe, PLASTIC was 14 % too dark.
        (PRINCIPLED, False, {}, 0.03),
        ({"type": "pplastic", "alpha": 0.1}, True, {"alpha": 0.2}, 0.08),
        (PLASTIC, True, {"alpha": 0.3}, 0.04),
        pytest.param(PLASTIC | {"int_ior": 1.5}, False, {}, 0.03, marks=SLOW),
        pytest.param(openpbr(0.0, 0.15), False, TWO_WIDTHS, 0.08, marks=SLOW),
        pytest.param(openpbr(1.0, 0.1), True, {"alpha": 0.2}, 0.07, marks=SLOW),
        (openpbr(1.0, 0.4), True, {"alpha": 0.2}, 0.07),
        (openpbr(0.5, 0.2), True, {"alpha": 0.2}, 0.07),
        pytest.param(openpbr(0.0, 0.3), True, {"alpha": 0.2}, 0.07, marks=SLOW),
    ],
)
def test_albedos_over_dielectrics_and_metals_agree_with_the_walk(rgb, bottom, textured, coat, rtol):
    """Of a colour, or of two texels; the walk's noise is below 0.5 %."""
    colour = [0.8, 0.35, 0.1]
    value = strip([0.1, 0.6, 0.2], colour, filter_type="nearest")
    value = value if textured else {"type": "rgb", "value": colour}
    key = "diffuse_reflectance" if "plastic" in bottom["type"] else "base_color"
    check({"base": bottom | {key: value}} | coat, rtol, u=0.75)


@pytest.mark.parametrize("white", [0.97, strip(0.85, 1.0)], ids=["constant", "textured"])
def test_bottoms_that_gain_energy_are_taken_as_they_are(rgb, white):
    """White `principled` reflects 1.2; with albedos of at most 1, coats were 13 % too dark."""
    check({"base": {"type": "principled", "roughness": 0.5, "base_color": white}}, 0.01)


@pytest.mark.parametrize("name", ("layered", "neural_layered"))
def test_mesh_attributes_and_volumes_of_one_value(rgb, name):
    """The walks are the same, except for a few that rounding sends another way; codes lack 1 %."""
    mesh, wo = square(), rgb.Vector3f(0.6, 0, 0.8)  # the mesh lives as long as its points
    si = interactions(mesh)
    grid = rgb.VolumeGrid(np.full((2, 2, 2, 1), 0.3, np.float32))
    place = rgb.ScalarTransform4f().translate(-2).scale(4)
    volume = {"type": "gridvolume", "grid": grid, "raw": True, "to_world": place}
    volume, attribute = {"type": "volume", "volume": volume}, {"type": "mesh_attribute"}
    value, index = (attribute | {"name": f"vertex_{x}"} for x in ("value", "index"))

    def mean(value, index=1.3) -> np.ndarray:
        coat = {"type": name, "base": {"type": "diffuse"}, "sigma_t": 1.0, "int_ior": index}
        bsdf = rgb.load_dict(coat | {"alpha": value, "albedo": value})
        return bsdf.eval(rgb.BSDFContext(), si, wo).numpy().mean(axis=1)

    expected = mean(0.3)
    for given in ((value,), (volume,), (0.3, index)):
        np.testing.assert_allclose(mean(*given), expected, rtol=2e-2)


@pytest.mark.parametrize("alpha", [0.1, 0.6])
def test_masks_of_metal_and_rust(rgb, alpha):
    """Within 2 %: codes of coated metals and Lambertians err by one, noise is below one."""
    blend, weights = {"type": "blendbsdf", "metal": SILVER, "rust": RUST}, (0.0, 0.05, 1.0)
    mask = strip(*weights, filter_type="nearest", wrap_mode="clamp")
    coat = {"type": "neural_layered", "alpha": alpha, "int_ior": 1.5}
    bsdf = rgb.load_dict(coat | {"base": blend | {"weight": mask}})
    for place, weight in enumerate(weights):
        walk = rgb.load_dict(coat | {"type": "layered", "base": blend | {"weight": weight}})
        found, expected = (albedo(x, interactions(u=(0.5 + place) / 3)) for x in (bsdf, walk))
        np.testing.assert_allclose(found, expected, rtol=0.02)


@pytest.mark.parametrize(
    ("name", "texels", "coat"),
    [
        ("reflectance", (0.05, 0.9), {}),
        ("sigma_t", (0.0, 5.0), {"base": SILVER}),
        ("albedo", (0.1, 0.98), {"sigma_t": 2.0, "base": RUST}),
    ],
)
def test_half_way_between_two_texels(rgb, name, texels, coat):
    """Within 5 %; the walk has the mean parameter there."""
    row = {name: strip(*texels, wrap_mode="clamp")}
    row = row if coat else {"base": {"type": "diffuse"} | row}
    check(coat | row, 0.05, u=0.5)


def test_the_roughness_of_a_brushed_metal_is_a_texture(rgb):
    """Within 3 %, where its lobe is narrow and changes fast."""
    metal = {"type": "principled", "metallic": 0.9, "anisotropic": 0.7}
    metal["roughness"] = strip(0.1, 0.7, wrap_mode="clamp")
    check({"alpha": 0.05, "base": metal}, 0.03, u=0.3)


def check_f(bsdf, constants: dict, rtol: float):
    """f at places along u is that of a constant coat, in each channel."""
    wi, wo = cosine_pairs(np.random.default_rng(0), 1024, lowest_cosine=0.1)
    for u, constant in constants.items():
        uv = np.tile([u, 0.5], (len(wi), 1))
        found, f = (probing.bsdf_values(x, wi, wo, uv) for x in (bsdf, mi.load_dict(constant)))
        assert (np.abs(found - f).mean(axis=0) < rtol * f.mean(axis=0)).all()


def test_a_product_of_textures_is_largest_between_their_texels(rgb, few_points):
    """A depth of 0 at both texels and of 1 half-way: f is a constant coat's, within 2 %."""
    coat = {"type": "neural_layered", "alpha": 0.3, "albedo": 0.8, "base": {"type": "diffuse"}}
    rows = (strip(*ends, wrap_mode="clamp") for ends in ((0, 2), (2, 0)))
    varying = rgb.load_dict(coat | dict(zip(("sigma_t", "thickness"), rows, strict=True)))
    depths = {0.0: 0.0, 0.5: 1.0, 1.0: 0.0}
    check_f(varying, {u: coat | {"sigma_t": depth} for u, depth in depths.items()}, 0.02)


def test_a_textured_coat_over_what_no_code_represents(rgb):
    """Two sharp Beckmann lobes: f is that of constants, which have tables, within 1 %.

    Codes of the shared functions alone differ by 2 to 5 %.
    """
    lobes = ("Au", 0.03), ("Ag", 0.3)
    metals = {
        name: {"type": "roughconductor", "material": name, "alpha": alpha} for name, alpha in lobes
    }
    coat = {"type": "neural_layered", "base": {"type": "blendbsdf", "weight": 0.5, **metals}}
    ramp = rgb.load_dict(strip(0.02, 0.2, wrap_mode="clamp"))
    widths = {u: float(ramp.eval_1(interactions(u=u))[0]) for u in (0.0, 0.4, 0.8)}
    textured = rgb.load_dict(coat | {"alpha": ramp})
    check_f(textured, {u: coat | {"alpha": alpha} for u, alpha in widths.items()}, 0.01)


@pytest.mark.parametrize(
    ("indices", "widths", "below"),
    [((1.5,), (0.05, 0.4), (0.1, 0.5, 0.3)), ((0.6, 0.95), (0.2,), (0.2,))],
)
def test_kernels_and_numpy_interpolate_alike(rgb, few_points, indices, widths, below):
    """Up to the principal numbers, which stand for the codes."""
    coat = rgb.load_dict(
        {
            "type": "neural_layered",
            "alpha": strip(*widths),
            "ext_ior": 1.0,
            "int_ior": strip(*indices),
            "base": GOLD | {"alpha": strip(*below)},
        }
    )
    latents = coat.latents
    networks = latents.baked.extended.networks
    uv, (wi, wo) = np.random.default_rng(0).random((8, 2)), networks.pairs()
    found = probing.texel_values(coat, wi, wo, uv, probing.Averaging())
    values = {x.axis.name: spectrum.channels_at(uv, x.read) for x in latents.varying}
    codes = np.moveaxis(latents.codes(values), 0, 1)[:, :, None]
    faint = latents.baked.faint * both_ways(codes[..., : networks.arch.lobe], wi, wo)
    f = networks.f(codes, wi, wo) - faint
    measure = networks.basis.measure
    assert ((np.abs(found - f) @ measure) / (f @ measure)).max() < LARGEST_ERROR
