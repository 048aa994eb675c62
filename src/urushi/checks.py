"""Checks of ranges and shapes at every entry point; errors state the cure."""

import warnings
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from urushi.errors import ParameterError, UrushiWarning

#: Largest deviation of a direction's length from one.
UNIT_TOLERANCE = 1e-3


#: Distance from 1 below which a relative index of refraction counts as 1, which is no interface:
#: 0.001 less the rounding of single precision. The half vector of transmission needs a step.
MIN_INDEX_STEP = 0.9999e-3

#: Largest optical depth: media of 1e6 reflect as deeper ones do.
MAX_DEPTH = 1e6

#: Least and largest relative index of refraction, and the least of a slab's lower interface, by
#: which light leaves the largest.
ETA_RANGE = (0.5, 3.0)
LEAST_ETA_BELOW = 1 / ETA_RANGE[1]

#: Larger indices of metals count as this one, which reflects all light but 4e-6 of it. The fourth
#: powers of indices need a place in single precision.
MAX_INDEX = 1e6

#: Indices of refraction of air, and of borosilicate glass (BK7), the default of coats.
AIR, GLASS = 1.000277, 1.5046

#: Optical depths, asymmetries, and largest ratio of a surface's two widths in the training data,
#: which have all values of the other parameters.
TRAINED_DEPTH, TRAINED_G, TRAINED_WIDTH_RATIO = 8.0, (-0.8, 0.9), 8.0

#: Least GGX width: a sharper lobe looks like a mirror under ordinary light sources.
MIN_ALPHA = 0.01


@dataclass(frozen=True)
class Widths:
    """The two GGX widths of an anisotropic surface.

    Where a single number stands for a GGX width, `Widths` stands for two. A surface of equal widths
    is isotropic. The two are of one kind: numbers, a number per channel, or arrays.
    """

    u: Any  # along the tangent (the x axis)
    v: Any  # across it (the y axis)


class CoatParameters(NamedTuple):
    """The parameters of one coat or of many: numbers, or arrays that broadcast."""

    alpha: Any  # GGX width of the interface, in [0.01, 1], or `Widths` where anisotropy is possible
    # Its index of refraction relative to the medium above, in [0.5, 3]. Below 1 there is total
    # reflection from above, at grazing angles. At 1 there is no interface.
    eta: Any
    albedo: Any  # single-scattering albedo of the medium below it, in [0, 1]
    sigma_t: Any  # optical depth of this medium, at least 0
    g: Any  # its Henyey-Greenstein asymmetry, in (-1, 1)

    @classmethod
    def of_columns(cls, columns: Any) -> "CoatParameters":
        """The coats of the columns (5, ...) or, with the width alpha_v as the last, (6, ...)."""
        alpha, eta, albedo, sigma_t, g, *across = columns
        return cls(Widths(alpha, *across) if across else alpha, eta, albedo, sigma_t, g)

    def columns(self) -> tuple[Any, ...]:
        """The columns of `of_columns`: six if the coats have two `Widths`."""
        if isinstance(self.alpha, Widths):
            return (self.alpha.u, *self[1:], self.alpha.v)
        return tuple(self)


#: Names of the columns of coats with one width, and with two.
COAT_COLUMNS = {1: CoatParameters._fields, 2: ("alpha_u", *CoatParameters._fields[1:], "alpha_v")}

#: The default coat: glass in air, without absorption.
DEFAULT_COAT = CoatParameters(0.1, GLASS / AIR, 0.0, 0.0, 0.0)


#: What `real` raises for values that are no numbers, and for whole numbers that no float can hold.
NO_NUMBERS = (TypeError, ValueError, OverflowError)


def real(value: npt.ArrayLike, dtype: type) -> np.ndarray:
    """Numbers as an array of a type; TypeError for dates and complex ones, which NumPy takes."""
    if np.asarray(value).dtype.kind in "cmM":
        raise TypeError("complex numbers, dates or durations")
    with np.errstate(over="ignore"):  # to infinity
        return np.asarray(value, dtype)


@dataclass(frozen=True)
class Check:
    """A check that numbers are finite and lie between two ends."""

    name: str  # the numbers' name in errors, unless the caller gives another
    domain: str  # the allowed numbers in words, the end of an error
    least: float = -np.inf
    most: float = np.inf
    open: bool = False  # whether the ends are excluded

    def __call__(
        self, value: npt.ArrayLike, where: str = "", *, any_shape: bool = False
    ) -> np.ndarray:
        """The numbers as float64 of shape () or (3,), of any if `any_shape`; -0.0 becomes 0.0.

        where: begins errors.

        Raises:
            ParameterError: they have another shape, or one is outside.
        """
        where = where or self.name
        try:
            array = real(value, np.float64)
        except NO_NUMBERS as error:
            raise ParameterError(
                f"{where} must be a number or one number per RGB channel, not {value!r}"
            ) from error
        if not any_shape and array.shape not in ((), (3,)):
            raise ParameterError(
                f"{where} has shape {array.shape}; give a scalar or three values, one per RGB "
                "channel"
            )
        inside = (array >= self.least) & (array <= self.most)
        if self.open:
            inside &= (array != self.least) & (array != self.most)
        bad = ~(np.isfinite(array) & inside)
        if bad.any():
            raise ParameterError(f"{where} is {array[bad].flat[0]:g}; it must be {self.domain}")
        return np.asarray(array + 0.0)  # a walk that divides by -0.0 gets a negative distance


alpha = Check("alpha", "a GGX width in [0.01, 1]", MIN_ALPHA, 1)
albedo = Check("albedo", "a single-scattering albedo in [0, 1]", 0, 1)
sigma_t = Check("sigma_t", "an optical depth in [0, 1e6]", 0, MAX_DEPTH)
g = Check("g", "a Henyey-Greenstein asymmetry in (-1, 1)", -1, 1, open=True)
rotation = Check("rotation", "an angle in degrees, finite")
reflectance = Check("reflectance", "a reflectance in [0, 1]", 0, 1)
share = Check("share", "in [0, 1]", 0, 1)
nonnegative = Check("number", "zero or more", 0)
finite_number = Check("number", "finite")
_ior = Check("ior", "an index of refraction above 0", 0, open=True)


def widths(
    value: npt.ArrayLike | Widths | None,
    alpha_u: npt.ArrayLike | None,
    alpha_v: npt.ArrayLike | None,
    where: str,
    default: float | None = None,
) -> npt.ArrayLike | Widths:
    """The one width or the two `Widths` that a caller gives as `alpha`, or as `alpha_u`, `alpha_v`.

    Args:
        value, alpha_u, alpha_v: the parameters; None: not given.
        where: begins errors, for example "the coat's".
        default: the width if none is given.

    Raises:
        ParameterError: one of the two is missing, or given besides `alpha`, or nothing is given.
    """
    two = [width for width in (alpha_u, alpha_v) if width is not None]
    if value is not None and two:
        raise ParameterError(
            f"{where} alpha is given together with alpha_u or alpha_v; give alpha alone for equal "
            "widths, or alpha_u and alpha_v"
        )
    if len(two) == 1:
        missing = "alpha_u" if alpha_u is None else "alpha_v"
        raise ParameterError(f"{where} {missing} is missing; alpha_u and alpha_v go together")
    if two:
        return Widths(*two)
    value = default if value is None else value
    if value is None:
        raise ParameterError(f"{where} alpha is missing; give alpha, or alpha_u and alpha_v")
    return value


def one_width(value: Any, where: str) -> Any:
    """The GGX width of a surface that has to be isotropic.

    where: begins errors, for example "the coat's".

    Raises:
        ParameterError: it has two `Widths`.
    """
    if isinstance(value, Widths):
        raise ParameterError(
            f"{where} alpha_u and alpha_v differ, but these weights are for isotropic materials; "
            "give one alpha, or the weights 'anisotropic'"
        )
    return value


def eta(
    value: npt.ArrayLike, where: str = "eta", *, any_shape: bool = False, low: float = ETA_RANGE[0]
) -> np.ndarray:
    """Check relative indices of refraction in [low, 3]; indices within 0.001 of 1 become 1."""
    high = ETA_RANGE[1]
    domain = f"an index of refraction relative to the medium above, in [{low:.3g}, {high:g}]"
    index = Check("eta", domain, low, high)(value, where, any_shape=any_shape)
    return np.where(np.abs(index - 1) < MIN_INDEX_STEP, 1.0, index)


def eta_in_air(
    ratio: npt.ArrayLike | None, ior: npt.ArrayLike | None, where: str, low: float = ETA_RANGE[0]
) -> tuple[npt.ArrayLike, npt.ArrayLike | None]:
    """The relative index of an interface in air, and its absolute one if it is given by that.

    Args:
        ratio, ior: the relative and the absolute index that a caller gives; None: not given. If
            neither is, the index is that of glass.
        where: begins errors, for example "the coat's".
        low: the least relative index.

    Raises:
        ParameterError: both are given, or the absolute one is not positive.
    """
    if ratio is not None and ior is not None:
        raise ParameterError(
            f"{where} ior and eta are both given; give ior, its index of refraction, or eta, the "
            "ratio of this index to that of the medium above"
        )
    if ratio is not None:
        return eta(ratio, f"{where} eta", low=low), None
    ior = _ior(GLASS if ior is None else ior, f"{where} ior")
    return eta(ior / AIR, f"{where} ior / {AIR}, in air,", low=low), ior


def thickness(value: npt.ArrayLike, where: str, *, any_shape: bool = False) -> np.ndarray:
    """Check thicknesses of coats, zero or more: one number, () or of any shape."""
    thick = nonnegative(value, where, any_shape=True)
    if not any_shape and thick.ndim:
        raise ParameterError(f"{where} must be one number, which all channels share")
    return thick


def direction(value: npt.ArrayLike, where: str) -> np.ndarray:
    """Check unit vectors; returns float32 (N, 3). Directions below the horizon are valid."""
    try:
        array = real(value, np.float32)
    except NO_NUMBERS as error:
        raise ParameterError(f"{where} must be an (N, 3) array of unit vectors") from error
    if array.ndim != 2 or array.shape[1] != 3:
        raise ParameterError(f"{where} has shape {array.shape}; give unit vectors of shape (N, 3)")
    length = np.linalg.norm(array, axis=1)
    bad = ~(np.abs(length - 1) <= UNIT_TOLERANCE)  # also catches NaN
    if bad.any():
        row = int(np.argmax(bad))
        raise ParameterError(
            f"{where}[{row}] = {array[row].tolist()} is not a unit vector; "
            "divide directions by their length"
        )
    return array


def directions(wi: npt.ArrayLike, wo: npt.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Check pairs of directions; returns two float32 arrays of shape (N, 3)."""
    wi, wo = direction(wi, "wi"), direction(wo, "wo")
    if wi.shape != wo.shape:
        raise ParameterError(
            f"wi has {len(wi)} directions and wo has {len(wo)}; give pairs of the same number"
        )
    return wi, wo


def finite(**arrays: npt.ArrayLike) -> list[np.ndarray]:
    """Check that arrays are finite and broadcast together; errors name the keyword.

    Returns:
        Float64 arrays, in the keywords' order.
    """
    result = {name: np.asarray(value, dtype=np.float64) for name, value in arrays.items()}
    for name, array in result.items():
        if not np.isfinite(array).all():
            raise ParameterError(f"{name} holds NaN or infinity; every value must be finite")
    try:
        np.broadcast_shapes(*(array.shape for array in result.values()))
    except ValueError as error:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in result.items())
        raise ParameterError(f"shapes do not fit together: {shapes}") from error
    return list(result.values())


def uniform(u: npt.ArrayLike, count: int) -> np.ndarray:
    """Check random numbers of samples; returns float32 (count, 3), which is below one too."""
    try:
        array = real(u, np.float64)
    except NO_NUMBERS as error:
        raise ParameterError("u must be an (N, 3) array of numbers in [0, 1)") from error
    if array.shape != (count, 3):
        raise ParameterError(
            f"u has shape {array.shape}; give three numbers per direction, shape ({count}, 3)"
        )
    if not ((array >= 0) & (array < 1)).all():
        raise ParameterError("u holds a number outside [0, 1); give uniform random numbers")
    return np.minimum(array.astype(np.float32), np.float32(1 - 2**-24))  # rounding may give 1


def outside_training(parameters: CoatParameters) -> set[str]:
    """Sentences about the trained ranges that coats (arrays of any shape) leave."""
    low, high = TRAINED_G
    left = set()
    if np.max(parameters.sigma_t) > TRAINED_DEPTH:
        left.add(f"sigma_t is above {TRAINED_DEPTH:g}")
    if np.min(parameters.g) < low or np.max(parameters.g) > high:
        left.add(f"g is outside [{low:g}, {high:g}]")
    return left


def warn_of_training(left: set[str], where: str) -> None:
    """Warn of `outside_training`; where: begins the sentence, for example "the coat's".

    Warns:
        UrushiWarning: a range is left.
    """
    if left:
        message = (
            f"{where} {' and '.join(sorted(left))}, outside the network's training data: a similar "
            "medium is layered; the random walk ('layered', urushi.simulate) has no such limit"
        )
        warnings.warn(message, UrushiWarning, stacklevel=3)


def alphas(value: Any, where: str, *, any_shape: bool = False) -> np.ndarray | Widths:
    """Check one GGX width, or two `Widths`."""
    if not isinstance(value, Widths):
        return alpha(value, where, any_shape=any_shape)
    axes = {"u": value.u, "v": value.v}
    return Widths(*(alpha(x, f"{where}_{k}", any_shape=any_shape) for k, x in axes.items()))


def coat(parameters: CoatParameters, where: str, *, any_shape: bool = False) -> CoatParameters:
    """Check all parameters of a coat. `where` begins the errors, for example "the coat's"."""
    checks: Any = (alphas, eta, albedo, sigma_t, g)
    named = zip(checks, CoatParameters._fields, parameters, strict=True)
    return CoatParameters(*(f(x, f"{where} {name}", any_shape=any_shape) for f, name, x in named))
