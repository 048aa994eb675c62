"""The benchmarks' scenes differ in what their method and light say, and in nothing else."""

import pytest
from benchmarks.scenes import OWN, POINT, PRINCIPLED, SCENES, SKY, WALK, describe, digest

from urushi.nets.weights import DEFAULT

SMALL = {"width": 16, "detail": 0.02}


pytestmark = pytest.mark.usefixtures("rgb")


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


def test_the_hash_states_content_and_not_the_folder(tmp_path):
    def of(method=WALK, light=OWN, folder="a", **size):
        path = tmp_path / f"{folder}-{method}-{light}-{size}"
        return digest(describe("caddy", method, path, light=light, **(SMALL | size)), path)

    assert of() == of(folder="b")
    others = [of(DEFAULT), of(PRINCIPLED), of(light=POINT), of(light=SKY), of(width=20)]
    assert len({of(), *others}) == 1 + len(others)
