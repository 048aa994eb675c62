"""Users' mistakes in scenes: each error sentence names the cure."""

import mitsuba as mi
import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, strip

from urushi.errors import ParameterError
from urushi.mitsuba import register
from urushi.openpbr_surface.plugins import PLUGINS

COATS = ("layered", "neural_layered")
COLOUR = {"type": "rgb", "value": [0.1, 2, 0.3]}


def bottom(kind: str = "diffuse", **properties) -> dict:
    return {"type": kind, **properties}


def load(mi, networks, name: str, **properties):
    extra = {} if name == "layered" else {"weights": str(networks)}
    return mi.load_dict({"type": name, "base": bottom(), **extra, **properties})


@pytest.mark.parametrize("name", COATS)
@pytest.mark.parametrize(
    ("properties", "sentence"),
    [
        ({"alpha": 0.009}, "alpha is 0.009; it must be a GGX width in [0.01, 1]"),
        ({"alpha": 1.5}, "alpha is 1.5; it must be a GGX width in [0.01, 1]"),
        ({"alpha": float("nan")}, "alpha is nan; it must be a GGX width in [0.01, 1]"),
        ({"albedo": -0.1}, "albedo is -0.1; it must be a single-scattering albedo in [0, 1]"),
        ({"sigma_t": -1.0}, "sigma_t is -1; it must be an optical depth in [0, 1e6]"),
        ({"g": 1.0}, "g is 1; it must be a Henyey-Greenstein asymmetry in (-1, 1)"),
        ({"color": 1.5}, "color is 1.5; it must be in [0, 1]"),
        ({"body": -1.0}, "body is -1; it must be in [0, 1]"),
        ({"thickness": -0.5}, "thickness is -0.5; it must be zero or more"),
        ({"color": 0.5, "albedo": 0.5}, "color and albedo are both given; give color, body and"),
        ({"thickness": COLOUR}, "thickness must be a number or a texture; all channels share it"),
        ({"rotation": COLOUR}, "rotation must be a number or a texture; all channels share it"),
        ({"int_ior": 4.0}, "int_ior / ext_ior is 3.99889; it must be an index"),
        ({"int_ior": "lacquer"}, "int_ior is 'lacquer'; give a number or one of the materials"),
        ({"ext_ior": 0.0}, "ext_ior is 0; it must be positive"),
        ({"albedo": "red"}, "albedo must be a number, a spectrum or a texture"),
        ({"albedo": COLOUR}, "albedo is 2; it must be a single-scattering albedo in [0, 1]"),
        ({"alpha": 0.1, "alpha_u": 0.2}, "alpha is given together with alpha_u or alph"),
        ({"alpha_u": 0.2}, "alpha_v is missing; alpha_u and alpha_v go together"),
        ({"alpha_u": 0.2, "alpha_v": 0.0}, "alpha_v is 0; it must be a GGX width in [0.01, 1]"),
        ({"rotation": float("inf")}, "rotation is inf; it must be an angle in degrees, finite"),
        ({"rotation": "east"}, "rotation must be a number, a spectrum or a texture"),
        (
            {"base": bottom("layered", rotation=10.0, base=bottom())},
            "the nested coat has its own rotation, but all layers share one",
        ),
        ({"energy_compensation": "false"}, "energy_compensation is 'false'; give true or false"),
        ({"height": 2.0}, "there is no parameter 'height'"),
        ({"other": bottom()}, "has 2 nested BSDFs ('base', 'other'); nest exactly one"),
        ({"base": bottom("conductor")}, "the nested BSDF is perfectly smooth"),
        ({"base": bottom("mask", nested=bottom())}, "the nested BSDF transmits light"),
    ],
)
def test_bad_parameters(rgb, networks, name, properties, sentence):
    with pytest.raises(RuntimeError) as caught:
        load(rgb, networks, name, **properties)
    assert sentence in str(caught.value)


@pytest.mark.parametrize("name", COATS)
def test_an_error_names_the_plugin_and_a_texture_is_checked(rgb, networks, name):
    """By its id, which a user gives in XML."""
    with pytest.raises(RuntimeError, match=f"{name} 'lacquer': alpha is 3;"):
        rgb.load_string(
            f'<bsdf version="3.0.0" type="{name}" id="lacquer"><float name="alpha" value="3"/>'
            '<bsdf type="diffuse"/></bsdf>'
        )
    with pytest.raises(RuntimeError, match=r"albedo is 1.25; it must be"):
        load(rgb, networks, name, albedo=strip(0.5, 1.25, 0.5))


CODES, MEASURED = {"type": "neural_brdf"}, {"type": "measured_brdf"}
COAT, BOARD = {"type": "neural_layered", "base": bottom()}, {"type": "checkerboard"}
SIDES = "; give texels per side, at most 8192"


@pytest.mark.parametrize(
    ("description", "sentence"),
    [
        (
            COAT | {"base": bottom(reflectance={"type": "uniform", "value": -1.0})},
            "the nested BSDF returns a negative or non-finite",
        ),
        (COAT | {"resolution": -1}, "resolution is -1" + SIDES),
        (COAT | {"resolution": 1_000_000}, "resolution is 1000000" + SIDES),
        (COAT | {"resolution": 2.5}, "resolution is 2.5" + SIDES),
        (COAT | {"resolution": "fine"}, "resolution is fine" + SIDES),
        (COAT | {"weights": "none.safetensors"}, "FileError.*none.safetensors"),
        (CODES, "neural_brdf has no filename"),
        (CODES | {"filename": 3}, "neural_brdf: filename is 3; give the path of a file"),
        (CODES | {"filename": "nowhere.safetensors"}, "FileError.*nowhere.safetensors"),
        (MEASURED, "measured_brdf has no filename; give a MERL or RGL"),
        (MEASURED | {"filename": "none.binary"}, "there is no file"),
        ({"type": "layered", "energy_compensation": True}, "needs an opaque bottom; leave it"),
        ({"type": "openpbr", "reference": "yes"}, "reference is 'yes'; choose one of neural_layer"),
        ({"type": "openpbr", "unsupported": "yes"}, 'unsupported is "yes"'),
        ({"type": "openpbr", "emission_luminance": 1.0}, "shape the emitter 'openpbr_emission'"),
        (COAT | {"alhpa": 0.5}, r"neural_layered: .* parameter 'alhpa'; did you mean alpha\?"),
        (COAT | {"intior": BOARD}, r"no parameter 'intior'; did you mean int_ior\?"),
        (COAT | {"roughness": 0.5}, "no parameter 'roughness'; choose one of alpha, albedo"),
        (CODES | {"filenam": BOARD}, r"no parameter 'filenam'; did you mean filename\?"),
        (MEASURED | {"Filename": 0.5}, r"no parameter 'Filename'; did you mean filename\?"),
        ({"type": "openpbr", "base_colour": 0.5}, r"'base_colour'; did you mean base_color\?"),
        ({"type": "openpbr", "resoluton": BOARD}, r"'resoluton'; did you mean resolution\?"),
        ({"type": "materialx", "matrial": 0.5}, r"'matrial'; did you mean material\?"),
    ],
)
def test_mistakes_of_one_plugin(rgb, description, sentence):
    with pytest.raises(RuntimeError, match=sentence):
        rgb.load_dict(description)


def test_textures_that_are_not_over_uv(rgb, networks, tmp_path):
    """Bottoms whose parameters are known have them too; the walk checks those beside them."""
    attribute = {"type": "mesh_attribute", "name": "vertex_value"}
    grid = rgb.VolumeGrid(np.full((2, 2, 2, 1), 0.5, np.float32))
    volume = {"type": "volume", "volume": {"type": "gridvolume", "grid": grid, "raw": True}}
    for what, texture in (
        ("a mesh attribute, which is given on a mesh", attribute),
        ("a volume, which is given in space", volume),
        ("a mesh attribute, which", BOARD | {"color0": attribute}),
    ):
        for below, coat in ((texture, {}), (BOARD, {"alpha": texture})):
            base = bottom("layered", inside=bottom(), sigma_t=below)
            with pytest.raises(RuntimeError, match=f"depends on {what}.*, but the nested '"):
                load(rgb, networks, "neural_layered", base=base, **coat)
        load(rgb, networks, "layered", alpha=texture, int_ior=texture)
        with pytest.raises(RuntimeError, match="layered: g is 1; it must be"):
            load(rgb, networks, "layered", alpha=texture, int_ior=texture, g=1.0)
    bsdf = load(rgb, networks, "neural_layered", alpha=texture)
    with pytest.raises(ParameterError, match="depends on a mesh attribute.*, but a file has texel"):
        bsdf.save(tmp_path / "coat.safetensors")


@pytest.mark.parametrize("kind", ("normalmap", "bumpmap"))
def test_normal_maps_in_bottoms_are_refused(rgb, networks, kind):
    texture = {"normalmap" if kind == "normalmap" else "heights": bitmap(np.full((2, 2, 3), 0.5))}
    mapped = bottom(kind, inside=bottom(), **texture)
    for base in (mapped, bottom("twosided", inside=mapped)):
        with pytest.raises(RuntimeError, match=f"contains a '{kind}', and codes have no normals"):
            load(rgb, networks, "neural_layered", base=base)
        load(rgb, networks, "layered", base=base)


@pytest.mark.parametrize("name", (*register.PLUGINS.bsdfs, *PLUGINS.bsdfs, *PLUGINS.emitters))
@pytest.mark.parametrize("variant", ("scalar_rgb", "scalar_spectral", "llvm_ad_mono_polarized"))
def test_variants_that_cannot_work_say_which_can(name, variant):
    mi.set_variant(variant)
    with pytest.raises(RuntimeError) as caught:
        mi.load_dict({"type": name})
    sentence = f"'{name}' does not work in the variant {variant}; choose llvm_ad_rgb"
    assert sentence in str(caught.value)
