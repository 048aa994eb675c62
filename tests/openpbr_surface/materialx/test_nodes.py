"""Values of nodes at points of the surface, and noise."""

import numpy as np
import pytest
from tests.openpbr_surface.materialx.conftest import element

from urushi.errors import UrushiWarning
from urushi.openpbr_surface.materialx import noise
from urushi.openpbr_surface.materialx.document import read_document
from urushi.openpbr_surface.materialx.evaluation import Evaluation, parse_value
from urushi.openpbr_surface.materialx.graph import Frame, Graph
from urushi.openpbr_surface.materialx.images import Images

POINTS = np.random.default_rng(0).random((64, 2))
U, V = POINTS.T
ONE = np.ones(len(POINTS))


@pytest.fixture
def evaluate(document):
    """A function: the values of the node `n` of a document at POINTS."""

    def values(body):
        path = document(body + element("dot", "color3", "tested", in_=("color3", "@n")))
        graph = Graph(Frame(read_document(path), "test"), Images(path.parent))
        with np.errstate(all="ignore"):  # as in `bake`
            result = Evaluation(graph, POINTS).input(graph.root.node("tested"), "in")
        return np.broadcast_to(result, (len(POINTS), result.shape[-1]))

    return values


@pytest.mark.parametrize(
    ("tag", "inputs", "expected"),
    [
        ("add", "in1=3 in2=2", 5),
        ("subtract", "in1=3 in2=2", 1),
        ("divide", "in1=3 in2=2", 1.5),
        ("modulo", "in1=-1 in2=3", 2),
        ("power", "in1=3 in2=2", 9),
        ("min", "in1=3 in2=2", 2),
        ("invert", "in=0.25", 0.75),
        ("clamp", "in=1.5", 1),
        ("round", "in=2.5", 3),
        ("fract", "in=-0.25", 0.75),
        ("smoothstep", "in=0.5", 0.5),
        ("mix", "fg=1 bg=3 mix=0.25", 2.5),
        ("remap", "in=0.5 outlow=2 outhigh=4", 3),
        ("ifgreater", "value1=1 value2=1 in1=5 in2=6", 6),
        ("ifgreatereq", "value1=1 value2=1 in1=5 in2=6", 5),
        ("screen", "fg=0.5 bg=0.5 mix=1", 0.75),
        ("range", "in=0.25 outhigh=2", 0.5),
        ("ramplr", "valuel=1 valuer=3", 1 + 2 * U),
        ("ramptb", "valuet=1 valueb=3", 3 - 2 * V),
    ],
)
def test_nodes_of_numbers(evaluate, tag, inputs, expected):
    given = {key + "_": ("float", x) for key, x in (pair.split("=") for pair in inputs.split())}
    assert evaluate(element(tag, "float", **given))[:, 0] == pytest.approx(expected * ONE)


VECTOR = ("vector3", "0.9, 0.4, 0.8")  # of a normal map: (0.8, -0.2, 0.6)
BENT = np.array([0.8, -0.2, 0.6]) / np.sqrt(1.04)
UV = element("texcoord", "vector2", "uv")
AMOUNT = 'value="{}" unittype="angle" unit="{}"'
#: rotate2d by a quarter turn, in a unit.
QUARTER = UV + element("rotate2d", "vector2", in_=("vector2", "@uv"), amount=("float", AMOUNT))
PLACE = {"pivot": ("vector2", "0.5, 0.5"), "scale": ("vector2", "2, 4")}
PLACE |= {"rotate": 90.0, "offset": ("vector2", "0.1, 0.2")}
FRAME = {"tangent": ("vector3", "@t"), "bitangent": ("vector3", "@b")}

RAMP, COLOR4 = ("ramp", "color4", "r"), ("color4", "0.1, 0.2, 0.3, 1")

CASES = {
    "RGB to HSV and back": (
        element("rgbtohsv", "color3", "h", in_=(0.7, 0.2, 0.4))
        + element("hsvtorgb", "color3", in_=("color3", "@h")),
        (0.7, 0.2, 0.4),
    ),
    "channels": (
        element("combine3", "color3", "c", **{f"in{k}": float(k) for k in (1, 2, 3)})
        + element("separate3", "multioutput", "s", in_=("color3", "@c"))
        + element("dot", "float", in_=("float", 'nodename="s" output="outg"')),
        (2,),
    ),
    "texcoord in space": (element("texcoord", "vector3"), (U, V, 0)),
    "degrees": (QUARTER.format("90", "degree"), (V, -U)),
    "a unit of the document": (
        '<unitdef name="U" unittype="angle"><unit name="turn" scale="360"/></unitdef>'
        + QUARTER.format("0.25", "turn"),
        (V, -U),
    ),
    "radians": (QUARTER.format("1.57079632679", "radian"), (V, -U)),
    "place2d: p -> R((p - pivot) / scale) - offset + pivot, R clockwise": (
        UV + element("place2d", "vector2", texcoord=("vector2", "@uv"), **PLACE),
        ((V - 0.5) / 4 - 0.1 + 0.5, -(U - 0.5) / 2 - 0.2 + 0.5),
    ),
    "a flat normal map keeps the normal": (
        element("normalmap", "vector3", "i", in_=VECTOR)
        + element("normalmap", "vector3", normal=("vector3", "@i")),
        BENT,
    ),
    "a normal map in a turned frame": (
        element("constant", "vector3", "t", value=("vector3", "0, 1, 0"))
        + element("constant", "vector3", "b", value=("vector3", "-1, 0, 0"))
        + element("normalmap", "vector3", in_=VECTOR, **FRAME),
        (-BENT[1], BENT[0], BENT[2]),
    ),
    # Its library's graph has an <ifgreater> with the definition of <ifgreatereq>.
    "a ramp of two intervals ends with the second": (
        element("constant", "vector2", "p", value=("vector2", "0.75, 0"))
        + element(*RAMP, texcoord=("vector2", "@p"), interval2=0.5, interval3=0.6, color2=COLOR4)
        + element("convert", "color3", in_=("color4", "@r")),
        (0.1, 0.2, 0.3),
    ),
    "grey is below a saturation of 1e-4, as in OSL": (
        element("hsvtorgb", "color3", in_=(0.3, -0.5, 0.7)),
        (0.7, 0.7, 0.7),
    ),
    "a type without a definition has the defaults of other types": (
        element("multiply", "integer", "m", in1=3)
        + element("convert", "color3", in_=("integer", "@m")),
        (3, 3, 3),
    ),
    "a definition that is missing": (
        element("mix", "color3", bg=(0.1, 0.2, 0.3)).replace(" type", ' nodedef="ND_x" type', 1),
        (0.1, 0.2, 0.3),
    ),
    "a value beside a coordinate": (  # editors write it; MaterialX reads the property
        element("ramplr", "float", valuer=1.0, texcoord=("vector2", "0, 0")),
        (U,),
    ),
    "a value beside the coordinate of a graph": (
        element("checkerboard", "color3", "k", texcoord=("vector2", "0, 0"))
        + element("checkerboard", "color3", "plain")
        + element("subtract", "color3", in1=("color3", "@k"), in2=("color3", "@plain")),
        (0, 0, 0),
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_nodes_of_vectors(evaluate, case):
    body, expected = CASES[case]
    assert evaluate(body) == pytest.approx(np.stack([x * ONE for x in expected], -1))


@pytest.mark.parametrize("tag", ["ifgreater", "ifgreatereq", "ifequal"])
@pytest.mark.parametrize("value", [0.5, 1, 2])
def test_a_comparison_is_a_truth_value(evaluate, tag, value):
    """Of type boolean it has no inputs but the compared ones."""
    truth = {"ifgreater": value > 1, "ifgreatereq": value >= 1, "ifequal": value == 1}[tag]
    body = element(tag, "boolean", value1=float(value), value2=1.0)
    assert evaluate(body)[0, 0] == truth


def test_a_checkerboard_has_two_colours(evaluate):
    value = evaluate(element("checkerboard", "color3", uvtiling=("vector2", "4, 2")))[:, 0]
    even = np.floor(POINTS * [4, 2]).sum(-1) % 2 == 0
    assert len(np.unique(value[even])) == len(np.unique(value[~even])) == 1
    assert value[even][0] != value[~even][0]


@pytest.mark.parametrize(
    ("body", "lost"),
    [
        (element("add", "float", in3=1.0), "the unknown input in3"),
        (element("blur", "float", size=1.0), "blurring"),
        (element("normalmap", "vector3", space=("string", "object")), "the unknown input space"),
    ],
)
def test_what_nodes_lose_is_said(evaluate, body, lost):
    with pytest.warns(UrushiWarning, match=f"the node 'n'.*{lost} is left out"):
        evaluate(body)


@pytest.mark.parametrize(
    ("kind", "text", "expected"),
    [
        ("vector2", "0.5 0.25", [0.5, 0.25]),
        ("color3", " 0.5 ,0.25,  1e-1 ", [0.5, 0.25, 0.1]),
        ("float", "0.5f", [0.5]),
        ("float", "10,5,1", [10]),
        ("float", "3.40282e+38", [1e30]),
        ("float", "+.5", [0.5]),
        ("integer", "3.7", [3]),
        ("boolean", "True", [1]),
    ],
)
def test_values_are_read_as_by_materialx(kind, text, expected):
    """Value.cpp of MaterialX splits at commas and spaces, and reads a number from the front."""
    assert parse_value(text, kind, "x").tolist() == expected


@pytest.mark.parametrize(
    ("axes", "scale", "gradient", "number"),
    [(2, 0.6616, [1, 2], 8), (3, 0.9820, [0, 1, 1], 12)],
    ids=["plane", "space"],
)
def test_noise_is_gradient_noise(axes, scale, gradient, number):
    """It is 0 on the lattice, where its slopes are one of a few gradients, and random in sign.

    In a plane there are eight, in space the 12 edges of a cube. Octaves add up.
    """
    lattice = np.stack(np.meshgrid(*[np.arange(-4.0, 4)] * axes), -1).reshape(-1, axes)
    assert np.allclose(noise.perlin(lattice, 4)[..., :3], 0)
    steps = 1e-6 * np.eye(axes)
    slopes = [noise.perlin(lattice + step, 1) / (scale * 1e-6) for step in steps]
    found = np.unique(np.round(np.concatenate(slopes, -1), 3), axis=0)
    assert np.allclose(np.sort(np.abs(found), -1), gradient, atol=1e-3)
    assert len(found) == number
    p = 0.3 + 0.7 * lattice
    two = noise.fractal(p, 1, 2, np.array([2.0]), np.array([0.5]))
    assert two == pytest.approx(noise.perlin(p, 1) + 0.5 * noise.perlin(2 * p, 1))


@pytest.mark.parametrize(
    ("function", "others"),
    [
        (noise.perlin, (2,)),
        (noise.fractal, (4, 2, np.full(1, 2.0), np.full(1, 0.5))),
        (noise.cell, ()),
        (noise.worley, (3, np.full(1, 0.5), 1)),
    ],
)
def test_noise_at_one_place(function, others):
    """A constant position gives a constant, also where another input varies."""
    for p in (7 * POINTS, np.c_[POINTS, U]):
        assert np.array_equal(function(p[3], *others), function(p, *others)[3])
    jitter = POINTS[:, :1]
    assert noise.worley(7 * POINTS[3], 1, jitter, 0)[5] == noise.worley(
        7 * POINTS[3], 1, jitter[5], 0
    )


def test_the_hash_is_jenkins_final():
    """lookup3 (2006), `final`, on Python's integers, for one pair of numbers."""
    mask = 0xFFFFFFFF
    start = (0xDEADBEEF + 8 + 13) & mask
    words = {"a": (start + 5) & mask, "b": (start - 7) & mask, "c": start}
    for (target, source), bits in zip(
        ("cb", "ac", "ba", "cb", "ac", "ba", "cb"), (14, 11, 25, 16, 4, 14, 24), strict=True
    ):
        x = words[source]
        turned = ((x << bits) | (x >> (32 - bits))) & mask
        words[target] = ((words[target] ^ x) - turned) & mask
    assert noise.hash_integers(np.array(5), np.array(-7)) == words["c"]


def test_cellular_noise_is_a_distance():
    """Its slope is at most 1, the second distance is not below the first, 0 jitter is a grid."""
    p = POINTS * 7
    one, two = noise.worley(p, 2, np.ones(1), 0).T
    assert (two >= one).all()
    near = noise.worley(p + np.array([1e-4, 0]), 2, np.ones(1), 0)[:, 0]
    assert (np.abs(near - one) <= 1e-4 * (1 + 1e-6)).all()
    for q in (p, np.c_[p, p[:, :1]]):  # in a plane and in space
        grid = noise.worley(q, 1, np.zeros(1), 0)[:, 0]
        assert grid == pytest.approx(np.linalg.norm(q - np.floor(q) - 0.5, axis=-1))
