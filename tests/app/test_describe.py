"""A description on the command line means what the same text means in Python, and nothing else."""

import pytest

import urushi
from urushi.app.describe import describe, is_description
from urushi.errors import ParameterError


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
    assert is_description(text)


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
        ("diffuse(**{'reflectance': 0.5})", "cannot read"),
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
