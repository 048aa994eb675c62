"""After a change through `mi.traverse`, only rows that changed are encoded and layered."""

import numpy as np
import pytest

from urushi.checks import CoatParameters
from urushi.errors import ParameterError
from urushi.material.layer import layer_texels
from urushi.mitsuba.latents import baking
from urushi.mitsuba.latents.bottoms import white_code
from urushi.nets import weights
from urushi.nets.networks import Networks

SIDE = 16


def by_network(model, rows):
    """Codes of rows (see `layer_rows`), by the network alone."""
    z, columns = rows[:, : model.arch.latent], rows[:, model.arch.latent :]
    return layer_texels(model, z, CoatParameters.of_columns([*columns.T]))


@pytest.fixture
def rows(monkeypatch, networks):
    """A function that returns the number of rows that were encoded and layered."""
    white_code(weights.find(networks))  # once per model
    monkeypatch.setattr(baking, "layer_rows", by_network)  # light transport layers no texels
    counts = {"encode": 0, "layer": 0}
    encode, scaled, layer = (getattr(Networks, x) for x in ("encode", "rest_scaled", "layer"))

    def counted_encode(self, f, lobe=None):
        counts["encode"] += f[..., 0].size
        return encode(self, f, lobe)

    def counted_scaled(self, z, factor):  # codes of Lambertian surfaces
        counts["encode"] += z[..., 0].size
        return scaled(self, z, factor)

    def counted_layer(self, z, coat):
        result = layer(self, z, coat)
        counts["layer"] += result[..., 0].size
        return result

    monkeypatch.setattr(Networks, "encode", counted_encode)
    monkeypatch.setattr(Networks, "rest_scaled", counted_scaled)
    monkeypatch.setattr(Networks, "layer", counted_layer)

    def since() -> tuple[int, int]:
        """Rows encoded and layered since the last call."""
        result = counts["encode"], counts["layer"]
        counts.update(encode=0, layer=0)
        return result

    return since


def bitmap(mi, pixels, **properties) -> dict:
    pixels = np.asarray(pixels, np.float32)
    return {"type": "bitmap", "bitmap": mi.Bitmap(pixels), "raw": True, **properties}


def noise(channels: int, seed: int = 0) -> np.ndarray:
    """Numbers that are all different."""
    numbers = np.linspace(0.1, 0.9, SIDE * SIDE * channels)
    return np.random.default_rng(seed).permutation(numbers).reshape(SIDE, SIDE, channels)


def described(mi, networks, **properties) -> dict:
    return {
        "type": "neural_layered",
        "weights": str(networks),
        "alpha": 0.2,
        "albedo": bitmap(mi, noise(3)),
        "sigma_t": 0.8,
        "base": {"type": "diffuse", "reflectance": bitmap(mi, noise(3, 1))},
        **properties,
    }


def codes(bsdf) -> np.ndarray:
    """Codes at points that cover uv."""
    return bsdf.latents.at(np.random.default_rng(3).random((512, 2)))


def close(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether codes are equal up to the rounding of their packing."""
    return np.abs(a - b).max() <= np.ptp(b) / 100


def test_each_texel_is_encoded_and_layered_once(rgb, networks, rows):
    rgb.load_dict(described(rgb, networks))
    assert rows() == (3 * SIDE**2, 3 * SIDE**2)


def test_equal_texels_are_encoded_and_layered_once(rgb, networks, rows):
    two = np.repeat(np.arange(2), SIDE // 2)
    pixels = np.stack([two[:, None] * np.ones(SIDE)] * 3, -1) * [0.2, 0.2, 0.4] + 0.3
    base = {"type": "diffuse", "reflectance": bitmap(rgb, pixels)}
    rgb.load_dict(described(rgb, networks, albedo=0.5, base=base))
    assert rows() == (3, 3)  # the reflectances 0.3, 0.5 and 0.7


def test_a_changed_coat_does_not_encode_the_bottom_again(rgb, networks, rows):
    bsdf = rgb.load_dict(described(rgb, networks))
    rows()
    parameters = rgb.traverse(bsdf)
    parameters["sigma_t.value"] = 2.0
    parameters.update()
    assert rows() == (0, 3 * SIDE**2)
    fresh = rgb.load_dict(described(rgb, networks, sigma_t=2.0))
    assert close(codes(bsdf), codes(fresh))


def test_only_changed_texels_are_layered(rgb, networks, rows):
    bsdf = rgb.load_dict(described(rgb, networks))
    rows()
    parameters = rgb.traverse(bsdf)
    pixels = noise(3).astype(np.float32)
    pixels[2:5, 7:9] = 0.35
    parameters["albedo.data"] = rgb.TensorXf(pixels)
    parameters.update()
    assert rows() == (0, 3 * 6)  # colours of the bottom differ: no two texels are alike
    pixels[:, :, 1] += 0.05
    parameters["albedo.data"] = rgb.TensorXf(pixels)
    parameters.update()
    assert rows() == (0, 3 * SIDE**2)  # all channels of the changed texels
    fresh = rgb.load_dict(described(rgb, networks, albedo=bitmap(rgb, pixels)))
    assert close(codes(bsdf), codes(fresh))


def test_only_changed_texels_of_the_bottom_are_encoded(rgb, networks, rows):
    bsdf = rgb.load_dict(described(rgb, networks))
    rows()
    parameters = rgb.traverse(bsdf)
    pixels = noise(3, 1).astype(np.float32)
    pixels[3, 4:9] = noise(3, 2)[3, 4:9]
    parameters["bottom.reflectance.data"] = rgb.TensorXf(pixels)
    parameters.update()
    assert rows() == (15, 15)
    base = {"type": "diffuse", "reflectance": bitmap(rgb, pixels)}
    fresh = rgb.load_dict(described(rgb, networks, base=base))
    assert close(codes(bsdf), codes(fresh))


def test_an_update_without_changes_evaluates_nothing(rgb, networks, rows):
    bsdf = rgb.load_dict(described(rgb, networks))
    rows()
    parameters = rgb.traverse(bsdf)
    for key in ("albedo.data", "bottom.reflectance.data"):
        parameters[key] = rgb.TensorXf(parameters[key])
    parameters.update()
    assert rows() == (0, 0)


def test_a_constant_of_a_textured_bottom(rgb, networks, rows):
    base = {"type": "roughconductor", "alpha": bitmap(rgb, noise(1)), "distribution": "beckmann"}
    bsdf = rgb.load_dict(described(rgb, networks, base=base))
    rows()
    parameters = rgb.traverse(bsdf)
    parameters["bottom.eta.value"] = 0.5
    parameters.update()
    encoded, layered = rows()  # grey: its channels are alike, but some lobes are encoded twice
    assert SIDE**2 <= encoded < 2 * SIDE**2 and layered == 3 * SIDE**2
    fresh = rgb.load_dict(described(rgb, networks, base=base | {"eta": 0.5, "k": 1.0}))
    assert close(codes(bsdf), codes(fresh))


def test_a_constant_bottom_is_encoded_once(rgb, networks, rows):
    constants = {"albedo": 0.5, "base": {"type": "diffuse", "reflectance": 0.5}}
    bsdf = rgb.load_dict(described(rgb, networks, **constants))
    assert rows()[0] > 0
    parameters = rgb.traverse(bsdf)
    parameters["sigma_t.value"] = 0.4
    parameters.update()
    assert rows() == (3, 0)  # of the coat, by light transport


def test_a_change_of_a_nested_coat(rgb, networks, rows):
    inner = described(rgb, networks)
    outer = {"type": "neural_layered", "weights": str(networks), "alpha": 0.1, "inner": inner}
    bsdf = rgb.load_dict(outer)
    rows()
    parameters = rgb.traverse(bsdf)
    pixels = noise(3).astype(np.float32)
    pixels[0, 0] = 0.5
    parameters["bottom.albedo.data"] = rgb.TensorXf(pixels)
    parameters.update()
    assert rows() == (0, 9)  # three rows of the inner coat in air and below the outer, and of this
    fresh = rgb.load_dict(outer | {"inner": inner | {"albedo": bitmap(rgb, pixels)}})
    assert close(codes(bsdf), codes(fresh))


def test_a_change_out_of_range_can_be_taken_back(rgb, networks):
    bsdf = rgb.load_dict(described(rgb, networks))
    before = codes(bsdf)
    parameters = rgb.traverse(bsdf)
    good = noise(3).astype(np.float32)
    parameters["albedo.data"] = rgb.TensorXf(good + 1)
    with pytest.raises(ParameterError, match="albedo is .*; it must be"):
        parameters.update()
    parameters["albedo.data"] = rgb.TensorXf(good)
    parameters.update()
    np.testing.assert_array_equal(codes(bsdf), before)


@pytest.mark.slow
def test_a_texture_that_becomes_larger_is_baked_larger(rgb, networks):
    bsdf = rgb.load_dict(described(rgb, networks))
    parameters = rgb.traverse(bsdf)
    pixels = np.repeat(np.repeat(noise(3), 2, axis=0), 2, axis=1).astype(np.float32)
    parameters["albedo.data"] = rgb.TensorXf(pixels)
    parameters.update()
    assert bsdf.latents.grid[:2] == (2 * SIDE, 2 * SIDE)
    fresh = rgb.load_dict(described(rgb, networks, albedo=bitmap(rgb, pixels)))
    np.testing.assert_allclose(codes(bsdf), codes(fresh), rtol=1e-3, atol=1e-3)
