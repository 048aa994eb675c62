"""Every range check accepts its whole range, ends included or not, and names what is wrong."""

import numpy as np
import pytest

from urushi import checks
from urushi.errors import ParameterError, UrushiError

TINY = 1e-9
RANGES = [
    # check, accepted, refused
    (checks.alpha, [0.01, 0.5, 1], [0.01 - TINY, 0, -0.1, 1 + TINY]),
    (checks.eta, [0.5, 0.7, 0.999, 1, 1.001, 1.5, 3], [0.5 - TINY, 3 + TINY, 0, -1.5]),
    (checks.albedo, [0, 0.5, 1], [-TINY, 1 + TINY]),
    (checks.sigma_t, [0, 1, 1e6], [-TINY, -1]),
    (checks.g, [-1 + TINY, 0, 0.9, 1 - TINY], [-1, 1, 1.5]),
    (checks.reflectance, [0, 0.5, 1], [-TINY, 1 + TINY]),
]


@pytest.mark.parametrize(("check", "accepted", "refused"), RANGES)
def test_ranges_and_shapes(check, accepted, refused):
    """One bad channel is enough."""
    for value in accepted:
        result = check(value)
        assert result.shape == () and result.dtype == np.float64 and result == value
    name = "eta" if check is checks.eta else check.name
    for value in [*refused, np.nan, np.inf, -np.inf]:
        with pytest.raises(ParameterError, match=f"^{name} is .*; it must be"):
            check(value)
    good = accepted[1]
    assert check((good, good, good)).shape == (3,)
    for bad in (refused[0], np.nan):
        with pytest.raises(ParameterError):
            check((good, bad, good))
    for wrong in ([], [0.5, 0.5], [[0.5, 0.5, 0.5]], np.full((4, 3), 0.5)):
        with pytest.raises(ParameterError, match="has shape .*; give a scalar or three values"):
            check(wrong)
    assert check(np.full((4, 5), good), any_shape=True).shape == (4, 5)


def test_indices_near_one_are_one():
    """Those of single precision that are a step away are not."""
    step = np.float32([0.999, 1.001])
    np.testing.assert_array_equal(checks.eta((0.9995, 1, 1.0009)), 1)
    np.testing.assert_array_equal(checks.eta([*step], any_shape=True), step)


def test_negative_zero_becomes_zero():
    assert not np.signbit(checks.sigma_t(-0.0))
    assert not np.signbit(checks.g((-0.0, 0.0, -0.0))).any()


NONSENSE = ["rough", None, object(), [0.1, [0.2]], 0.5j, np.full(3, 0.5 + 1j), 10**400]
NONSENSE += [np.datetime64(0, "s"), np.timedelta64(0, "s")]


@pytest.mark.parametrize("nonsense", NONSENSE)
def test_nonsense(nonsense):
    for check in (checks.alpha, checks.thickness):
        with pytest.raises(ParameterError):
            check(nonsense, "it")
    with pytest.raises(ParameterError):
        checks.direction(nonsense, "wi")
    with pytest.raises(ParameterError):
        checks.uniform(nonsense, 1)


def test_the_message_says_where():
    with pytest.raises(ValueError, match="^the top coat's alpha is 7; it must be a GGX") as caught:
        checks.alpha(7, "the top coat's alpha")
    assert isinstance(caught.value, ParameterError) and isinstance(caught.value, UrushiError)


def test_directions():
    up = [[0, 0, 1], [0.6, 0, 0.8]]
    wi, wo = checks.directions(up, np.array(up))
    assert wi.dtype == wo.dtype == np.float32
    assert wi.shape == wo.shape == (2, 3)
    checks.directions([[0, 0, -1]], [[1, 0, 0]])  # below and at the horizon: no error
    checks.directions(np.zeros((0, 3)), np.zeros((0, 3)))


@pytest.mark.parametrize(
    ("wi", "message"),
    [
        ([[0, 0, 1.01]], "not a unit vector"),
        ([[0, 0, 0]], "not a unit vector"),
        ([[0, 0, 1], [0, np.nan, 1]], r"wi\[1\]"),
        ([[np.inf, 0, 0]], "not a unit vector"),
        ([[1e300, 0, 0]], "not a unit vector"),
        ([0, 0, 1], r"shape \(3,\)"),
        ([[0, 1]], r"shape \(1, 2\)"),
        ("up", r"\(N, 3\)|shape"),
        (np.array([[0, 0, 1 + 1j]]), r"must be an \(N, 3\) array"),
        ([[0, 0, 1], [0, 0, 1]], "wi has 2 directions and wo has 1"),
    ],
)
def test_bad_directions(wi, message):
    with pytest.raises(ParameterError, match=message):
        checks.directions(wi, [[0, 0, 1]])
