"""The benchmarks' scenes differ in what their method and light say, and in nothing else."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from benchmarks import textured_coats
from benchmarks.scenes import (
    BOTH,
    LIGHTS,
    OWN,
    POINT,
    PRINCIPLED,
    RIVALS,
    SCENES,
    SKY,
    TEXTURED,
    WALK,
    describe,
    digest,
)

from urushi.nets.weights import ANISOTROPIC, DEFAULT, anisotropic_model

SMALL = {"width": 16, "detail": 0.02}
LIGHTS_OF_BOTH = (OWN, POINT, BOTH)


@pytest.fixture(autouse=True)
def variant():
    mi.set_variant("llvm_ad_rgb")


def types(node):
    """The types of all nodes; of OpenPBR, the plugin of its coat."""
    yield node.get("reference", node["type"])
    for value in node.values():
        if isinstance(value, dict):
            yield from types(value)


@pytest.mark.parametrize("name", sorted({*SCENES} - {"library"}))  # saved materials, no coats
def test_methods_replace_every_coat_and_leave_the_rest(name, tmp_path):
    found = {
        method: list(types(describe(name, method, tmp_path, **SMALL)))
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


@pytest.mark.parametrize("method", RIVALS)
def test_models_of_others_take_the_place_of_the_walk(method, tmp_path):
    walk, rival = (list(types(describe("globe", m, tmp_path, **SMALL))) for m in (WALK, method))
    assert [method if x == "layered" else x for x in walk] == rival


@pytest.mark.parametrize("name", SCENES)
def test_the_point_light_gives_a_facing_white_surface_at_the_origin_radiance_one(name, tmp_path):
    light = describe(name, WALK, tmp_path, light=POINT, **SMALL)["light"]
    distance = np.linalg.norm(light["position"])
    np.testing.assert_allclose(np.array(light["intensity"]["value"]) / distance**2, np.pi)


def test_both_lights_are_the_scenes_own_and_the_point_light(tmp_path):
    own, point, both = (describe("shoe", WALK, tmp_path, light=x, **SMALL) for x in LIGHTS_OF_BOTH)
    assert both["surround"] == own["surround"] and both["point"] == point["light"]


@pytest.mark.parametrize("method", [WALK, DEFAULT])
def test_the_textured_still_life_has_textures_of_alpha_and_index_within_their_ranges(
    method, tmp_path
):
    options = {"width": 16, "detail": 0.1}  # 51 texels show every pattern
    scene = describe(TEXTURED, method, tmp_path, **options)
    plain = describe("still-life", method, tmp_path / "plain", **options)
    assert scene.keys() == plain.keys()
    for name in ("vase", "plate", "table", "bead-0"):
        coat, before = scene[name]["bsdf"], plain[name]["bsdf"]
        assert {key for key in coat if coat[key] != before[key]} >= {"alpha", "int_ior"}
        for key, ends in (("alpha", textured_coats.ALPHAS), ("int_ior", textured_coats.INDICES)):
            values = np.array(mi.Bitmap(coat[key]["filename"]))
            # Half floats round by 1/2048 of a value.
            assert ends[0] * 0.999 <= values.min() < values.max() <= ends[1] * 1.001
    assert scene["bowl"]["bsdf"]["bsdf"]["alpha"]["type"] == "bitmap"  # inside the normal map


@pytest.mark.parametrize("light", LIGHTS)
@pytest.mark.parametrize("method", [WALK, PRINCIPLED])
def test_scenes_load_with_one_kind_of_light(light, method, tmp_path):
    scene = mi.load_dict(describe("globe", method, tmp_path, light=light, **SMALL))
    (emitter,) = scene.emitters()
    kind = {OWN: "EnvironmentMapEmitter", POINT: "PointLight", SKY: "SunskyEmitter"}[light]
    assert kind in str(emitter)
    picture = np.array(mi.render(scene, spp=4))
    assert np.isfinite(picture).all() and 0.01 < picture.mean() < 10
    dr.sync_thread()


def test_the_hash_states_content_and_not_the_folder(tmp_path):
    def of(method=WALK, light=OWN, folder="a", **size):
        return digest(describe("demo", method, tmp_path / folder, light=light, **(SMALL | size)))

    assert of() == of(folder="b")
    others = [of(DEFAULT), of(PRINCIPLED), of(light=POINT), of(light=SKY), of(width=20)]
    assert len({of(), *others}) == 1 + len(others)


def test_the_default_networks_are_left_to_the_coat_and_others_are_named(tmp_path):
    # Brushed metal needs the anisotropic networks, which a coat without weights chooses.
    default, named = (
        describe("brushed", method, tmp_path, **SMALL)["back"]["bsdf"]
        for method in (DEFAULT, ANISOTROPIC)
    )
    assert "weights" not in default and named["weights"] == ANISOTROPIC
    bsdf = mi.load_dict(default)
    assert bsdf.model.fingerprint == anisotropic_model().fingerprint
