"""Node graphs: values at points, textures against Mitsuba's own look-up, noise."""

import struct

import numpy as np
import pytest
from tests.openpbr_surface.materialx.conftest import write_image

from urushi.errors import FileError, UrushiWarning
from urushi.openpbr_surface.materialx import noise
from urushi.openpbr_surface.materialx.baking import Texture
from urushi.openpbr_surface.materialx.document import read_document
from urushi.openpbr_surface.materialx.evaluation import Evaluation, parse_value
from urushi.openpbr_surface.materialx.graph import Graph
from urushi.openpbr_surface.materialx.images import Images, Look, sample
from urushi.openpbr_surface.materialx.surface import read_surface

mi = pytest.importorskip("mitsuba")

POINTS = np.random.default_rng(0).random((64, 2))


@pytest.fixture
def llvm():
    before = mi.variant()
    mi.set_variant("llvm_ad_rgb")
    yield
    if before is not None:
        mi.set_variant(before)


@pytest.fixture
def evaluate(document):
    """A function: the values of the node `n` of a document at POINTS."""

    def value(body, points=POINTS):
        path = document(body)
        root = read_document(path).root
        graph = Graph(root, Images(path.parent), "test")
        node = root.addOutput("tested", "color3")
        node.setNodeName("n")
        result = Evaluation(graph, points).value(graph.follow(node, graph.root, node), node)
        return np.broadcast_to(result, (len(points), result.shape[-1]))

    return value


def element(tag, kind, name="n", **inputs):
    """The text of a node; inputs: type and value, or type and @node."""
    inside = ""
    for key, (of, value) in inputs.items():
        link = "nodename" if value.startswith("@") else "value"
        inside += f'<input name="{key.rstrip("_")}" type="{of}" {link}="{value.lstrip("@")}"/>'
    return f'<{tag} name="{name}" type="{kind}">{inside}</{tag}>'


UV = element("texcoord", "vector2", "uv")


@pytest.mark.parametrize(
    ("tag", "inputs", "expected"),
    [
        ("add", {"in1": "3", "in2": "2"}, 5),
        ("subtract", {"in1": "3", "in2": "2"}, 1),
        ("divide", {"in1": "3", "in2": "2"}, 1.5),
        ("modulo", {"in1": "-1", "in2": "3"}, 2),
        ("power", {"in1": "3", "in2": "2"}, 9),
        ("min", {"in1": "3", "in2": "2"}, 2),
        ("invert", {"in": "0.25"}, 0.75),
        ("clamp", {"in": "1.5"}, 1),
        ("round", {"in": "2.5"}, 3),
        ("fract", {"in": "-0.25"}, 0.75),
        ("smoothstep", {"in": "0.5"}, 0.5),
        ("mix", {"fg": "1", "bg": "3", "mix": "0.25"}, 2.5),
        ("remap", {"in": "0.5", "outlow": "2", "outhigh": "4"}, 3),
        ("ifgreater", {"value1": "1", "value2": "1", "in1": "5", "in2": "6"}, 6),
        ("ifgreatereq", {"value1": "1", "value2": "1", "in1": "5", "in2": "6"}, 5),
        ("screen", {"fg": "0.5", "bg": "0.5", "mix": "1"}, 0.75),
        ("range", {"in": "0.25", "outhigh": "2"}, 0.5),
    ],
)
def test_arithmetic(evaluate, tag, inputs, expected):
    text = element(tag, "float", **{key + "_": ("float", v) for key, v in inputs.items()})
    assert evaluate(text)[0, 0] == pytest.approx(expected)


def test_hue_goes_round(evaluate):
    """RGB to HSV and back is the identity."""
    body = element("rgbtohsv", "color3", "h", in_=("color3", "0.7, 0.2, 0.4"))
    body += element("hsvtorgb", "color3", in_=("color3", "@h"))
    assert evaluate(body)[0] == pytest.approx([0.7, 0.2, 0.4])


def test_channels(evaluate):
    parts = {f"in{k}": ("float", str(k)) for k in (1, 2, 3)}
    body = element("combine3", "color3", "c", **parts)
    body += element("separate3", "multioutput", "s", in_=("color3", "@c"))
    body += """<dot name="n" type="float">
        <input name="in" type="float" nodename="s" output="outg"/></dot>"""
    assert evaluate(body)[0, 0] == 2


@pytest.mark.parametrize("tag", ["ifgreater", "ifgreatereq", "ifequal"])
@pytest.mark.parametrize("value", [0.5, 1, 2])
def test_a_comparison_is_a_truth_value(evaluate, tag, value):
    """Of type boolean it has no inputs but the compared ones."""
    truth = {"ifgreater": value > 1, "ifgreatereq": value >= 1, "ifequal": value == 1}[tag]
    body = element(tag, "boolean", value1=("float", str(value)), value2=("float", "1"))
    assert evaluate(body)[0, 0] == truth


def test_values_do_not_replace_geometric_properties(evaluate):
    """Editors write a value beside an unconnected coordinate; MaterialX reads the property."""
    zero = ("vector2", "0, 0")
    ramp = element("ramplr", "float", valuer=("float", "1"), texcoord=zero)
    assert evaluate(ramp)[:, 0] == pytest.approx(POINTS[:, 0])
    board = {"texcoord": zero, "uvtiling": ("vector2", "4, 2")}  # a node with a graph
    plain = element("checkerboard", "color3", uvtiling=board["uvtiling"])
    assert np.array_equal(evaluate(element("checkerboard", "color3", **board)), evaluate(plain))


def test_coordinates_in_space_have_a_third_of_0(evaluate):
    assert np.array_equal(evaluate(element("texcoord", "vector3")), np.c_[POINTS, 0 * POINTS[:, 0]])


def test_a_normal_map_bends_another(evaluate):
    """A flat map keeps the normal that it is given; others are in the frame that they are given."""
    vector = {"in_": ("vector3", "0.9, 0.4, 0.8")}
    inner = element("normalmap", "vector3", "i", **vector)
    outer = element("normalmap", "vector3", normal=("vector3", "@i"))
    x, y, z = np.array([0.8, -0.2, 0.6]) / np.sqrt(1.04)
    assert evaluate(inner + outer)[0] == pytest.approx([x, y, z])
    along = element("constant", "vector3", "t", value=("vector3", "0, 1, 0"))
    across = element("constant", "vector3", "b", value=("vector3", "-1, 0, 0"))
    frame = {"tangent": ("vector3", "@t"), "bitangent": ("vector3", "@b")}
    turned = element("normalmap", "vector3", **vector, **frame)
    assert evaluate(along + across + turned)[0] == pytest.approx([-y, x, z])


@pytest.mark.parametrize(
    ("body", "lost"),
    [
        (element("add", "float", in3=("float", "1")), "the unknown input in3"),
        (element("blur", "float", size=("float", "1")), "blurring"),
        (element("normalmap", "vector3", space=("string", "object")), "the unknown input space"),
    ],
)
def test_what_nodes_lose_is_said(evaluate, body, lost):
    with pytest.warns(UrushiWarning, match=f"the node 'n'.*{lost} is left out"):
        evaluate(body)


def test_positions_are_placed(evaluate):
    """place2d: p -> R((p - pivot) / scale) - offset + pivot, R clockwise; by hand."""
    body = UV + element(
        "place2d",
        "vector2",
        texcoord=("vector2", "@uv"),
        pivot=("vector2", "0.5, 0.5"),
        scale=("vector2", "2, 4"),
        rotate=("float", "90"),
        offset=("vector2", "0.1, 0.2"),
    )
    x, y = ((POINTS - 0.5) / [2, 4]).T
    assert evaluate(body) == pytest.approx(np.stack([y - 0.1 + 0.5, -x - 0.2 + 0.5], -1))


def test_ramps_and_checkers(evaluate):
    ramp = element("ramplr", "float", valuel=("float", "1"), valuer=("float", "3"))
    assert evaluate(ramp)[:, 0] == pytest.approx(1 + 2 * POINTS[:, 0])
    ramp = element("ramptb", "float", valuet=("float", "1"), valueb=("float", "3"))
    assert evaluate(ramp)[:, 0] == pytest.approx(3 - 2 * POINTS[:, 1])
    board = element("checkerboard", "color3", uvtiling=("vector2", "4, 2"))
    cells = np.floor(POINTS * [4, 2]).sum(-1) % 2
    value = evaluate(board)[:, 0]
    assert len(np.unique(value[cells == 0])) == len(np.unique(value[cells == 1])) == 1
    assert value[cells == 0][0] != value[cells == 1][0]


@pytest.mark.parametrize(
    ("axes", "scale", "gradient", "number"),
    [(2, 0.6616, [1, 2], 8), (3, 0.9820, [0, 1, 1], 12)],
    ids=["plane", "space"],
)
def test_noise_is_gradient_noise(axes, scale, gradient, number):
    """It is 0 on the lattice, where its slopes are one of a few gradients, and random in sign.

    In a plane there are eight, in space the 12 edges of a cube.
    """
    lattice = np.stack(np.meshgrid(*[np.arange(-4.0, 4)] * axes), -1).reshape(-1, axes)
    assert np.allclose(noise.perlin(lattice, 4)[..., :3], 0)
    steps = 1e-6 * np.eye(axes)
    slopes = [noise.perlin(lattice + step, 1) / (scale * 1e-6) for step in steps]
    found = np.unique(np.round(np.concatenate(slopes, -1), 3), axis=0)
    assert np.allclose(np.sort(np.abs(found), -1), gradient, atol=1e-3)
    assert len(found) == number
    nearest = noise.worley(lattice + 0.5, axes, np.zeros(1), 0)  # points in the cells' middles
    assert np.allclose(nearest, [0, 1, 1][:axes])


def test_patterns_in_space_need_a_plane(document):
    """`position` on the plane is (u, v, 0); otherwise the sentence names the option and a tool."""
    body = """<position name="p" type="vector3"/><convert name="n" type="color3">
        <input name="in" type="vector3" nodename="p"/></convert><open_pbr_surface name="s"
        type="surfaceshader"><input name="base_color" type="color3" nodename="n"/>
        </open_pbr_surface>"""
    with pytest.raises(FileError, match="set uv_plane .* or bake it .* command baketextures"):
        read_surface(document(body))
    pixels = read_surface(document(body), resolution=4, uv_plane=True).values["base_color"]
    assert np.allclose(pixels.pixels[0, :, 0], [0.125, 0.375, 0.625, 0.875])
    assert np.allclose(pixels.pixels[:, 0, 1], [0.875, 0.625, 0.375, 0.125])
    assert not pixels.pixels[..., 2].any()


@pytest.mark.parametrize("falloff", ["0.5", "0.8"])
def test_hexagonal_tiles_that_do_not_differ_are_the_image(document, falloff):
    tiled = dict.fromkeys(("rotation", "scale", "offset"), ("float", "0"))
    body = element(
        "hextiledimage",
        "color3",
        file=("filename", "a.exr"),
        tiling=("vector2", "2, 3"),
        falloff=("float", falloff),
        **tiled,
    )
    texture = textured(document, body, 16)
    u = (np.arange(16) + 0.5) / 16
    uv = np.stack(np.meshgrid(u, 1 - u), -1).reshape(-1, 2) * [2, 3]
    expected = sample(PIXELS, uv, Look(), np.zeros(3)).reshape(16, 16, 3)
    assert np.allclose(texture.pixels, expected, atol=1e-6)


@pytest.mark.parametrize(("amount", "unit"), [("90", "degree"), ("1.57079632679", "radian")])
def test_angles_have_units(evaluate, amount, unit):
    body = (
        UV
        + f"""<rotate2d name="n" type="vector2"><input name="in" type="vector2" nodename="uv"/>
        <input name="amount" type="float" value="{amount}" unittype="angle" unit="{unit}"/>
        </rotate2d>"""
    )
    x, y = POINTS.T
    assert np.allclose(evaluate(body), np.stack([y, -x], -1))


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


def test_the_hash_is_jenkins_final():
    """The same steps on Python's integers, for one pair of numbers."""

    def rotate(x, k):
        return ((x << k) | (x >> (32 - k))) & 0xFFFFFFFF

    a = b = c = (0xDEADBEEF + 8 + 13) & 0xFFFFFFFF
    a, b = (a + 5) & 0xFFFFFFFF, (b - 7) & 0xFFFFFFFF
    words = {"a": a, "b": b, "c": c}
    pairs = ["cb", "ac", "ba", "cb", "ac", "ba", "cb"]
    for (target, source), bits in zip(pairs, (14, 11, 25, 16, 4, 14, 24), strict=True):
        words[target] ^= words[source]
        words[target] = (words[target] - rotate(words[source], bits)) & 0xFFFFFFFF
    assert noise.hash_integers(np.array(5), np.array(-7)) == words["c"]


def test_octaves_add_up():
    p = POINTS * 5
    two = noise.fractal(p, 1, 2, np.array([2.0]), np.array([0.5]))
    assert two == pytest.approx(noise.perlin(p, 1) + 0.5 * noise.perlin(2 * p, 1))


def test_cellular_noise_is_a_distance():
    """Its slope is at most 1, the second distance is not below the first, 0 jitter is a grid."""
    p = POINTS * 7
    one, two = noise.worley(p, 2, np.array([1.0]), 0).T
    assert (two >= one).all()
    near = noise.worley(p + np.array([1e-4, 0]), 2, np.array([1.0]), 0)[:, 0]
    assert (np.abs(near - one) <= 1e-4 * (1 + 1e-6)).all()
    grid = noise.worley(p, 1, np.array([0.0]), 0)[:, 0]
    assert grid == pytest.approx(np.linalg.norm(p - np.floor(p) - 0.5, axis=-1))


BASE_COLOR = """<open_pbr_surface name="s" type="surfaceshader">
    <input name="base_color" type="color3" nodename="n"/></open_pbr_surface>"""
PIXELS = np.random.default_rng(3).random((6, 9, 3)).astype(np.float32)


def textured(document, body, resolution=64, pixels=PIXELS):
    """The texture of base_color, which is connected to the node `n`."""
    path = document(body + BASE_COLOR)
    write_image(path.parent / "a.exr", pixels)
    return read_surface(path, resolution=resolution).values["base_color"]


def lookup(texture, uv):
    """Mitsuba's look-up at uv from the upper left corner."""
    from urushi.openpbr_surface.plugins.materialx import mitsuba_value

    bitmap = mi.load_dict(mitsuba_value("base_color", texture))
    si = mi.SurfaceInteraction3f()
    si.uv = mi.Point2f(uv.T)
    return np.array(bitmap.eval(si)).T


@pytest.mark.parametrize("mode", ["periodic", "clamp", "mirror", "repeat"])
@pytest.mark.parametrize("blend", ["linear", "closest"])
def test_an_image_keeps_its_texels_and_its_place(document, llvm, mode, blend):
    """Mitsuba's look-up in the texture is the graph's look-up in the image, at any uv.

    Single precision of uv moves look-ups by 1e-6 of a texel: nearest ones are compared where they
    are a thousandth of a texel from an edge.
    """
    place = UV + element(
        "place2d",
        "vector2",
        "p",
        texcoord=("vector2", "@uv"),
        rotate=("float", "25"),
        scale=("vector2", "0.3, 0.7"),
    )
    image = element(
        "image",
        "color3",
        "i",
        file=("filename", "a.exr"),
        texcoord=("vector2", "@p"),
        uaddressmode=("string", mode),
        vaddressmode=("string", mode),
        filtertype=("string", blend),
    )
    body = place + image + element("multiply", "color3", in1=("color3", "@i"), in2=("float", "0.5"))
    texture = textured(document, body)
    assert isinstance(texture, Texture)
    assert np.allclose(texture.pixels, 0.5 * PIXELS)
    uv = np.random.default_rng(1).random((200, 2)) * 3 - 1
    c, s = np.cos(np.radians(25)), np.sin(np.radians(25))
    x, y = uv[:, 0] / 0.3, (1 - uv[:, 1]) / 0.7
    placed = np.stack([c * x + s * y, c * y - s * x], -1)
    expected = 0.5 * sample(PIXELS, placed, Look(mode, mode, blend == "linear"), np.zeros(3))
    texels = placed * PIXELS.shape[1::-1]
    inside = (np.abs(texels - np.round(texels)) > 1e-3).all(-1)
    assert inside.mean() > 0.98
    kept = slice(None) if blend == "linear" else inside
    np.testing.assert_allclose(lookup(texture, uv)[kept], expected[kept], atol=1e-4)


def test_usd_textures_are_black_outside(document):
    """Whatever their fallback is, where they are asked to be."""
    image = """<dot name="n" type="color3">
        <input name="in" type="color3" nodename="t" output="rgb"/></dot>
        <UsdUVTexture name="t" type="multioutput">
        <input name="file" type="filename" value="a.exr"/>
        <input name="wrapS" type="string" value="black"/>
        <input name="wrapT" type="string" value="black"/>
        <input name="fallback" type="color4" value="1, 1, 1, 1"/>
        <input name="st" type="vector2" nodename="p"/></UsdUVTexture>"""
    scale = ("vector2", "0.5, 0.5")
    place = UV + element("place2d", "vector2", "p", texcoord=("vector2", "@uv"), scale=scale)
    texture = textured(document, place + image, 18)
    assert (texture.pixels[9:, :9] > 0).all()
    assert (texture.pixels[:9] == 0).all() and (texture.pixels[:, 9:] == 0).all()


@pytest.mark.parametrize("file", ['<input name="file" type="filename" value=""/>', ""])
def test_an_image_without_a_file_has_its_default(document, file):
    body = f"""<image name="n" type="color3">{file}
        <input name="default" type="color3" value="0.2, 0.3, 0.4"/></image>"""
    assert textured(document, body) == pytest.approx((0.2, 0.3, 0.4))


def test_tokens_of_file_names_are_replaced(document):
    body = f"""<nodegraph name="g"><token name="Name" type="string" value="a"/>
        {element("image", "color3", "i", file=("filename", "[Name].exr"))}
        <output name="out" type="color3" nodename="i"/></nodegraph>
        <dot name="n" type="color3"><input name="in" type="color3" nodegraph="g"/></dot>"""
    assert np.array_equal(textured(document, body).pixels, PIXELS)


def test_a_pattern_is_computed_on_a_grid(document, llvm):
    """A ramp between pixel centres is linear, so that the interpolated grid is exact there."""
    body = element("ramptb", "color3", valuet=("color3", "1,0,0"), valueb=("color3", "0,0,1"))
    texture = textured(document, body, 32)
    assert texture.pixels.shape == (32, 32, 3)
    uv = np.random.default_rng(1).uniform(1 / 32, 31 / 32, (50, 2))
    up = 1 - uv[:, 1:]
    assert lookup(texture, uv) == pytest.approx(up * [1, 0, 0] + (1 - up) * [0, 0, 1], abs=1e-5)


def test_two_images_are_combined_on_a_grid_of_their_size(document):
    image = element("image", "color3", "i", file=("filename", "a.exr"))
    tiled = element(
        "tiledimage", "color3", "t", file=("filename", "a.exr"), uvtiling=("vector2", "2, 2")
    )
    body = (
        image
        + tiled
        + element("mix", "color3", fg=("color3", "@i"), bg=("color3", "@t"), mix=("float", "0.5"))
    )
    assert textured(document, body, 4).pixels.shape == (9, 9, 3)


def test_a_position_outside_of_the_image_needs_a_grid(document):
    image = element("image", "color3", "i", file=("filename", "a.exr"))
    ramp = element("ramplr", "color3", "r", valuer=("color3", "1,1,1"))
    body = image + ramp + element("multiply", "color3", in1=("color3", "@i"), in2=("color3", "@r"))
    assert textured(document, body, 16).pixels.shape == (16, 16, 3)


def tiff16(pixels):
    """An uncompressed TIFF of 16 bits (Adobe, TIFF 6.0), for integers (height, width, 3)."""
    height, width, channels = pixels.shape
    content = pixels.astype("<u2").tobytes()
    long, bits = 4, 8 + len(content)
    tags = [(256, width), (257, height), (258, bits), (259, 1), (262, 2), (273, 8), (277, channels)]
    tags += [(278, height), (279, len(content))]
    counts = {258: channels}
    entries = b"".join(
        struct.pack("<HHII", tag, 3 if tag == 258 else long, counts.get(tag, 1), x)
        for tag, x in tags
    )
    begin = bits + 2 * channels
    head = struct.pack("<2sHI", b"II", 42, begin)
    depths = struct.pack("<3H", 16, 16, 16)
    return head + content + depths + struct.pack("<H", len(tags)) + entries + bytes(4)


def test_a_tiff_keeps_16_bits(document):
    numbers = np.random.default_rng(0).integers(0, 65536, (3, 4, 3))
    image = element("image", "color3", file=("filename", "a.tif"))
    path = document(image + BASE_COLOR)
    (path.parent / "a.tif").write_bytes(tiff16(numbers))
    pixels = read_surface(path).values["base_color"].pixels
    assert np.allclose(pixels, numbers / 65535, rtol=0, atol=1e-6)


@pytest.mark.parametrize("token", ["&lt;UDIM&gt;", "<UDIM>", "<udim>", "<UVTILE>"])
def test_one_tile_of_a_pattern_is_an_image(document, token):
    """MaterialX's parser reads a bare <. The tile (0, 1) has v from 1 to 2."""
    path = document(element("image", "color3", file=("filename", f"a.{token}.exr")) + BASE_COLOR)
    tile = "u1_v2" if "UV" in token else "1011"
    write_image(path.parent / f"a.{tile}.exr", PIXELS)
    (path.parent / "a.10x1.exr").touch()
    texture = read_surface(path).values["base_color"]
    assert np.array_equal(texture.pixels, PIXELS)
    assert texture.to_uv @ [0.3, -0.4, 1] == pytest.approx([0.3, 0.6, 1])  # from above


@pytest.mark.parametrize("grid", [False, True])
def test_tiles_are_parts_of_one_texture(document, llvm, grid):
    """Tiles of one colour each: by the texels of the files, and on a grid with another pattern.

    The texture has the resolution of the finest tile.
    """
    image = element("image", "color3", "i", file=("filename", "a.<UDIM>.exr"))
    ramp = element("ramplr", "color3", "r", valuer=("color3", "1,1,1"))
    top = "@r" if grid else "0, 0, 0"
    plus = element("plus", "color3", fg=("color3", top), bg=("color3", "@i"), mix=("float", "0"))
    path = document(image + ramp + plus + BASE_COLOR)
    colours = {(0, 0): (0.1, 0.2, 0.3), (2, 0): (0.9, 0.5, 0.2), (1, 1): (0.3, 0.7, 0.8)}
    for (u, v), colour in colours.items():
        tile = np.full((4, 4 if v else 2, 3), colour)
        write_image(path.parent / f"a.{1001 + u + 10 * v}.exr", tile)
    texture = read_surface(path, resolution=8).values["base_color"]
    assert texture.pixels.shape == ((24, 24, 3) if grid else (8, 12, 3))
    for (u, v), colour in colours.items():
        found = lookup(texture, np.array([[u + 0.5, 0.5 - v]]))[0]
        assert found == pytest.approx(colour, abs=1e-6)
    write_image(path.parent / "a.1002.exr", np.zeros((3, 2, 3)))
    with pytest.raises(FileError, match="has tiles whose sizes are no multiples; make them equal"):
        read_surface(path)


def test_colours_of_images_are_converted(document):
    body = '<image name="n" type="color3"><input name="file" type="filename" value="a.exr" '
    body += 'colorspace="srgb_texture"/></image>'
    texture = textured(document, body, pixels=0.5 + 0.5 * PIXELS[..., :1])
    grey = (0.5 + 0.5 * PIXELS[..., :1] + 0.055) / 1.055
    assert np.allclose(texture.pixels, grey**2.4, atol=5e-5)  # OpenColorIO's power
    assert textured(document, body, pixels=np.full((6, 9, 1), 1.0)) == (1, 1, 1)  # a constant


def test_normal_maps_are_in_the_tangent_frame(document):
    body = """<image name="i" type="vector3">
        <input name="file" type="filename" value="a.exr"/></image>
        <normalmap name="n" type="vector3"><input name="in" type="vector3" nodename="i"/>
        </normalmap><open_pbr_surface name="s" type="surfaceshader">
        <input name="geometry_normal" type="vector3" nodename="n"/></open_pbr_surface>"""
    path = document(body)
    unit = PIXELS * [1, 1, 0.5] + [0, 0, 0.5]
    unit = 2 * unit - 1
    unit /= np.linalg.norm(unit, axis=-1, keepdims=True)
    write_image(path.parent / "a.exr", 0.5 * unit + 0.5)
    texture = read_surface(path).values["geometry_normal"]
    assert np.allclose(texture.pixels, 0.5 * unit + 0.5, atol=1e-6)


def test_directions_in_space_are_refused(document):
    shader = """<constant name="c" type="vector3"><input name="value" type="vector3" value="1,0,1"/>
        </constant><open_pbr_surface name="s" type="surfaceshader">
        <input name="geometry_normal" type="vector3" nodename="c"/></open_pbr_surface>"""
    with pytest.raises(FileError, match="geometry_normal is a constant direction in space"):
        read_surface(document(shader))
