"""Stacks of one coat, written as OpenPBR and read again."""

import numpy as np
import pytest
from tests.openpbr_surface.materialx.test_shaders import widths

import urushi
from urushi.errors import ParameterError
from urushi.openpbr_surface.description import save_materialx
from urushi.openpbr_surface.materialx.surface import read_surface
from urushi.openpbr_surface.parameters import complete

GOLD = urushi.conductor(alpha=0.3, r0=(0.98, 0.77, 0.34))
BRUSHED = urushi.conductor(alpha_u=0.4, alpha_v=0.1, r0=0.9)
RED = urushi.diffuse((0.7, 0.1, 0.05))


@pytest.mark.parametrize("bottom", [GOLD, BRUSHED, RED])
@pytest.mark.parametrize(
    "coat",
    [
        {"alpha": 0.05, "eta": 1.6},
        {"alpha": 0.25, "eta": 1.5, "sigma_t": (0.1, 0.5, 2.0)},
        {"alpha_u": 0.5, "alpha_v": 0.2, "eta": 1.3, "sigma_t": 1.0},
    ],
)
def test_a_stack_becomes_the_same_material(tmp_path, bottom, coat):
    """Widths, colours and index of OpenPBR's definition; equal but for the rounding of roots."""
    stack = urushi.coat(bottom, **coat)
    path = tmp_path / "stack.mtlx"
    save_materialx(stack, path, "Lacquer")
    surface = read_surface(path)
    assert surface.name == "Lacquer"
    values, described = complete(surface.values), stack.coats[0]
    assert values["coat_weight"] == 1
    assert widths(values, "coat") == pytest.approx((described.alpha_u, described.alpha_v))
    assert values["coat_ior"] == described.eta
    # Light crosses the coat twice at normal incidence (Beer-Lambert).
    twice = np.exp(-2 * np.broadcast_to(described.sigma_t, 3))
    assert values["coat_color"] == pytest.approx(twice)
    if bottom is RED:
        assert (values["base_metalness"], values["specular_weight"]) == (0, 0)
        assert values["base_color"] == pytest.approx(bottom.reflectance)
    else:
        assert (values["base_metalness"], values["specular_weight"]) == (1, 1)
        assert widths(values, "specular") == pytest.approx((bottom.alpha_u, bottom.alpha_v))
        assert values["base_color"] == pytest.approx(np.broadcast_to(bottom.r0, 3))


@pytest.mark.parametrize(
    ("stack", "message"),
    [
        (urushi.coat(urushi.coat(RED, 0.1), 0.1), "has one coat"),
        (urushi.coat(RED, 0.1, sigma_t=1, albedo=0.5), "does not scatter"),
        (urushi.coat(RED, (0.1, 0.2, 0.3)), "a width for each channel"),
        (urushi.coat(RED, 0.1, eta=(1.5, 1.6, 1.7)), "coat_ior is one number"),
        (urushi.coat(RED, alpha_u=0.1, alpha_v=0.3), "larger across the tangent"),
        (urushi.coat(urushi.conductor(0.1, eta=0.2, k=3.0), 0.1), "conductor of r0 or a diffuse"),
        (urushi.coat(urushi.dielectric(), 0.1), "conductor of r0 or a diffuse"),
    ],
)
def test_what_openpbr_cannot_describe_is_refused(tmp_path, stack, message):
    with pytest.raises(ParameterError, match=message):
        save_materialx(stack, tmp_path / "no.mtlx")
    assert not (tmp_path / "no.mtlx").exists()


def test_names_are_checked(tmp_path):
    with pytest.raises(ParameterError, match="use letters, digits and underscores"):
        save_materialx(urushi.coat(RED, 0.1), tmp_path / "a.mtlx", 'a" b')
