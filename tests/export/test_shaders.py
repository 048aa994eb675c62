"""Exported files, run in their languages, agree with `Material`."""

import re
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from tests.export import gpu

from urushi.errors import ParameterError
from urushi.export.program import codes_text, template_text, texture_form
from urushi.export.rest import basis_texture
from urushi.material import Material

#: Relative difference of lobes and pdf: some roundings of single precision.
TOLERANCE = 1e-5

#: pdf of turned materials: turned directions are rounded to 1e-7, and slopes of the half vector of
#: 0.01 are then good to 1e-5. `Material.pdf` itself is no better.
TURNED_TOLERANCE = 1e-4

#: f: its table has half precision, which a basis has in `Material`, too; a coordinate w near one
#: is good to the root of single precision, 3e-4, in all languages. Graphics drivers may place
#: samples in steps of 1/256 of a node's distance, over which these tables change by 0.5 %.
TABLE_TOLERANCE, MEDIAN_TOLERANCE = 7e-3, 5e-4

#: The density at a drawn direction changes with the direction's last digits, the more the
#: narrower the lobe.
DRAWN_TOLERANCE = 1e-3

#: f with wi and wo exchanged: the same bits, except where compilers may reorder a product.
EXCHANGE_TOLERANCE = {"python": 0.0} | dict.fromkeys(("glsl", "wgsl", "hlsl", "slang"), 1e-6)

SHADERS = ("glsl", "wgsl", "hlsl", "slang")
LANGUAGES = ("python", *SHADERS)
KINDS = (
    "three lobes", "one lobe", "no lobe", "no rest", "grey", "edges", "grey edges", "table",
    "table beside lobe", "brushed lobes", "brushed lobe", "brushed grey", "brushed edges",
)  # fmt: skip

#: Those that are run in all languages.
SPECIAL = "three lobes", "grey", "edges", "brushed lobes"

#: Mirror images at the planes of the tangent and of the bitangent, and half a turn.
MIRRORS = ((1, -1, 1), (-1, 1, 1), (-1, -1, 1))

DIRECTIONS = np.s_[:, :3], np.s_[:, 4:7], np.s_[:, 8:11]


def run(language: str, text: str, rows: np.ndarray, texture: np.ndarray | None) -> np.ndarray:
    """As `gpu.run`, in Python too."""
    if language != "python":
        return gpu.run(language, text, rows, texture)
    exported = ModuleType("exported")
    exec(text, exported.__dict__)
    first = (exported.material(),) if hasattr(exported, "material") else ()  # a filled template
    last = () if texture is None else (texture,)
    wi, wo, u = (rows[columns] for columns in DIRECTIONS)
    direction, density = exported.sample(*first, wi, u)
    pdf = exported.pdf(*first, wi, wo)
    return np.column_stack([exported.f(*first, wi, wo, *last), pdf, direction, density])


def close(value: np.ndarray, expected: np.ndarray, tolerance: float) -> bool:
    """Whether values agree to a relative tolerance, zeros exactly."""
    return bool((np.abs(value - expected) <= tolerance * np.abs(expected)).all())


def check(language: str, text: str, material: Material, rows: np.ndarray, basis=None) -> None:
    """Whether a file evaluates and samples a material as `Material` does, and is reciprocal.

    basis: the texture that the file reads; None: the material's own.
    """
    texture = material.shader_texture(language) if basis is None else basis
    wi, wo, u = (rows[columns] for columns in DIRECTIONS)
    result = run(language, text, rows, texture)
    f, pdf, direction, density = np.split(result, (3, 4, 7), axis=1)
    expected = material.f(wi, wo)
    assert close(f, expected, TOLERANCE if texture is None else TABLE_TOLERANCE)
    assert close(np.median(f, axis=0), np.median(expected, axis=0), MEDIAN_TOLERANCE)
    assert (f[(wi[:, 2] <= 0) | (wo[:, 2] <= 0)] == 0).all()
    turned = TURNED_TOLERANCE if material.rotation else TOLERANCE
    assert close(pdf[:, 0], material.pdf(wi, wo), turned)
    assert np.abs(direction - material.sample(wi, u)[0]).max() < 1e-4
    assert close(density[:, 0], material.pdf(wi, direction), DRAWN_TOLERANCE)
    swapped = rows.copy()
    swapped[:, :3], swapped[:, 4:7] = wo, wi
    again = run(language, text, swapped, texture)[:, :3]
    assert close(again, f, EXCHANGE_TOLERANCE[language])


def basis_of(model, language: str = "glsl") -> np.ndarray:
    """The texture of all codes."""
    return basis_texture(model, texture_form(language))


@pytest.mark.parametrize(
    ("language", "kind"),
    [("python", kind) for kind in KINDS]
    + [(language, kind) for language in SHADERS for kind in SPECIAL],
)
def test_material(materials, rows, language, kind):
    check(language, materials[kind].shader(language), materials[kind], rows)


def test_only_materials_with_edges_have_their_formula(materials):
    for kind in KINDS:
        assert ("_transmittance(" in materials[kind].shader("glsl")) == ("edges" in kind)


@pytest.mark.parametrize("language", LANGUAGES)
def test_mirror_images_have_the_same_values(materials, rows, language):
    """Every operation on a component of one sign is the same on that of the other."""
    material = materials["brushed lobe"]
    text, texture = material.shader(language), material.shader_texture(language)
    images = np.tile(rows, (1 + len(MIRRORS), 1, 1))
    for image, mirror in zip(images[1:], MIRRORS, strict=True):
        image[:, :3] *= mirror
        image[:, 4:7] *= mirror
    values = run(language, text, images.reshape(-1, rows.shape[1]), texture)[:, :4]
    values = values.reshape(len(images), len(rows), 4)
    np.testing.assert_array_equal(values, np.broadcast_to(values[0], values.shape))


@pytest.mark.parametrize("kind", ["three lobes", "edges", "brushed lobes", "brushed edges"])
@pytest.mark.parametrize("language", LANGUAGES)
def test_templates_with_codes_and_tangent_filled_in(materials, rows, language, kind):
    material = materials[kind]
    check(language, filled(language, material), material, rows, basis_of(material.model))


@pytest.mark.parametrize("language", [*LANGUAGES, "osl"])
def test_templates_begin_with_the_code_of_all_materials(model, anisotropic_model, language):
    for each in (model, anisotropic_model):
        code, template = (
            text[re.search(r"^(struct|class) ", text, re.MULTILINE).start() :]
            for text in (codes_text(language, each, "urushi"), template_text(language, each))
        )
        assert template.startswith(code)


def filled(language: str, material: Material) -> str:
    """The template of a language with the codes and the tangent of a material."""
    text, turn = template_text(language, material.model), np.radians(material.rotation)
    names = {
        f"code_{i}_{channel}": number
        for i, numbers in enumerate(material.latents.T)
        for channel, number in zip(("red", "green", "blue"), numbers, strict=True)
    }
    if material.model.widths == 2:
        names |= {"code_tangent_x": np.cos(turn), "code_tangent_y": np.sin(turn)}
    for label, number in names.items():
        text, count = re.subn(rf"\b{label}\b", f"{float(number)!r}", text)
        assert count == 1
    return text


def test_prefixes_allow_several_materials_in_one_shader(materials, rows):
    material = materials["one lobe"]
    other = materials["three lobes"].shader("glsl", "car_paint")
    assert "car_paint_f(" in other and "CarPaintSample" in other and "urushi_" not in other
    check("glsl", other + material.shader("glsl"), material, rows)


@pytest.mark.parametrize("compiler", ["tint", "naga"])
def test_wgsl_is_valid_for_browsers(materials, tmp_path, compiler):
    end = "\n@fragment fn main() -> @location(0) vec4f { return vec4f(1.0); }\n"
    gpu.check_wgsl(compiler, materials["edges"].shader("wgsl") + end, tmp_path)


def test_example_of_the_page(materials):
    page = (Path(__file__).parents[2] / "docs" / "export.md").read_text()
    (block,) = re.findall(r"^```python\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    exec(block, {"coated": materials["three lobes"]})


def test_errors_name_the_cure(model, materials):
    material = materials["one lobe"]
    for exported in (material.shader, material.shader_texture):
        for language in ("cg", ["glsl"]):
            with pytest.raises(ParameterError, match="there is no language '.*'; choose one of "):
                exported(language)
    for prefix in ("a b", "", "1a", "_a", "a_", "a__b", "gl", "gl_a", None):
        with pytest.raises(ParameterError, match=f"'{prefix}' is not a valid prefix of function"):
            material.shader("glsl", prefix)
    two = Material(material.latents[:2], model)
    with pytest.raises(ParameterError, match="has 2 channels; only materials of one or three"):
        two.shader("glsl")
