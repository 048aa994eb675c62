"""After a change through `mi.traverse`, only rows that changed are encoded and layered."""

import drjit as dr
import numpy as np
import pytest

from urushi.checks import CoatParameters
from urushi.errors import ParameterError
from urushi.material.layer import layer_texels
from urushi.mitsuba.latents import baking
from urushi.mitsuba.latents.bottoms import white_code
from urushi.nets import weights
from urushi.nets.networks import Networks
from urushi.textures import cache

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


@pytest.mark.parametrize("kind", ["diffuse", pytest.param("probed", marks=pytest.mark.slow)])
def test_a_texture_that_was_baked_before_is_read_from_the_disk(
    rgb, networks, rows, tmp_path, monkeypatch, kind
):
    monkeypatch.setenv("URUSHI_CACHE", str(tmp_path / "cache"))
    base = {"type": "diffuse", "reflectance": bitmap(rgb, noise(3, 1))}
    if kind == "probed":
        base = {
            "type": "roughconductor",
            "alpha": bitmap(rgb, noise(1)),
            "distribution": "beckmann",
        }
    properties = described(rgb, networks, base=base)
    baked = codes(rgb.load_dict(properties))
    assert min(rows()) > 0
    again = rgb.load_dict(properties)
    assert rows() == (0, 0)
    np.testing.assert_array_equal(codes(again), baked)
    # One texel of the coat or of the bottom, or another property, is another texture.
    pixels = noise(3).astype(np.float32)
    pixels[2, 3, 1] += 0.01
    parameters = rgb.traverse(again)
    parameters["albedo.data"] = rgb.TensorXf(pixels)
    parameters.update()
    edited = rgb.load_dict(properties | {"albedo": bitmap(rgb, pixels)})
    assert rows()[1] >= 3 * SIDE**2
    assert close(codes(again), codes(edited))
    below = noise(1 if kind == "probed" else 3, 1).astype(np.float32)
    below[7, 7] *= 0.99
    changed = {**base, "alpha" if kind == "probed" else "reflectance": bitmap(rgb, below)}
    for other in ({"base": changed}, {"alpha": 0.21}):
        rgb.load_dict(properties | other)
        assert rows()[1] >= 3 * SIDE**2
    # A damaged file is baked again and replaced.
    files = sorted((tmp_path / "cache").iterdir(), key=lambda path: path.stat().st_mtime_ns)
    for damage in (lambda content: content[:200], lambda content: content[:-9] + b"x" * 9):
        for path in files:
            path.write_bytes(damage(path.read_bytes()))
        np.testing.assert_array_equal(codes(rgb.load_dict(properties)), baked)
        assert rows()[1] > 0
        rgb.load_dict(properties)
        assert rows() == (0, 0)
    # Files beyond the limit are removed, the oldest first.
    monkeypatch.setattr(cache, "LIMIT", 1)
    rgb.load_dict(properties | {"alpha": 0.22})
    assert not list((tmp_path / "cache").iterdir())
    # A folder that cannot be written is not used.
    (tmp_path / "file").touch()
    monkeypatch.setenv("URUSHI_CACHE", str(tmp_path / "file"))
    rgb.load_dict(properties | {"alpha": 0.22})


def test_the_key_of_a_texture_knows_what_the_probes_read(
    rgb, networks, rows, tmp_path, monkeypatch
):
    """A change of a bottom at grazing angles alone, which `mi.traverse` does not list, is seen."""
    monkeypatch.setenv("URUSHI_CACHE", str(tmp_path))

    class Grazing(rgb.BSDF):
        def __init__(self, props):
            super().__init__(props)
            self._color, self._shine = props["color"], props["shine"]
            self.m_flags = rgb.BSDFFlags.GlossyReflection | rgb.BSDFFlags.FrontSide
            self.m_components = [self.m_flags]

        def eval(self, ctx, si, wo, active=True):
            shine = dr.select(si.wi.z * wo.z < 0.02, self._shine, 0.0)
            return (self._color.eval(si) / dr.pi + shine) * wo.z

        def traverse(self, callback):
            callback.put("color", self._color, rgb.ParamFlags.Differentiable)

    rgb.register_bsdf("grazing", Grazing)
    color = bitmap(rgb, noise(3))
    for shine, baked in ((0.1, True), (0.1, False), (0.2, True)):
        base = {"type": "grazing", "color": color, "shine": shine}
        rgb.load_dict(described(rgb, networks, base=base))
        assert (rows()[1] > 0) == baked
