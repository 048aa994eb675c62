"""Descriptions: values, equality, and an error sentence for every mistake."""

import numpy as np
import pytest

from urushi.checks import Widths
from urushi.errors import ParameterError
from urushi.walk import (
    Coat,
    Conductor,
    Stack,
    StackTable,
    analytic,
    coat,
    conductor,
    dielectric,
    diffuse,
    simulate,
    slab,
)
from urushi.walk.simulate import albedo
from urushi.walk.table import from_stack

UP = [[0.0, 0.0, 1.0]]
STACK = coat(diffuse(0.5), 0.1, 1.5)
ONES, TWO = np.ones((2, 1)), np.ones(2)


def table(kind="diffuse", bottom=None, alpha=ONES, eta=ONES) -> StackTable:
    """Two stacks of one coat."""
    bottom = {"reflectance": TWO} if bottom is None else bottom
    return StackTable(alpha, eta, ONES, ONES, ONES, kind, bottom)


def test_descriptions_are_values() -> None:
    stack = coat(conductor(0.1, [0.9, 0.8, 0.7]), np.float32(0.5), 1.5, albedo=np.array(0.5))
    again = coat(conductor(0.1, (0.9, 0.8, 0.7)), 0.5, 1.5, 0.5)
    assert stack == again
    assert hash(stack) == hash(again)
    assert stack.bottom.r0 == (0.9, 0.8, 0.7)
    assert stack.coats[0].alpha == 0.5
    with pytest.raises(AttributeError):
        Conductor(0.1, 0.5).alpha = 0.2  # type: ignore[misc]


def test_defaults_of_coat_are_those_of_the_plugins() -> None:
    """BK7 glass (1.5046) in air (1.000277), as Mitsuba's rough dielectrics, of width 0.1, clear."""
    assert coat(diffuse(0.5)) == coat(diffuse(0.5), 0.1, None, 0, 0, 0, ior=1.5046)
    assert coat(diffuse(0.5)).coats[0].eta == 1.5046 / 1.000277
    assert dielectric() == dielectric(0.1, ior=1.5046)


def test_coating_a_stack_adds_on_top() -> None:
    outer = coat(coat(diffuse(0.5), 0.1, 1.3), 0.2, 1.5)
    assert outer == Stack((Coat(0.2, 1.5), Coat(0.1, 1.3)), diffuse(0.5))
    listed = Stack(list(outer.coats), diffuse(0.5))  # type: ignore[arg-type]
    assert listed == outer and hash(listed) == hash(outer)


def test_a_table_has_a_row_per_channel_that_differs() -> None:
    assert len(from_stack(STACK)) == 1
    table = from_stack(coat(STACK, 0.3, 1.2, albedo=(0.1, 0.2, 0.3)))
    assert len(table) == 3
    assert table.coats == 2
    np.testing.assert_allclose(table.albedo, [[0.1, 0], [0.2, 0], [0.3, 0]])
    np.testing.assert_allclose(table.alpha, [[0.3, 0.1]] * 3)
    clear = StackTable(ONES, ONES, ONES, -0.0 * ONES, ONES, "diffuse", {"reflectance": TWO})
    assert not np.signbit(clear.sigma_t).any()  # the walk divides by depths


def test_equal_widths_are_one_width() -> None:
    assert conductor(alpha_u=0.2, alpha_v=0.2, r0=0.9) == conductor(0.2, 0.9)
    assert dielectric(alpha_u=0.2, alpha_v=0.2) == dielectric(0.2)
    three = (0.1, 0.2, 0.3)
    assert coat(STACK, alpha_u=three, alpha_v=three) == coat(STACK, three)
    assert dielectric(alpha_u=0.2, alpha_v=(0.2, 0.2, 0.2)).alpha_u == (0.2, 0.2, 0.2)


def test_widths_differ_by_channel_and_by_axis() -> None:
    brushed = conductor(alpha_u=0.1, alpha_v=(0.2, 0.3, 0.1), r0=0.9)
    assert brushed.is_anisotropic
    assert (brushed.alpha_u, brushed.alpha_v) == ((0.1, 0.1, 0.1), (0.2, 0.3, 0.1))
    stack = coat(coat(brushed, 0.4), alpha_u=0.5, alpha_v=0.6)
    assert stack.is_anisotropic and not STACK.is_anisotropic
    assert hash(stack) == hash(coat(coat(brushed, 0.4), alpha_u=0.5, alpha_v=0.6))
    table = from_stack(stack)
    assert table.kind == "conductor_anisotropic"
    np.testing.assert_allclose(table.alpha.u, [[0.5, 0.4]] * 3)
    np.testing.assert_allclose(table.alpha.v, [[0.6, 0.4]] * 3)
    np.testing.assert_allclose(table.bottom["alpha_v"], [0.2, 0.3, 0.1])


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: conductor(0.009, 0.5), "the conductor's alpha is 0.009; it must be a GGX width"),
        (lambda: conductor(0.1, 1.5), "the conductor's r0 is 1.5; it must be a reflectance in"),
        (lambda: conductor(0.1), "a conductor needs either r0 .* or both eta and k"),
        (lambda: conductor(0.1, 0.5, eta=1.5, k=1), "a conductor needs either r0"),
        (lambda: conductor(0.1, eta=-1, k=1), "the conductor's eta is -1; it must be zero or more"),
        (lambda: conductor(0.1, eta=1, k=-1), "the conductor's k is -1; it must be zero or more"),
        (lambda: dielectric(0.001, 1.5), "the dielectric's alpha is 0.001; it must be"),
        (lambda: dielectric(ior=1.5, eta=1.5), "ior and eta are both given"),
        (lambda: coat(diffuse(0.5), ior=1.5, eta=1.5), "ior and eta are both given"),
        (lambda: dielectric(ior=-1), "ior is -1"),
        (lambda: dielectric(0.1, 0.3), r"the dielectric's eta is 0.3; .* in \[0.333, 3\]"),
        (lambda: diffuse(1.1), r"reflectance is 1.1; it must be a reflectance in \[0, 1\]"),
        (lambda: coat(diffuse(1), 0.0, 1.5), r"the coat's alpha is 0; .* in \[0.01, 1\]"),
        (lambda: coat(diffuse(1), 0.1, 3.1), r"the coat's eta is 3.1; .* in \[0.5, 3\]"),
        (lambda: coat(diffuse(1), 0.1, 1.5, 1.1), "the coat's albedo is 1.1; it must be"),
        (lambda: coat(diffuse(1), 0.1, 1.5, 1, -1), "the coat's sigma_t is -1; .* optical depth"),
        (lambda: coat(diffuse(1), 0.1, 1.5, 1, 1, 1.0), r"the coat's g is 1; .* in \(-1, 1\)"),
        (lambda: coat(diffuse(1), 0.1, 1.5, [1, 2]), r"the coat's albedo has shape \(2,\); give"),
        (lambda: coat(diffuse(1), 0.1, 1.5, "red"), "the coat's albedo must be a number or one"),
        (lambda: coat("gold", 0.1, 1.5), "str cannot lie under a coat; give a conductor"),
        (lambda: conductor(r0=0.5), "the conductor's alpha is missing; give alpha, or alpha_u and"),
        (lambda: conductor(0.1, 0.5, alpha_u=0.1, alpha_v=0.2), "alpha_v; give alpha alone"),
        (lambda: dielectric(0.1, alpha_v=0.2), "the dielectric's alpha is given together with"),
        (lambda: dielectric(alpha_v=0.2), "the dielectric's alpha_u is missing; alpha_u and alph"),
        (lambda: coat(diffuse(1), alpha_u=0.2), "the coat's alpha_v is missing; .* go together"),
        (lambda: coat(diffuse(1), alpha_u=1, alpha_v=(0.1, 0.2, 1.1)), "coat's alpha_v is 1.1;"),
        (lambda: conductor(r0=1, alpha_u=0, alpha_v=1), "the conductor's alpha_u is 0; it must be"),
        (lambda: Stack(Coat(), diffuse(1)), "a Stack needs one or more Coat objects"),
        (lambda: Stack((), diffuse(1)), "a Stack needs one or more Coat objects, top to bottom"),
        (lambda: Stack((diffuse(1),), diffuse(1)), "a Stack needs one or more Coat objects"),
        (lambda: coat(diffuse(1), sigma_t=1e300), r"sigma_t is 1e\+300; .* depth in \[0, 1e6"),
        (lambda: slab(far=diffuse(1)), "the far side of a slab is a Diffuse, not an interf"),
        (lambda: slab(0.1, 0.0), "the slab's eta is 0; it must be an index of"),
        (lambda: slab(sigma_t=np.inf), "sigma_t is inf; it must be an optical depth"),
        (lambda: coat(slab(), energy_compensation=True), "compensation needs an opaque bottom"),
        (lambda: simulate(diffuse(1), UP, UP), r"needs a Stack from urushi.coat.*not Dif"),
        (lambda: simulate(STACK, UP, [[0, 0, 1.01]]), r"wo\[0\] = .* is not a unit vector; divide"),
        (lambda: simulate(STACK, UP, UP * 2), "wi has 1 directions and wo has 2; give pairs"),
        (lambda: simulate(STACK, "up", UP), r"wi must be an \(N, 3\) array of unit vectors"),
        (lambda: simulate(STACK, UP, UP, walks=1), "walks is 1; .* needs at least 2"),
        (lambda: simulate(STACK, UP, UP, mode="flux"), "is 'flux'; give 'radiance' or 'import"),
        (lambda: albedo(STACK, UP, walks=0), "walks is 0; .* needs at least 2"),
        (lambda: albedo(STACK, [[0, 0, 2]]), r"wi\[0\] = .* is not a unit vector"),
        (lambda: albedo(STACK, UP, transmitted=True), "a Diffuse bottom is opaque; only urushi"),
        (lambda: table("conductor", {"alpha": TWO}), "'conductor' .* the parameters alpha, r0"),
        (lambda: table(eta=TWO), r"eta must have shape \(stacks, coats\)"),
        (lambda: table(alpha=Widths(ONES, TWO)), r"alpha_v must have shape \(stacks, coats\)"),
        (lambda: table(bottom={"reflectance": np.ones(3)}), "must have one number per stack"),
    ],
)
def test_mistakes_are_named(make, sentence: str) -> None:
    with pytest.raises(ParameterError, match=sentence):
        make()


def test_no_directions_give_no_values() -> None:
    nothing = np.zeros((0, 3))
    for values in (
        *simulate(STACK, nothing, nothing, walks=2, progress=False),
        *albedo(STACK, nothing),
        *(analytic.f(bottom, nothing, nothing) for bottom in (diffuse(0.5), conductor(0.2, 0.9))),
    ):
        assert values.shape == (0, 3)
