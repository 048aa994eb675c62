"""Textured parameters and textured bottoms."""

import re

import numpy as np
import pytest

from urushi.checks import CoatParameters
from urushi.core.appearance import LOOK
from urushi.core.directions import rotated
from urushi.errors import UrushiWarning
from urushi.material.energy import limit_albedo
from urushi.material.layer import layer_material
from urushi.material.material import Material
from urushi.material.values import codes_of

COAT = {"alpha": 0.2, "albedo": 0.7, "sigma_t": 0.8, "g": 0.3}
COAT_ARRAYS = {key: np.full((1, 1), value) for key, value in COAT.items()}


def bitmap(mi, pixels, **properties) -> dict:
    return {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.asarray(pixels, np.float32)),
        "raw": True,
        **properties,
    }


def nearly_uniform(shape, value) -> np.ndarray:
    """Pixels that differ by less than codes resolve, since a bitmap of one value is a constant."""
    pixels = np.full(shape, value)
    pixels[0, 0] *= 1 + 1e-6
    return pixels


def uniform(mi, name: str, value: float):
    """A parameter that is the same everywhere; a texture of codes, for codes are not a table."""
    return value if name == "layered" else bitmap(mi, nearly_uniform((2, 2, 1), value))


def load(mi, name, networks, **properties):
    extra = {} if name == "layered" else {"weights": str(networks)}
    base = {"type": "diffuse", "reflectance": 0.5}
    coat = COAT if not LOOK.keys() & properties.keys() else {"alpha": 0.2, "g": 0.3, "body": 0.5}
    return mi.load_dict({"type": name, "base": base, **extra, **coat, **properties})


def mean_and_error(mi, bsdf, uv, count: int = 1 << 14) -> tuple[np.ndarray, np.ndarray]:
    """f cos averaged over directions, at points around uv, and its standard error."""
    from urushi.mitsuba.reading import probing

    rng = np.random.default_rng(0)
    w = rng.normal(size=(2, count, 3))
    w[..., 2] = np.abs(w[..., 2]) + 0.2
    wi, wo = (w / np.linalg.norm(w, axis=-1, keepdims=True)).astype(np.float32)
    si = probing.interaction(wi, np.broadcast_to(np.float32(uv), (count, 2)))
    value = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(np.ascontiguousarray(wo.T))).numpy()
    return value.mean(axis=1), value.std(axis=1) / count**0.5


@pytest.mark.parametrize("name", ("layered", "neural_layered"))
@pytest.mark.parametrize(
    "parameter",
    ("alpha", "albedo", "sigma_t", "g", "int_ior", "thickness", "color", "body", "body_color"),
)
def test_every_texel_is_layered_with_its_own_parameters(rgb, networks, name, parameter):
    values = np.float32([[0.2, 0.4, 0.6], [0.5, 0.8, 0.3]]) + (parameter == "int_ior")
    textured = load(
        rgb, name, networks, **{parameter: bitmap(rgb, values[..., None], filter_type="nearest")}
    )
    for row in range(2):
        for column in range(3):
            # Mitsuba's bitmaps have v upwards: the first row is at the top
            uv = ((column + 0.5) / 3, (row + 0.5) / 2)
            si = rgb.SurfaceInteraction3f()
            si.uv = rgb.Point2f(*uv)
            texture = rgb.load_dict(bitmap(rgb, values[..., None], filter_type="nearest"))
            value = float(texture.eval_1(si)[0])
            constant = load(rgb, name, networks, **{parameter: uniform(rgb, name, value)})
            (a, error_a), (b, error_b) = (
                mean_and_error(rgb, bsdf, uv, 1 << 12) for bsdf in (constant, textured)
            )
            noise = 5 * np.hypot(error_a, error_b) if name == "layered" else 1e-2 * a
            assert (np.abs(a - b) <= noise).all(), (row, column)


@pytest.mark.parametrize("name", ("layered", "neural_layered"))
def test_dark_texels_of_a_width_are_the_least_width(rgb, networks, name):
    """A roughness map may have black texels; the constant 0 and texels above 1 are refused."""
    dark = np.float32([[0.0, 0.3]])
    black, least = (
        mean_and_error(rgb, load(rgb, name, networks, alpha=bitmap(rgb, x[..., None])), (0.25, 0.5))
        for x in (dark, np.maximum(dark, 0.01))
    )
    np.testing.assert_array_equal(black[0], least[0])
    with pytest.raises(RuntimeError, match="alpha is 0; it must be"):
        load(rgb, name, networks, alpha=0.0)
    with pytest.raises(RuntimeError, match="a texel of alpha is 1.3; it must be"):
        load(rgb, name, networks, alpha=bitmap(rgb, dark[..., None] + 1))


def test_a_textured_bottom(rgb):
    pixels = np.float32([[[0.1, 0.5, 0.9], [0.8, 0.2, 0.4]]] * 2)
    textured = load(
        rgb,
        "neural_layered",
        "default",
        base={"type": "diffuse", "reflectance": bitmap(rgb, pixels)},
    )
    assert textured.latents.grid[:2] == (2, 2)
    for column in range(2):
        base = {"type": "diffuse", "reflectance": {"type": "rgb", "value": pixels[0, column]}}
        constant = load(rgb, "neural_layered", "default", base=base)
        (a, _), (b, _) = (
            mean_and_error(rgb, bsdf, ((column + 0.5) / 2, 0.5), 4096)
            for bsdf in (constant, textured)
        )
        np.testing.assert_allclose(a, b, rtol=1e-2)


def test_a_coat_over_a_textured_plastic_is_the_walk(rgb):
    """Within 4 %, by the lobe of the plastic's parameters; by a fitted one it was 14 % too dark."""
    data = np.array([[[0.05, 0.1, 0.3], [0.3, 0.1, 0.05]]])
    color = bitmap(rgb, data, filter_type="nearest")
    plastic = {"type": "roughplastic", "distribution": "ggx", "alpha": 0.05, "int_ior": 1.9}
    plastic["diffuse_reflectance"] = color
    (found, _), (expected, error) = (
        mean_and_error(
            rgb, rgb.load_dict({"type": name, "alpha": 0.3, "base": plastic}), (0.25, 0.5)
        )
        for name in ("neural_layered", "layered")
    )
    assert (np.abs(found - expected) < 0.04 * expected + 4 * error).all()


@pytest.mark.parametrize("textured", (False, True))
def test_isotropic_networks_take_the_mean_of_a_brushed_bottom(rgb, textured):
    from urushi.mitsuba.reading import probing
    from urushi.nets import weights

    model = weights.default_model()
    wi, wo = model.networks.pairs()
    # only a few azimuths contribute to the light in a narrow lobe
    widths = {"alpha_u": 0.03, "alpha_v": 0.5}
    if textured:
        widths = {
            key: bitmap(rgb, nearly_uniform((2, 2, 1), value)) for key, value in widths.items()
        }
    brushed = rgb.load_dict({"type": "roughconductor", "distribution": "ggx", **widths})
    turns = np.random.default_rng(0).random(2048)
    f = np.zeros((len(wi), 3))
    for a, b in ((wi, wo), (wo, wi)):
        a, b = (np.concatenate([rotated(w, turn) for turn in turns]) for w in (a, b))
        values = probing.bsdf_values(brushed, a, b, np.full((len(a), 2), 0.5))
        f += values.reshape(len(turns), *f.shape).mean(axis=0) / 2
    coat = {"type": "neural_layered", "weights": "default", **COAT}
    latents = rgb.load_dict(coat | {"bottom": brushed}).latents
    columns = CoatParameters(eta=np.full((1, 1), 1.5046 / 1.000277), **COAT_ARRAYS).columns()
    under = Material(limit_albedo(model, codes_of(model, f.T.astype(np.float32))), model)
    expected = layer_material(CoatParameters.of_columns([x[0] for x in columns]), under)
    found = Material(latents.at(np.full((1, 2), 0.5))[0], model) if textured else latents.material
    a, b = (material.f(wi, wo) * (wi[:, 2:] * wo[:, 2:]) for material in (found, expected))
    # 2,048 random azimuths are an error of about 3 %, and the constant bottom has a table.
    assert np.abs(a - b).sum() < 0.05 * b.sum()


@pytest.mark.slow
def test_isotropic_networks_take_the_mean_of_a_textured_openpbr_base_of_two_widths(rgb):
    # Its lobe is known, and has a width more than the code of these networks.
    colour = [0.8, 0.5, 0.2]
    described = {
        "type": "openpbr",
        "weights": "default",
        "base_metalness": 1.0,
        "specular_roughness": 0.4,
        "specular_roughness_anisotropy": 0.6,
        "coat_weight": 1.0,
    }
    values = [
        mean_and_error(rgb, rgb.load_dict(described | {"base_color": of_base}), (0.5, 0.5))[0]
        for of_base in (
            {"type": "rgb", "value": colour},
            bitmap(rgb, nearly_uniform((2, 2, 3), colour)),
        )
    ]
    # Azimuths of all averages are random, and a texture's codes have 8 bits.
    np.testing.assert_allclose(*values, rtol=0.04)


#: Look-ups of a point from random directions. Each draws a texel; the standard error of the mean is
#: at most half of the texels' range over the root of this.
DRAWS = 1024


def looked_up(mi, bsdf, uv, draws: int = 1) -> np.ndarray:
    """Codes (M, C, size) at points (M, 2), the mean of draws."""

    from urushi.mitsuba.networks.basis import FUNCTION_SCALE

    wi = np.random.default_rng(0).random((3, len(uv) * draws), np.float32)
    point = mi.Point2f(np.repeat(np.float32(uv), draws, axis=0).T)
    codes = bsdf.latents._texture.look_up(point, mi.Vector3f(wi))
    # numbers that are the same everywhere have one entry
    rows = [[np.broadcast_to(value.numpy(), len(uv) * draws) for value in z] for z in codes]
    means = np.array(rows).reshape(*np.shape(rows)[:2], len(uv), draws).mean(-1).transpose(2, 0, 1)
    principal = bsdf.latents._principal
    if principal is None:
        return means
    means[..., principal.first + 1 :] /= FUNCTION_SCALE
    return principal.codes(means)


def grid_of_points(width: int, height: int) -> np.ndarray:
    x, y = (np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height
    return np.stack(np.meshgrid(x, y), -1).reshape(-1, 2)


@pytest.mark.parametrize(
    ("filter_type", "wrap"),
    [
        ("bilinear", "repeat"),
        ("nearest", "mirror"),
        ("bilinear", "clamp"),
    ],
)
def test_look_ups_wrap_and_filter_like_the_texture(rgb, networks, wrap, filter_type):
    # Codes of black media depend only on the texel's sigma_t. The reference is Mitsuba's texture of
    # the stored codes.
    rng = np.random.default_rng(0)
    properties = {"wrap_mode": wrap, "filter_type": filter_type}
    shear = rgb.ScalarTransform3f(np.float32([[1.5, 0.25, 0.1], [-0.5, 2.2, 0.3], [0, 0, 1]]))
    pixels = rng.random((4, 6, 1))
    texture = bitmap(rgb, pixels, to_uv=shear, **properties)
    bsdf = load(rgb, "neural_layered", networks, sigma_t=texture)
    assert bsdf.latents.grid[:2] == (6, 4)
    plain = load(rgb, "neural_layered", networks, sigma_t=bitmap(rgb, pixels, **properties))
    stored = looked_up(rgb, plain, grid_of_points(6, 4)).reshape(4, 6, 3, -1)
    uv = rng.uniform(-2, 3, (256, 2))
    codes = looked_up(rgb, bsdf, uv, draws=DRAWS)
    si = rgb.SurfaceInteraction3f()
    si.uv = rgb.Point2f(np.float32(uv).T)
    for number in range(0, stored.shape[-1], 7):
        expected = rgb.load_dict(
            bitmap(rgb, stored[:, :, :, number], to_uv=shear, **properties)
        ).eval_3(si)
        # Four standard errors of the draws, and weights of 8 bits.
        error = np.abs(codes[:, :, number] - np.array(expected).T)
        tolerance = (4 * 0.5 / DRAWS**0.5 + 1e-2) * np.ptp(stored[..., number]) + 1e-5
        assert (error <= tolerance).all()


@pytest.mark.parametrize("differentiable", (False, True))
@pytest.mark.parametrize(
    ("parameters", "texels"),
    [
        ({"base": "reflectance"}, (0.02, 0.9)),
        pytest.param({"sigma_t": "sigma_t", "albedo": 0.0}, (0.0, 7.9), marks=pytest.mark.slow),
    ],
)
def test_f_is_filtered_not_the_code(rgb, parameters, texels, differentiable):
    """Halfway between two texels, f is the mean of both, and eval, pdf and sample agree."""
    import drjit as dr

    from urushi.mitsuba.reading import probing

    def coat(value):
        base = {"type": "diffuse"}
        described = {"type": "neural_layered", "weights": "default", "alpha": 0.2, **parameters}
        if "base" in parameters:
            base["reflectance"] = value
        else:
            base = {"type": "roughconductor", "material": "Au", "alpha": 0.3, "distribution": "ggx"}
            described["sigma_t"] = value
        return rgb.load_dict(described | {"base": base})

    count = 1 << 14
    wi, wo, u = rgb.Vector3f(0.6, 0, 0.8), rgb.Vector3f(0, 0.28, 0.96), 0.01
    ends = [coat(uniform(rgb, "neural_layered", value)) for value in texels]
    textured = coat(bitmap(rgb, np.float32(texels)[None, :, None]))
    if differentiable:
        parameters = rgb.traverse(textured)
        key = next(key for key, _ in parameters if key.endswith("data"))
        dr.enable_grad(parameters[key])
        parameters.update()
    # Positions halfway between both texels, within a hundredth of their distance.
    x = np.random.default_rng(0).uniform(0.5 - u / 4, 0.5 + u / 4, count)
    si = probing.interaction(np.tile(np.array(wi).T, (count, 1)), np.stack([x, 0 * x + 0.5], -1))
    context = rgb.BSDFContext()
    at_ends = [bsdf.eval(context, si, wo).numpy()[:, 0] for bsdf in ends]
    value, pdf = (part.numpy() for part in textured.eval_pdf(context, si, wo))
    # Bernoulli noise of the draws, 8 bits of a code's range
    noise = 4 * 0.5 * np.abs(at_ends[0] - at_ends[1]) / count**0.5
    mean = 0.5 * (at_ends[0] + at_ends[1])
    assert (np.abs(value.mean(axis=1) - mean) <= noise + 0.01 * mean).all()
    np.testing.assert_allclose(textured.pdf(context, si, wo).numpy(), pdf, rtol=1e-4)
    sample, weight = textured.sample(context, si, 0.5, rgb.Point2f(0.3, 0.6))
    again, pdf = textured.eval_pdf(context, si, sample.wo)
    np.testing.assert_allclose(pdf.numpy(), sample.pdf.numpy(), rtol=1e-3)
    np.testing.assert_allclose((again / pdf).numpy(), weight.numpy(), rtol=1e-3)


def test_a_checkerboard_stays_sharp(rgb, networks):
    turned = rgb.ScalarTransform3f(np.float32([[3, 1, 0.2], [-1, 2, 0.1], [0, 0, 1]]))
    board = {"type": "checkerboard", "color0": 0.2, "color1": 0.9, "to_uv": turned}
    bsdf = load(rgb, "neural_layered", networks, albedo=board)
    uv = np.random.default_rng(0).uniform(-2, 2, (4096, 2)).astype(np.float32)
    # Rounding moves points across an edge of a field, which is half of the pattern's period.
    fields = 2 * (np.array(turned.matrix) @ np.c_[uv, np.ones(len(uv))].T)[:2]
    uv = uv[(np.abs(fields - np.round(fields)) > 1e-4).all(axis=0)]
    si = rgb.SurfaceInteraction3f()
    si.uv = rgb.Point2f(uv.T)
    values = rgb.load_dict(board).eval(si)[0].numpy()
    codes = looked_up(rgb, bsdf, uv)
    for value in (0.2, 0.9):
        found = codes[np.isclose(values, value)]
        assert len(found) > 1000
        assert (found == np.median(found, axis=0)).all()
        texture = uniform(rgb, "neural_layered", value)
        constant = load(rgb, "neural_layered", networks, albedo=texture).latents.at(
            np.zeros((1, 2))
        )
        step = 1e-2 * np.ptp(codes, axis=0) + 1e-3  # of storing 8 bits
        assert (np.abs(np.median(found, axis=0) - constant[0]) <= step).all()


def test_the_walk_takes_mesh_attributes_and_volumes(rgb):
    mesh = rgb.Mesh("triangle", 3, 1)
    parameters = rgb.traverse(mesh)
    parameters["vertex_positions"] = [-3, -3, 0, 3, -3, 0, 0, 3, 0]
    parameters["faces"] = [0, 1, 2]
    parameters.update()
    mesh.add_attribute("vertex_value", 1, np.float32([0.3, 0.3, 0.3]))
    scene = rgb.load_dict({"type": "scene", "mesh": mesh})
    u = np.random.default_rng(0).uniform(-1, 1, (2, 1 << 14)).astype(np.float32)
    si = scene.ray_intersect(rgb.Ray3f(rgb.Point3f(*u, 1), rgb.Vector3f(0, 0, -1)))
    place = rgb.ScalarTransform4f().translate(-2).scale(4)
    grid = rgb.VolumeGrid(np.full((2, 2, 2, 1), 0.3, np.float32))
    volume = {"type": "gridvolume", "grid": grid, "raw": True, "to_world": place}
    wo = rgb.Vector3f(0.6, 0, 0.8)

    def mean(value) -> np.ndarray:
        coat = {"type": "layered", "base": {"type": "diffuse"}, "sigma_t": 1.0}
        bsdf = rgb.load_dict(coat | {"alpha": value, "albedo": value})
        return bsdf.eval(rgb.BSDFContext(), si, wo).numpy().mean(axis=1)

    # The walks are the same, except for a few that rounding sends another way.
    attribute = {"type": "mesh_attribute", "name": "vertex_value"}
    np.testing.assert_allclose(mean(attribute), mean(0.3), rtol=1e-2)
    np.testing.assert_allclose(mean({"type": "volume", "volume": volume}), mean(0.3), rtol=1e-2)


@pytest.mark.parametrize(
    ("properties", "resolution"),
    [
        ({}, None),
        ({"albedo": "5x3"}, (5, 3)),
        ({"albedo": "5x3", "alpha": "procedural"}, (256, 256)),
        ({"albedo": "5x3 twice"}, (5, 3)),
        ({"albedo": "5x3 twice", "alpha": "5x3"}, (10, 6)),
        ({"albedo": "procedural", "resolution": 32}, (32, 32)),
        ({"resolution": 32}, None),
        ({"albedo": "one value", "resolution": 32}, None),
    ],
)
def test_the_resolution_follows_the_textures(rgb, networks, properties, resolution):
    pixels = nearly_uniform((3, 5, 1), 0.5)
    textures = {
        "5x3": bitmap(rgb, pixels),
        "5x3 twice": bitmap(rgb, pixels, to_uv=rgb.ScalarTransform3f().scale([2, 2])),
        "procedural": {"type": "checkerboard"},
        "one value": bitmap(rgb, np.full((3, 5, 1), 0.5)),
    }
    chosen = {
        key: textures[value] if isinstance(value, str) else value
        for key, value in properties.items()
    }
    grid = load(rgb, "neural_layered", networks, **chosen).latents.grid
    assert (grid and grid[:2]) == resolution


@pytest.mark.slow
def test_a_texture_outside_the_training_data_warns_once(rgb):
    """Not for every texel. A constant coat has a table by light transport, without a warning."""
    depth = bitmap(rgb, np.linspace(1, 20, 16).reshape(4, 4, 1))
    coat = {"type": "neural_layered", "albedo": 1.0, "g": 0.95, "bottom": {"type": "diffuse"}}
    with pytest.warns(UrushiWarning) as caught:
        rgb.load_dict({**coat, "sigma_t": depth})
    (warning,) = caught
    sentence = r"^neural_layered: g is outside \[-0.8, 0.9\] and sigma_t is above 8"
    assert re.match(sentence, str(warning.message))
    assert rgb.load_dict({**coat, "sigma_t": 20.0}).latents.material.table is not None
