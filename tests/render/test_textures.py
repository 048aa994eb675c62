"""Textured parameters and textured bottoms."""

import numpy as np
import pytest

COAT = {"alpha": 0.2, "albedo": 0.7, "sigma_t": 0.8, "g": 0.3}


def bitmap(mi, pixels, **properties) -> dict:
    return {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.asarray(pixels, np.float32)),
        "raw": True,
        **properties,
    }


def load(mi, name, networks, **properties):
    extra = {} if name == "layered" else {"weights": str(networks)}
    base = {"type": "diffuse", "reflectance": 0.5}
    return mi.load_dict({"type": name, "base": base, **extra, **COAT, **properties})


def mean_and_error(mi, bsdf, uv, count: int = 1 << 14) -> tuple[np.ndarray, np.ndarray]:
    """f cos averaged over directions, at points around uv, and its standard error."""
    from urushi.render import probing

    rng = np.random.default_rng(0)
    w = rng.normal(size=(2, count, 3))
    w[..., 2] = np.abs(w[..., 2]) + 0.2
    wi, wo = (w / np.linalg.norm(w, axis=-1, keepdims=True)).astype(np.float32)
    si = probing.interaction(wi, np.broadcast_to(np.float32(uv), (count, 2)))
    value = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(np.ascontiguousarray(wo.T))).numpy()
    return value.mean(axis=1), value.std(axis=1) / count**0.5


@pytest.mark.parametrize("name", ("layered", "neural_layered"))
def test_a_constant_texture_is_the_constant(rgb, networks, name):
    constant = load(rgb, name, networks)
    textured = load(
        rgb, name, networks, **{key: bitmap(rgb, np.full((4, 4, 1), v)) for key, v in COAT.items()}
    )
    (a, error_a), (b, error_b) = (
        mean_and_error(rgb, bsdf, (0.3, 0.7)) for bsdf in (constant, textured)
    )
    # noise of two walks; half precision of latents
    noise = 4 * np.hypot(error_a, error_b) if name == "layered" else 1e-2 * a
    assert (np.abs(a - b) <= noise).all()


@pytest.mark.parametrize("name", ("layered", "neural_layered"))
@pytest.mark.parametrize("parameter", ("alpha", "albedo", "sigma_t"))
def test_every_texel_is_layered_with_its_own_values(rgb, networks, name, parameter):
    values = np.float32([[0.2, 0.4, 0.6], [0.5, 0.9, 0.3]])
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
            constant = load(rgb, name, networks, **{parameter: value})
            (a, error_a), (b, error_b) = (
                mean_and_error(rgb, bsdf, uv, 1 << 12) for bsdf in (constant, textured)
            )
            noise = 5 * np.hypot(error_a, error_b) if name == "layered" else 1e-2 * a
            assert (np.abs(a - b) <= noise).all(), (row, column)


def test_a_textured_bottom(rgb, networks):
    pixels = np.float32([[[0.1, 0.5, 0.9], [0.8, 0.2, 0.4]]] * 2)
    textured = load(
        rgb,
        "neural_layered",
        networks,
        base={"type": "diffuse", "reflectance": bitmap(rgb, pixels)},
    )
    assert textured.latents.resolution == (2, 2)
    for column in range(2):
        base = {"type": "diffuse", "reflectance": {"type": "rgb", "value": pixels[0, column]}}
        constant = load(rgb, "neural_layered", networks, base=base)
        (a, _), (b, _) = (
            mean_and_error(rgb, bsdf, ((column + 0.5) / 2, 0.5), 4096)
            for bsdf in (constant, textured)
        )
        np.testing.assert_allclose(a, b, rtol=1e-2)


def test_a_textured_coat_under_another(rgb, networks):
    rng = np.random.default_rng(0)
    inner = load(rgb, "neural_layered", networks, albedo=bitmap(rgb, rng.random((4, 4, 3))))
    outer = load(rgb, "neural_layered", networks, base=inner)
    assert outer.latents.resolution == (4, 4)
    assert np.ptp(outer.latents.at(rng.random((16, 2))), axis=0).max() > 0.01


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
    ],
)
def test_the_resolution_follows_the_textures(rgb, networks, properties, resolution):
    pixels = np.full((3, 5, 1), 0.5)
    textures = {
        "5x3": bitmap(rgb, pixels),
        "5x3 twice": bitmap(rgb, pixels, to_uv=rgb.ScalarTransform3f().scale([2, 2])),
        "procedural": {"type": "checkerboard"},
    }
    chosen = {
        key: textures[value] if isinstance(value, str) else value
        for key, value in properties.items()
    }
    assert load(rgb, "neural_layered", networks, **chosen).latents.resolution == resolution
