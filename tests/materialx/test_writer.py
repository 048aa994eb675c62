"""Stacks of one coat, written as OpenPBR and read again."""

import numpy as np
import pytest

import urushi
from urushi.errors import ParameterError
from urushi.materialx.surface import read_surface
from urushi.materialx.writer import save_materialx, stack_of

GOLD = urushi.conductor(alpha=0.3, r0=(0.98, 0.77, 0.34))
BRUSHED = urushi.conductor(alpha_u=0.4, alpha_v=0.1, r0=0.9)
RED = urushi.diffuse((0.7, 0.1, 0.05))


def numbers(stack):
    """All numbers of a stack, colours as three."""
    coat, bottom = stack.coats[0], stack.bottom
    values = [coat.alpha_u, coat.alpha_v, coat.eta, coat.sigma_t, coat.albedo]
    if isinstance(bottom, type(GOLD)):
        values += [bottom.alpha_u, bottom.alpha_v, bottom.r0]
    else:
        values += [bottom.reflectance]
    return np.concatenate([np.broadcast_to(v, 3) for v in values])


@pytest.mark.parametrize("bottom", [GOLD, BRUSHED, RED])
@pytest.mark.parametrize(
    "coat",
    [
        {"alpha": 0.05, "eta": 1.6},
        {"alpha": 0.25, "eta": 1.5, "sigma_t": (0.1, 0.5, 2.0)},
        {"alpha_u": 0.5, "alpha_v": 0.2, "eta": 1.3, "sigma_t": 1.0},
    ],
)
def test_a_stack_comes_back(tmp_path, bottom, coat):
    """Equal but for the rounding of exp and log, of powers and roots."""
    stack = urushi.coat(bottom, **coat)
    path = tmp_path / "stack.mtlx"
    save_materialx(stack, path, "Lacquer")
    surface = read_surface(path, None)
    assert surface.name == "Lacquer"
    again = stack_of(surface.values)
    assert type(again.bottom) is type(bottom)
    assert again.is_anisotropic == stack.is_anisotropic
    np.testing.assert_allclose(numbers(again), numbers(stack), rtol=1e-12, atol=1e-15)
    save_materialx(again, path)
    values = read_surface(path, None).values
    for name, value in surface.values.items():
        assert values[name] == pytest.approx(value, rel=1e-12)


def test_a_clear_coat_stays_clear(tmp_path):
    path = tmp_path / "clear.mtlx"
    save_materialx(urushi.coat(RED, 0.1), path)
    sigma_t = np.array(stack_of(read_surface(path, None).values).coats[0].sigma_t)
    assert (sigma_t == 0).all() and not np.signbit(sigma_t).any()


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


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"coat_weight": 0.5}, "coat_weight is 0.5"),
        ({"coat_weight": 1.0, "fuzz_weight": 0.5}, "cannot represent fuzz_weight"),
        ({"coat_weight": 1.0}, "a metal .* or a Lambertian"),
        ({"coat_weight": 1.0, "specular_weight": 0.0, "coat_color": (0, 1, 1)}, "coat_color is 0"),
    ],
)
def test_what_a_stack_cannot_describe_is_refused(values, message):
    with pytest.raises(ParameterError, match=message):
        stack_of(values)


def test_names_are_checked(tmp_path):
    with pytest.raises(ParameterError, match="use letters, digits and underscores"):
        save_materialx(urushi.coat(RED, 0.1), tmp_path / "a.mtlx", 'a" b')
