"""Exported files of anisotropic networks agree with `Material`; their tangent turns."""

import numpy as np
import pytest
from tests.export.test_shaders import (
    SHADERS,
    TABLE_TOLERANCE,
    TURNED_TOLERANCE,
    basis_of,
    check,
    close,
    filled,
    module,
    run,
)

from urushi.export.program import codes_text

#: Mirror images at the planes of the tangent and of the bitangent, and half a turn.
MIRRORS = ((1, -1, 1), (-1, 1, 1), (-1, -1, 1))


@pytest.mark.parametrize("kind", ["three lobes", "one lobe", "grey", "edges"])
def test_material_in_python(anisotropic_materials, rows, kind):
    material = anisotropic_materials[kind]
    check("python", material.shader("python"), material, rows)


@pytest.mark.parametrize("language", ["python", *SHADERS])
def test_turned_material(anisotropic_materials, rows, language):
    material = anisotropic_materials["turned"]
    check(language, material.shader(language), material, rows)


@pytest.mark.parametrize("kind", ["three lobes", "edges"])
@pytest.mark.parametrize("language", ["python", *SHADERS])
def test_templates_with_codes_and_tangent_filled_in(
    anisotropic_model, anisotropic_materials, rows, language, kind
):
    material = anisotropic_materials[kind].rotated(40)
    check(language, filled(language, material), material, rows, basis_of(anisotropic_model))


@pytest.mark.parametrize("language", ["python", *SHADERS])
def test_mirror_images_have_the_same_values(anisotropic_materials, rows, language):
    """Every operation on a component of one sign is the same on that of the other."""
    material = anisotropic_materials["one lobe"]
    text, texture = material.shader(language), material.shader_texture(language)
    images = np.tile(rows, (1 + len(MIRRORS), 1, 1))
    for image, mirror in zip(images[1:], MIRRORS, strict=True):
        image[:, :3] *= mirror
        image[:, 4:7] *= mirror
    values = run(language, text, images.reshape(-1, rows.shape[1]), texture)[:, :4]
    values = values.reshape(len(images), len(rows), 4)
    np.testing.assert_array_equal(values, np.broadcast_to(values[0], values.shape))


def test_the_tangent_of_a_prepared_material_turns(anisotropic_model, anisotropic_materials, rows):
    material = anisotropic_materials["three lobes"]
    exported = module(codes_text("python", anisotropic_model, "urushi"))
    prepared = exported.prepare(material.latents.T[:, None])
    turn = np.radians(75)
    prepared.tangent_x, prepared.tangent_y = np.float32(np.cos(turn)), np.float32(np.sin(turn))
    wi, wo = rows[:, :3], rows[:, 4:7]
    turned = material.rotated(75)
    f = exported.f(prepared, wi, wo, basis_of(anisotropic_model))
    assert close(f, turned.f(wi, wo), TABLE_TOLERANCE)
    assert close(exported.pdf(prepared, wi, wo), turned.pdf(wi, wo), TURNED_TOLERANCE)
