"""Descriptions on the command line mean what Python means; the library names some."""

import numpy as np
import pytest

import urushi
from urushi.app import cli
from urushi.app.describe import describe, is_description, library
from urushi.errors import ParameterError
from urushi.walk import analytic
from urushi.walk.simulate import albedo

WI = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.96, 0.28]])


@pytest.mark.parametrize(
    "text",
    [
        "diffuse(0.5)",
        "diffuse(reflectance=(0.1, 0.2, 0.3))",
        "dielectric(0.05, 1.5)",
        "conductor(alpha=0.2, r0=(0.98, 0.77, 0.34))",
        "conductor(0.2, eta=0.2, k=[3.9, 2.4, 2.2])",
        "coat(conductor(0.2, 0.9), alpha=0.05, eta=1.5)",
        "coat(diffuse(0.5), alpha=0.1, eta=1.4, albedo=0.8, sigma_t=(0.2, 1, 3), g=-0.3)",
        "coat(coat(diffuse(0.5), alpha=0.1, eta=1.2), alpha=0.05, eta=1.5, sigma_t=1, albedo=1)",
        "slab(0.1, 1.5, albedo=0.9, sigma_t=2, far=dielectric(0.2, 0.887))",
        "\n  diffuse( 5e-1 ) ",
    ],
)
def test_means_what_python_means(text):
    makers = ("coat", "conductor", "dielectric", "diffuse", "slab")
    names = {name: getattr(urushi, name) for name in makers}
    assert describe(text) == eval(text.strip(), names)
    assert is_description(text) and is_description(f"urushi.{text.strip()}")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "not a Python expression"),
        ("conductor(", "not a Python expression"),
        ("import os", "not a Python expression"),
        ("[0.5]", "neither a call nor a name"),
        ("crimson", "neither a call nor a name"),
        ("lacquer(0.2)", "'lacquer' is not one of coat, slab, conductor, dielectric, diffuse"),
        ("__import__('os').getcwd()", "is not one of"),
        ("urushi.diffuse(0.5)", "is not one of"),
        ("openpbr(coat_weight=1)", "'openpbr' is not one of coat, slab, "),
        ("diffuse(open('x'))", "is not one of"),
        ("diffuse(1 if 1 else 2)", "neither one number nor three"),
        ("diffuse('0.5')", "neither one number nor three"),
        ("diffuse(True)", "neither one number nor three"),
        ("conductor(0.2, r0=0.9, energy_compensation='no')", "neither one number nor three"),
        (f"diffuse({'-' * 5000}1)", "not a Python expression"),
        ("diffuse(**{'reflectance': 0.5})", "cannot read"),
        ("coat(diffuse(0.5), alpha=0.1, alpha=0.2)", "'alpha' is given twice"),
        ("diffuse(0.5, gloss=1)", "unexpected keyword argument 'gloss' in diffuse(reflectance)"),
        ("diffuse()", "missing a required argument: 'reflectance' in diffuse(reflectance)"),
    ],
)
def test_refuses_with_the_reason_and_an_example(text, reason):
    with pytest.raises(ParameterError) as caught:
        describe(text)
    message = str(caught.value)
    assert message.startswith("cannot read the description")
    assert reason in message
    assert "write it as in Python" in message


@pytest.mark.parametrize(
    "text", ["scene.xml", "coat.safetensors", "/tmp/conductor", "a (2).binary", ""]
)
def test_file_names_are_no_descriptions_and_unknown_calls_are(text):
    """Such calls are refused, and are not files that are missing."""
    assert not is_description(text)
    assert is_description("openpbr(coat_weight=1)")


@pytest.mark.parametrize("name", library())
def test_materials_reflect_no_more_light_than_there_is(name):
    """The standard error of an albedo is about 0.01."""
    material = describe(name)
    if not isinstance(material, urushi.Stack):
        f = analytic.f(material, WI, WI * [-1, -1, 1])
        assert (f > 0).all() and np.isfinite(f).all()
        return
    found, error = albedo(material, WI, walks=2048, seed=0)
    assert (found > 0).all()
    assert (found < 1 + 4 * error).all()


def test_names_stand_for_descriptions(capsys):
    assert len(library()) == 24
    assert is_description("black urushi") and not is_description("grey urushi")
    assert describe("tenmoku") == describe(library()["tenmoku"])
    assert cli.main(["materials"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in library())


def test_hues_are_those_of_the_names():
    """Diffuse light: the strongest channel of red, green and blue materials."""
    for name, strongest in (
        ("vermilion urushi", 0),
        ("metallic red car paint", 0),
        ("candy blue car paint", 2),
        ("green enamel on silver", 1),
        ("celadon", 1),
        ("anodised aluminium", 2),
    ):
        found, _ = albedo(describe(name), WI[1:2], walks=4096, seed=0)
        assert found[0].argmax() == strongest, name
