"""Images and patterns as textures: texels, places, tiles, grids and normal maps."""

import mitsuba as mi
import numpy as np
import pytest
from tests.openpbr_surface.materialx.conftest import element, write_image
from tests.openpbr_surface.materialx.test_nodes import UV

from urushi.errors import FileError
from urushi.openpbr_surface.materialx import baking
from urushi.openpbr_surface.materialx.images import sample
from urushi.openpbr_surface.materialx.surface import read_surface
from urushi.openpbr_surface.plugins.materialx import mitsuba_value

PIXELS = np.random.default_rng(3).random((6, 9, 3)).astype(np.float32)
FILE = ("filename", "a.exr")
IMAGE = element("image", "color3", "i", file=FILE)
RAMP = element("ramplr", "color3", "r", valuer=(1, 1, 1))
SHADER = "open_pbr_surface", "surfaceshader", "s"
BASE_COLOR = element(*SHADER, base_color=("color3", "@n"))
NORMAL = element(*SHADER, geometry_normal=("vector3", "@n"))


@pytest.fixture
def textured(document):
    """A function: the only parameter of a document, of the node `n`, which may read a.exr."""

    def value(body, resolution=64, pixels=PIXELS, shader=BASE_COLOR, **options):
        path = document(body + shader)
        write_image(path.parent / "a.exr", pixels)
        (value,) = read_surface(path, resolution=resolution, **options).values.values()
        return value

    return value


def lookup(texture, uv):
    """Mitsuba's look-up at uv from the upper left corner."""
    bitmap = mi.load_dict(mitsuba_value("base_color", texture))
    si = mi.SurfaceInteraction3f()
    si.uv = mi.Point2f(uv.T)
    return np.array(bitmap.eval(si)).T


@pytest.mark.parametrize("mode", ["periodic", "clamp", "mirror", "repeat"])
@pytest.mark.parametrize("blend", ["linear", "closest"])
def test_an_image_keeps_its_texels_and_its_place(textured, rgb, mode, blend):
    """Mitsuba's look-up in the texture is the graph's look-up in the image, at any uv.

    Single precision of uv moves look-ups by 1e-6 of a texel: nearest ones are compared where they
    are a thousandth of a texel from an edge.
    """
    place = {"rotate": 25.0, "scale": ("vector2", "0.3, 0.7")}
    look = {f"{axis}addressmode": ("string", mode) for axis in "uv"}
    body = UV + element("place2d", "vector2", "p", texcoord=("vector2", "@uv"), **place)
    look |= {"texcoord": ("vector2", "@p"), "filtertype": ("string", blend)}
    body += element("image", "color3", "i", file=FILE, **look)
    body += element("multiply", "color3", in1=("color3", "@i"), in2=0.5)
    texture = textured(body)
    assert np.allclose(texture.pixels, 0.5 * PIXELS)
    uv = np.random.default_rng(1).random((200, 2)) * 3 - 1
    c, s = np.cos(np.radians(25)), np.sin(np.radians(25))
    x, y = uv[:, 0] / 0.3, (1 - uv[:, 1]) / 0.7
    placed = np.stack([c * x + s * y, c * y - s * x], -1)
    expected = 0.5 * sample(PIXELS, placed, (mode, mode), blend == "linear")
    texels = placed * PIXELS.shape[1::-1]
    inside = (np.abs(texels - np.round(texels)) > 1e-3).all(-1)
    assert inside.mean() > 0.98
    kept = slice(None) if blend == "linear" else inside
    np.testing.assert_allclose(lookup(texture, uv)[kept], expected[kept], atol=1e-4)


def test_usd_textures_are_black_outside(textured):
    """Whatever their fallback is, where they are asked to be."""
    scale = ("vector2", "0.5, 0.5")
    body = UV + element("place2d", "vector2", "p", texcoord=("vector2", "@uv"), scale=scale)
    black = {f"wrap{axis}": ("string", "black") for axis in "ST"}
    black |= {"fallback": ("color4", "1, 1, 1, 1"), "st": ("vector2", "@p")}
    body += element("UsdUVTexture", "multioutput", "t", file=FILE, **black)
    body += element("dot", "color3", in_=("color3", 'nodename="t" output="rgb"'))
    pixels = textured(body, 18).pixels
    assert (pixels[9:, :9] > 0).all()
    assert (pixels[:9] == 0).all() and (pixels[:, 9:] == 0).all()


@pytest.mark.parametrize("file", [{"file": ("filename", "")}, {}])
def test_an_image_without_a_file_has_its_default(textured, file):
    body = element("image", "color3", **file, default=(0.2, 0.3, 0.4))
    assert textured(body) == pytest.approx((0.2, 0.3, 0.4))


def test_tokens_of_file_names_are_replaced(textured):
    body = f"""<nodegraph name="g"><token name="Name" type="string" value="a"/>
        {element("image", "color3", "i", file=("filename", "[Name].exr"))}
        <output name="out" type="color3" nodename="i"/></nodegraph>
        <dot name="n" type="color3"><input name="in" type="color3" nodegraph="g"/></dot>"""
    assert np.array_equal(textured(body).pixels, PIXELS)


def test_a_pattern_is_computed_on_a_grid(textured, rgb):
    """A ramp between pixel centres is linear, so that the interpolated grid is exact there."""
    body = element("ramptb", "color3", valuet=(1, 0, 0), valueb=(0, 0, 1))
    texture = textured(body, 32)
    assert texture.pixels.shape == (32, 32, 3)
    uv = np.random.default_rng(1).uniform(1 / 32, 31 / 32, (50, 2))
    up = 1 - uv[:, 1:]
    assert lookup(texture, uv) == pytest.approx(up * [1, 0, 0] + (1 - up) * [0, 0, 1], abs=1e-5)


@pytest.mark.parametrize(
    ("other", "resolution", "side"),
    [
        (element("tiledimage", "color3", "r", file=FILE, uvtiling=("vector2", "2, 2")), 4, 9),
        (RAMP, 16, 16),
    ],
    ids=["two images", "an image and a position"],
)
def test_combinations_are_computed_on_a_grid(textured, other, resolution, side):
    """As large as the images, or as asked for."""
    body = IMAGE + other + element("multiply", "color3", in1=("color3", "@i"), in2=("color3", "@r"))
    assert textured(body, resolution).pixels.shape == (side, side, 3)


def test_grids_are_computed_in_parts_of_any_size(textured, monkeypatch):
    """The last part of 65^2 points, of 64 at once, is one point."""
    body = IMAGE + RAMP + element("multiply", "color3", in1=("color3", "@i"), in2=("color3", "@r"))
    whole = textured(body, 65).pixels
    monkeypatch.setattr(baking, "MEMORY", 0)
    assert np.array_equal(textured(body, 65).pixels, whole)


def test_patterns_in_space_need_a_plane(textured):
    """`position` on the plane is (u, v, 0); otherwise the sentence names the option and a tool."""
    body = element("position", "vector3", "p") + element("convert", "color3", in_=("vector3", "@p"))
    with pytest.raises(FileError, match="set uv_plane .* or bake it .* command baketextures"):
        textured(body)
    u = [0.125, 0.375, 0.625, 0.875]
    pixels = textured(body, 4, uv_plane=True).pixels
    assert np.allclose(pixels, np.stack([*np.meshgrid(u, u[::-1]), np.zeros((4, 4))], -1))


@pytest.mark.parametrize("falloff", [0.5, 0.8, "@r"])
def test_hexagonal_tiles_that_do_not_differ_are_the_image(textured, falloff):
    options = dict.fromkeys(("rotation", "scale", "offset"), 0.0)
    options |= {"tiling": ("vector2", "2, 3"), "falloff": falloff}
    ramp = element("ramplr", "float", "r", valuer=1.0)
    texture = textured(ramp + element("hextiledimage", "color3", file=FILE, **options), 16)
    u = (np.arange(16) + 0.5) / 16
    uv = np.stack(np.meshgrid(u, 1 - u), -1).reshape(-1, 2) * [2, 3]
    assert np.allclose(texture.pixels, sample(PIXELS, uv).reshape(16, 16, 3), atol=1e-6)


def test_a_tiff_keeps_16_bits(document):
    numbers = np.random.default_rng(0).integers(0, 65536, (3, 4, 3))
    path = document(element("image", "color3", file=("filename", "a.tif")) + BASE_COLOR)
    write_image(path.parent / "a.tif", numbers / 65535, "uint16")
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
def test_tiles_are_parts_of_one_texture(document, rgb, grid):
    """Tiles of one colour each: by the texels of the files, and on a grid with another pattern.

    The texture has the resolution of the finest tile.
    """
    image = element("image", "color3", "i", file=("filename", "a.<UDIM>.exr"))
    top = "@r" if grid else "0, 0, 0"
    plus = element("plus", "color3", fg=("color3", top), bg=("color3", "@i"), mix=0.0)
    path = document(image + RAMP + plus + BASE_COLOR)
    colours = {(0, 0): (0.1, 0.2, 0.3), (2, 0): (0.9, 0.5, 0.2), (1, 1): (0.3, 0.7, 0.8)}
    for (u, v), colour in colours.items():
        tile = np.full((4, 4 if v else 2, 3), colour)
        write_image(path.parent / f"a.{1001 + u + 10 * v}.exr", tile)
    texture = read_surface(path, resolution=8).values["base_color"]
    assert texture.pixels.shape == ((24, 24, 3) if grid else (8, 12, 3))
    uv = np.array([[u + 0.5, 0.5 - v] for u, v in colours])
    assert lookup(texture, uv) == pytest.approx(np.array([*colours.values()]), abs=1e-6)
    write_image(path.parent / "a.1002.exr", np.zeros((3, 2, 3)))
    with pytest.raises(FileError, match="has tiles whose sizes are no multiples; make them equal"):
        read_surface(path)


def test_colours_of_images_are_converted(textured):
    file = ("filename", 'value="a.exr" colorspace="srgb_texture"')
    body = element("image", "color3", file=file)
    grey = 0.5 + 0.5 * PIXELS[..., :1]
    linear = ((grey + 0.055) / 1.055) ** 2.4
    assert np.allclose(textured(body, pixels=grey).pixels, linear, atol=5e-5)  # OpenColorIO's power
    assert textured(body, pixels=np.ones((6, 9, 1))) == (1, 1, 1)  # a constant


def test_normal_maps_are_in_the_tangent_frame(textured):
    body = element("image", "vector3", "i", file=FILE)
    body += element("normalmap", "vector3", in_=("vector3", "@i"))
    unit = 2 * PIXELS * [1, 1, 0.5] + [-1, -1, 0]
    stored = 0.5 * unit / np.linalg.norm(unit, axis=-1, keepdims=True) + 0.5
    for part in (stored, stored[:1, :1]):  # of one pixel, too
        assert np.allclose(textured(body, pixels=part, shader=NORMAL).pixels, part, atol=1e-6)
