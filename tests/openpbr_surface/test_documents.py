"""The plugin `materialx` is `openpbr` with a document's parameters."""

from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest
from tests.directions import pairs_above
from tests.mitsuba.probes import f, sampled
from tests.openpbr_surface.materialx.conftest import HEAD, element
from tests.openpbr_surface.probes import loaded

import urushi

for package in ("MaterialX", "OpenImageIO"):
    pytest.importorskip(package, reason="the extra 'materialx' is not installed")
pytestmark = pytest.mark.usefixtures("rgb")

GOLD = dict(base_metalness=1.0, base_color=(0.9, 0.7, 0.3), specular_roughness=0.5)
GLASS = dict(transmission_weight=1.0, transmission_dispersion_scale=1.0)
DOCUMENT = HEAD.format(
    space="lin_rec709",
    body=element("open_pbr_surface", "surfaceshader", "Gold", **GOLD)
    + element("open_pbr_surface", "surfaceshader", "Glass", **GLASS)
    + element("standard_surface", "surfaceshader", "Ketchup", subsurface=1.0),
)


@pytest.fixture
def path(tmp_path):
    file = tmp_path / "materials.mtlx"
    file.write_text(DOCUMENT)
    return str(file)


def values(bsdf):
    return f(bsdf, *pairs_above(100, 0, 0.1))


def test_parameters_are_those_of_the_document_unless_properties_replace_them(path):
    gold = {"type": "materialx", "filename": path, "material": "Gold"}
    found = values(mi.load_dict(gold))
    assert np.array_equal(found, values(loaded(**GOLD)))
    assert not np.allclose(values(mi.load_dict(gold | {"specular_roughness": 0.8})), found, 0.1)
    scene = f"""<bsdf version="3.0.0" type="materialx"><string name="filename" value="{path}"/>
        <string name="material" value="Gold"/></bsdf>"""
    assert np.array_equal(found, values(mi.load_string(scene)))


@pytest.mark.parametrize("weight", ['value="0.3"', 'nodename="u"', 'value="1"'])
def test_a_mixture_of_shaders_is_one_of_their_brdfs(path, weight):
    """As MaterialX defines `mix`: (1 - mix) bg + mix fg. u is .5 where `values` evaluates."""
    shaders = {"bg": ("surfaceshader", "@Plain"), "fg": ("surfaceshader", "@Gold")}
    mixed = element("open_pbr_surface", "surfaceshader", "Plain")
    mixed += element("texcoord", "vector2", "uv")
    mixed += element("extract", "float", "u", in_=("vector2", "@uv"))
    mixed += element("mix", "surfaceshader", "Mix", mix=("float", weight), **shaders)
    Path(path).write_text(DOCUMENT.replace("</materialx>", mixed + "</materialx>"))

    def f(material):
        return values(mi.load_dict({"type": "materialx", "filename": path, "material": material}))

    share = {"0": 0.3, "u": 0.5, "1": 1.0}[weight.split('"')[1][0]]
    expected = (1 - share) * f("Plain") + share * f("Gold")
    assert np.allclose(f("Mix"), expected, rtol=1e-3, atol=1e-6)  # the texture has 1024 columns


def test_a_document_with_a_medium_is_rendered_on_a_shape(path):
    """The plugin says `interior` where the shape has a medium of its own."""
    ketchup = {"type": "materialx", "filename": path, "material": "Ketchup", "interior": True}
    surface = values(mi.load_dict(ketchup))
    shape = urushi.openpbr(**urushi.load_materialx(path, "Ketchup")).on({"type": "sphere"})
    assert mi.load_dict(shape).interior_medium() is not None
    assert np.array_equal(surface, values(mi.load_dict(shape["bsdf"])))


@pytest.mark.parametrize(
    ("properties", "message"),
    [
        ({"filename": None}, "has no filename; give a MaterialX document"),
        ({"filename": "none.mtlx"}, "there is no MaterialX file"),
        ({}, "has several materials; choose one of Gold, Glass, Ketchup"),
        ({"material": "Glass"}, r"'Glass' \(open_pbr_surface\): .*_dispersion_scale needs"),
        ({"material": "Ketchup"}, r"'Ketchup' \(standard_surface\): subsurface_weight asks for"),
        ({"material": "Gold", "bake": 0}, "materialx: bake is 0; it must be in"),
        (
            {"material": "Gold", "coat_weight": 1.0, "coat_ior": -1.0},
            r"'Gold' \(open_pbr_surface\): coat_ior is -1",
        ),
    ],
)
def test_errors_say_what_to_do(path, properties, message):
    given = {"type": "materialx", "filename": path} | properties
    node = r"materialx: '.*': the node " if message.startswith("'") else ""
    with pytest.raises(Exception, match=node + message):
        mi.load_dict({k: v for k, v in given.items() if v is not None})


def crossing(bsdf):
    """Share of the light that crosses a surface at the normal, and the root mean square sine."""
    weight, wo = sampled(bsdf, [[0, 0, 1]], 1 << 12)
    crosses = wo[0, :, 2] < 0
    share = (weight[0] * crosses[:, None]).mean(axis=0)
    return share, (1 - wo[0, crosses, 2] ** 2).mean() ** 0.5


def test_glass_of_blender():
    """Cycles multiplies refracted light by the root of Base Color (transmission_tint of its
    generalized Schlick closure, intern/cycles/kernel/svm/closure.h), as the page says."""
    page = (Path(__file__).parents[2] / "docs" / "coming_from.md").read_text(encoding="utf-8")
    assert "`transmission_color` = √*Base Color*" in page
    base = np.array([0.1, 0.8, 0.2])
    glass = urushi.openpbr(
        transmission_weight=1, transmission_color=np.sqrt(base), specular_roughness=0
    )
    share, _ = crossing(glass.bsdf())
    assert share == pytest.approx(0.96 * np.sqrt(base), abs=0.01)


@pytest.mark.parametrize(
    ("tag", "inputs", "transmitted", "spread"),
    [
        (
            "gltf_pbr",
            dict(transmission=1.0, metallic=0.0, roughness=0.0, thickness=1.0)
            | dict(base_color=(0.5, 0.8, 0.9)),
            (0.48, 0.768, 0.864),
            (0, 0.1),
        ),
        ("UsdPreviewSurface", dict(opacity=0.25, roughness=0.6), (0.72,) * 3, (0, 0.1)),
        (
            "standard_surface",
            dict(thin_walled=True, subsurface=1.0, subsurface_color=(0.3, 0.6, 0.1), specular=0.0),
            (0.3, 0.6, 0.1),
            (0.7071, 0.02),
        ),
    ],
)
@pytest.mark.filterwarnings("ignore:.*has one roughness of light")
def test_light_that_crosses_a_surface(path, tag, inputs, transmitted, spread):
    """At the normal, by the shaders' graphs in MaterialX: 1 - F = .96 times tint and share.

    spread: root mean square of the sine, and its tolerance. It is 0 but for the tails of width .01
    if the light is transmitted sharply, and 1 / sqrt(2) of a Lambertian lobe. The tolerances of the
    shares and of this lobe are three standard errors of 4,096 samples.
    """
    body = element(tag, "surfaceshader", **inputs)
    Path(path).write_text(HEAD.format(space="lin_rec709", body=body))
    share, sine = crossing(mi.load_dict({"type": "materialx", "filename": path}))
    assert share == pytest.approx(transmitted, abs=0.02)
    assert sine == pytest.approx(spread[0], abs=spread[1])
