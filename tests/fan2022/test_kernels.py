"""The paper's networks in the plugins."""

import fan2022
import numpy as np
import pytest
from fan2022 import Material, load
from fan2022.texels import CodeTexture, choose
from tests.directions import pairs_above
from tests.mitsuba import probes

import urushi
from urushi.errors import ParameterError, UrushiWarning
from urushi.mitsuba.reading import probing
from urushi.textures.store import ONE_TEXEL, TexelGrid

PAIRS = pairs_above(16, 1, 0.1)


@pytest.fixture(scope="module")
def material(paper):
    return Material(1 + 0.1 * np.random.default_rng(7).normal(size=(3, 32)), paper)


@pytest.fixture
def saved(material, weights, tmp_path):
    """The parameters of the plugin `fan2022_brdf` for the material."""
    material.save(tmp_path / "material.safetensors")
    return {"filename": str(tmp_path / "material.safetensors"), "weights": str(weights)}


@pytest.fixture
def layered(rgb, weights):
    """The plugin `fan2022_layered` of parameters."""
    described = {"type": "fan2022_layered", "weights": str(weights)}
    return lambda **parameters: rgb.load_dict(described | parameters)


def test_a_saved_material_is_that_of_python(rgb, material, saved):
    """Values, densities, and samples of the same uniform numbers; one proposal is nearly flat."""
    bsdf, rng = rgb.load_dict({"type": "fan2022_brdf", **saved}), np.random.default_rng(8)
    wi, wo = PAIRS
    np.testing.assert_allclose(probes.f(bsdf, wi, wo), material.f(wi, wo), rtol=1e-3, atol=1e-4)
    si, u = probing.interaction(wi, np.zeros((16, 2))), rng.random((16, 3)).astype(np.float32)
    pdf = bsdf.pdf(rgb.BSDFContext(), si, probes.vector(wo))
    np.testing.assert_allclose(pdf.numpy(), material.pdf(wi, wo), rtol=1e-3)
    numbers = rgb.Float(u[:, 0]), rgb.Point2f(*map(rgb.Float, u[:, 1:].T))
    drawn, _ = bsdf.sample(rgb.BSDFContext(), si, *numbers)
    gaussian = u[:, 0] < material._proposal().share  # cosine lobes warp the unit square otherwise
    expected, density = material.sample(wi, u)
    assert gaussian.sum() > 4
    np.testing.assert_allclose(drawn.wo.numpy().T[gaussian], expected[gaussian], atol=1e-4)
    np.testing.assert_allclose(drawn.pdf.numpy()[gaussian], density[gaussian], rtol=1e-3)


SCENE = """<scene version="3.0.0">
    <integrator type="path"/>
    <sensor type="orthographic"><film type="hdrfilm">
        <integer name="width" value="8"/><integer name="height" value="8"/>
    </film></sensor>
    <shape type="sphere"><bsdf type="twosided"><bsdf type="fan2022_brdf">
        <string name="filename" value="{filename}"/><string name="weights" value="{weights}"/>
    </bsdf></bsdf></shape>
</scene>"""


def test_the_command_renders_in_separate_kernels(rgb, saved, tmp_path, monkeypatch):
    """A kernel of a whole path takes minutes to compile."""
    import drjit as dr
    from fan2022 import __main__ as command

    (tmp_path / "a.xml").write_text(SCENE.format(**saved))
    rays = []

    def render(scene, spp, **_):
        assert not dr.flag(dr.JitFlag.SymbolicLoops)
        assert not dr.flag(dr.JitFlag.SymbolicCalls)
        rays.append(64 * spp)
        scene.sensors()[0].film().prepare([])
        return rgb.TensorXf(np.ones((8, 8, 3), np.float32))

    monkeypatch.setattr(rgb, "render", render)
    assert command.main(["render", str(tmp_path / "a.xml"), "--spp", "3000"]) == 0
    assert sum(rays) == 64 * 3000 and max(rays) <= command.Render.RAYS
    assert dr.flag(dr.JitFlag.SymbolicLoops)


def test_a_warning_names_the_cure_if_a_path_is_recorded(rgb, saved):
    import drjit as dr

    bsdf = rgb.load_dict({"type": "fan2022_brdf", **saved})
    assert str(bsdf) == f"PaperBRDF[filename = {saved['filename']}]"
    si = dr.zeros(rgb.SurfaceInteraction3f)
    si.wi = rgb.Vector3f(0, 0, 1)

    def body(i, total):  # recorded, never computed
        return i + 1, total + bsdf.eval(rgb.BSDFContext(), si, rgb.Vector3f(0, 0, 1)).x

    start = rgb.UInt32(0, 1), rgb.Float(0, 0)
    with pytest.warns(UrushiWarning, match=r"or within `fan2022.separate_kernels"):
        dr.while_loop(start, lambda i, _: i < 2, body)


def test_a_constant_coat_is_that_of_the_functions(rgb, layered, paper, tmp_path):
    bottom = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.2, 0.4, 0.6]}}
    top, medium = urushi.dielectric(0.2, 1.5), {"albedo": 0.5, "sigma_t": 1.0}
    coat = {"alpha": 0.2, "int_ior": 1.5, "ext_ior": 1.0, **medium}
    bsdf = layered(bottom=layered(bottom=bottom, **coat), **coat)
    expected = fan2022.encode(urushi.diffuse((0.2, 0.4, 0.6)), paper)
    for _ in range(2):
        expected = fan2022.layer(top, expected, **medium)
    # Mitsuba's values of the bottom are those of the description but for rounding.
    f = probes.f(bsdf, *PAIRS)
    np.testing.assert_allclose(f, expected.f(*PAIRS), rtol=1e-2, atol=1e-3)
    bsdf.save(tmp_path / "coated.safetensors")
    read = load(tmp_path / "coated.safetensors", paper)
    np.testing.assert_allclose(read.latents, bsdf.codes.codes[0])
    rgb.traverse(bsdf).update({"alpha.value": 0.5})
    assert np.abs(bsdf.codes.codes[0] - expected.latents).max() > 1e-3


def test_a_texture_has_the_constant_coats_of_its_texels(rgb, layered):
    texels = np.array([[[0.2], [0.8]]], np.float32)

    def bsdf(value):
        bottom = {"type": "diffuse", "reflectance": value}
        return layered(bottom=bottom, alpha=0.3, albedo=0.5, sigma_t=value)

    bitmap = {"type": "bitmap", "bitmap": rgb.Bitmap(texels), "raw": True, "filter_type": "nearest"}
    textured = bsdf(bitmap)
    for texel, value in enumerate((0.2, 0.8)):
        one = bsdf(value)
        f = probes.f(textured, *PAIRS, (0.25 + 0.5 * texel, 0.5))
        np.testing.assert_allclose(f, probes.f(one, *PAIRS), rtol=1e-2, atol=1e-3)
    with pytest.raises(ParameterError, match="textures of its codes cannot be saved"):
        textured.save("nowhere")


def test_mip_levels_are_means_of_codes(rgb, paper):
    """At a footprint of 2^k texels, the code is the mean of 2^k x 2^k texels, or of all.

    Of every level, the texel that is drawn there is the first.
    """
    codes = np.random.default_rng(4).normal(size=(32, 1, 32)).astype(np.float32)
    texture = CodeTexture(paper, codes, TexelGrid(8, 4), mipmaps=True)
    si = probing.interaction(np.array([[0.0, 0.0, 1.0]]), np.array([[0.06, 0.12]]))
    grid = codes.reshape(4, 8, 32)
    whole = grid.mean((0, 1))
    means = {0.5: grid[0, 0], 2: grid[:2, :2].mean((0, 1)), 4: grid[:, :4].mean((0, 1))}
    for size, mean in {**means, 8: whole, 99: whole}.items():
        si.duv_dx, si.duv_dy = rgb.Vector2f(size / 8, 0), rgb.Vector2f(0, size / 16)
        found = np.array([z.numpy() for z in texture.vertex(si)[0]]).ravel()
        np.testing.assert_allclose(found, mean, atol=1e-5)
    odd = CodeTexture(paper, codes[:15], TexelGrid(5, 3), mipmaps=True)
    found = np.array([z.numpy() for z in odd.vertex(si)[0]]).ravel()
    np.testing.assert_allclose(found, codes[:15].mean((0, 1)), atol=1e-5)


def test_the_grid_resolves_all_textures_over_uv(rgb):
    def bitmap(height, width, *factors):
        pixels = np.random.default_rng(0).random((height, width, 1), np.float32)
        place = rgb.ScalarTransform3f(np.diag(np.float32([*factors, 1])))
        return rgb.load_dict(
            {"type": "bitmap", "bitmap": rgb.Bitmap(pixels), "raw": True, "to_uv": place}
        )

    parts = {"alpha": bitmap(4, 6, 3, 1), "albedo": bitmap(5, 2, 1, 2)}
    assert choose(parts, ONE_TEXEL, 0, "test") == TexelGrid(18, 10)
    assert choose(parts, TexelGrid(30, 4), 0, "test") == TexelGrid(30, 10)
    assert choose(parts, ONE_TEXEL, 9, "test") == TexelGrid(9, 9)
    constant = rgb.load_dict({"type": "uniform", "value": 0.5})
    assert choose({"alpha": constant}, ONE_TEXEL, 9, "test") == ONE_TEXEL
    attribute = rgb.load_dict({"type": "mesh_attribute", "name": "vertex_color"})
    with pytest.raises(ParameterError, match="depends on a mesh attribute"):
        choose({"albedo": attribute}, ONE_TEXEL, 0, "test")


@pytest.mark.parametrize(
    ("extra", "sentence"),
    [
        ({"alpha_u": 0.1, "alpha_v": 0.2}, "the networks are for isotropic lobes"),
        ({"rotation": 30.0}, "the networks are for isotropic lobes"),
        ({"int_ior": 1.0, "ext_ior": 1.5}, "cover indices above 1 only"),
    ],
)
def test_scenes_that_it_cannot_render_are_refused(layered, extra, sentence):
    with pytest.raises(RuntimeError, match=sentence):
        layered(bottom={"type": "diffuse"}, **extra)


def test_missing_weights_are_named(rgb):
    with pytest.raises(RuntimeError, match="has no weights; give a file"):
        rgb.load_dict({"type": "fan2022_layered", "bottom": {"type": "diffuse"}})
