"""RGL materials: isotropic BRDFs measured by Dupuy and Jakob, "An adaptive parameterization for
efficient material acquisition and rendering", 2018, in RGB or spectral.

With m the half vector and u_m its position on the unit square, x = sqrt(2 theta_m / pi) and
y = (phi_m - phi_i + pi) / (2 pi), the file gives
    f cos theta_o = S(v(u_m)) D(u_m) / (4 sigma(theta_i)),
where D is the microfacet density, sigma the projected area of the microfacets, v the warp that
makes the density of visible normals (vndf) uniform, and S what was measured, on v's square.
D / (4 sigma) is absent where the file's flag `jacobian` is 0. vndf and S are linear in between
elevations theta_i.

From spectra to linear sRGB.
"""

from importlib.resources import files
from pathlib import Path

import numpy as np
import numpy.typing as npt

from urushi.errors import FileError
from urushi.measured import rgl_file
from urushi.measured.tabulated import MeasuredSurface, evaluate, tabulated
from urushi.measured.warp import BilinearGrid, Slices, Warp

#: Dimensions and type of the tensors that every file has.
TENSORS = {
    "description": (1, "u1"),
    "phi_i": (1, "f4"),
    "theta_i": (1, "f4"),
    "ndf": (2, "f4"),
    "sigma": (2, "f4"),
    "vndf": (4, "f4"),
    "jacobian": (1, "u1"),
}

#: A file's colour: the measured tensor's name in RGB files and in spectral ones.
RGB, SPECTRA = "rgb", "spectra"

#: cos theta_o is not taken smaller when f cos theta_o is divided by it (89.4 degrees): the data do
#: not vanish at the horizon, and f would grow without bound.
LEAST_COSINE = 0.01

#: Bins of the table that lies under a coat: it differs from the reader, averaged over the exchange
#: of the directions, by an E of about 1 %, of which most is theta_h's.
TABLE = (256, 64, 64)


class Rgl(MeasuredSurface):
    """A BRDF in the adaptive parameterization; isotropic by construction, nearly reciprocal.

    It is reciprocal as far as the measurement and its interpolation over few theta_i are (wi and
    wo have different parts in the formula). f is 0 where a direction is below the horizon.

    Attributes:
        description: the file's own words.
        wavelengths: float64 (W,) [nm] of a spectral file; None if the file is in RGB.
    """

    description: str
    wavelengths: np.ndarray | None

    def __init__(self, tensors: dict[str, np.ndarray]) -> None:
        """Take a file's tensors by name (see `TENSORS`, and "rgb", or "spectra" and "wavelengths").

        Raises:
            FileError: a tensor is missing, of another shape or type, not finite, or out of range,
                or the material is anisotropic.
        """
        measured = _check_structure(tensors)
        _check_values(tensors, measured)
        _check_isotropic(tensors)
        self.description = tensors["description"].tobytes().decode("utf-8", "replace")
        self._slices = Slices(tensors["theta_i"])
        self._ndf = tensors["ndf"][0].astype(np.float64)
        self._sigma = tensors["sigma"][0].astype(np.float64)
        self._vndf = Warp(np.maximum(tensors["vndf"][0], 0))
        self._measured = BilinearGrid(np.moveaxis(measured[0], 1, -1).copy())
        self._jacobian = bool(tensors["jacobian"][0])
        self._channels = measured.shape[2]
        self._to_rgb = np.eye(3)
        self.wavelengths = None
        if SPECTRA in tensors:
            self.wavelengths = tensors["wavelengths"].astype(np.float64)
            self._to_rgb = srgb_weights(self.wavelengths)

    def f(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """Evaluate in linear sRGB; spectra are seen under D65, so that a constant one is neutral.

        Colours outside of sRGB have a negative channel, which is set to 0.

        Args:
            wi, wo: (N, 3) unit vectors; a file is measured with light from wi.

        Returns:
            float32 (N, 3): [1/sr], without cosine, never negative.

        Raises:
            ParameterError: wrong shapes, or directions that are not unit vectors.
        """

        def lookup(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
            return np.maximum(self._lookup(wi, wo) @ self._to_rgb, 0)

        return evaluate(lookup, 3, wi, wo, width=self._channels)

    def table(self) -> np.ndarray:
        """f averaged over the exchange of wi and wo, (256, 64, 64, 3)."""
        return tabulated(self.f, TABLE)

    def f_channels(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """Evaluate as measured.

        Args:
            wi, wo: (N, 3) unit vectors.

        Returns:
            float32 (N, W) at the file's wavelengths, or (N, 3) linear sRGB of an RGB file, where
            a colour outside of sRGB has a negative channel: [1/sr], without cosine.

        Raises:
            ParameterError: wrong shapes, or directions that are not unit vectors.
        """
        return evaluate(self._lookup, self._channels, wi, wo, width=self._channels)

    def _lookup(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        m = wi + wo
        theta_i, theta_m = _elevation(wi), _elevation(m)
        # phi_m - phi_i, from products so that it depends on nothing but the difference.
        turn = np.arctan2(
            wi[:, 0] * m[:, 1] - wi[:, 1] * m[:, 0], wi[:, 0] * m[:, 0] + wi[:, 1] * m[:, 1]
        )
        x_i, x_m = (np.sqrt(theta / (np.pi / 2)) for theta in (theta_i, theta_m))
        u_m = np.stack([x_m, (turn + np.pi) / (2 * np.pi)], 1)
        slices = self._slices.find(theta_i)
        result = self._measured.evaluate(self._vndf.invert(u_m, slices), slices)
        scale = 1 / np.maximum(wo[:, 2], LEAST_COSINE)
        if self._jacobian:
            scale *= _linear(self._ndf, x_m) / (4 * _linear(self._sigma, x_i))
        return result * scale[:, None]


def read(path: Path) -> Rgl:
    """Read an RGL file.

    Raises:
        FileError: as of `tensorfile.read` and `Rgl`.
    """
    tensors = rgl_file.read(path)
    try:
        return Rgl(tensors)
    except FileError as error:
        raise FileError(f"cannot use '{path}': {error}") from error


def _check_structure(tensors: dict[str, np.ndarray]) -> np.ndarray:
    """Check names, types and shapes; return the measured tensor."""
    expected = dict(TENSORS)
    if RGB in tensors and SPECTRA not in tensors:
        colour = RGB
    else:
        colour = SPECTRA
        expected["wavelengths"] = (1, "f4")
    expected[colour] = (5, "f4")
    for name, (dimensions, dtype) in expected.items():
        if name not in tensors:
            raise FileError(f"it has no tensor '{name}', so it is no RGL material")
        tensor = tensors[name]
        if tensor.ndim != dimensions or tensor.dtype.str[1:] != dtype:
            raise FileError(
                f"its tensor '{name}' is {tensor.dtype.name} of shape {tensor.shape}, "
                f"not {np.dtype(dtype).name} with {dimensions} dimensions"
            )
    measured = tensors[colour]
    phi, theta = len(tensors["phi_i"]), len(tensors["theta_i"])
    channels = 3 if colour == RGB else len(tensors["wavelengths"])
    resolutions = [n for name in ("ndf", "sigma") for n in tensors[name].shape]
    resolutions += [theta, channels, *tensors["vndf"].shape[2:], *measured.shape[3:]]
    if not (
        phi >= 1
        and min(resolutions) >= 2
        and tensors["vndf"].shape[:2] == (phi, theta)
        and measured.shape[:3] == (phi, theta, channels)
        and tensors["jacobian"].shape == (1,)
    ):
        shapes = ", ".join(f"{name} {tensors[name].shape}" for name in expected)
        raise FileError(f"its tensors' shapes do not fit each other: {shapes}")
    return measured


def _check_isotropic(tensors: dict[str, np.ndarray]) -> None:
    count = len(tensors["phi_i"])
    turns = any((tensors[name] != tensors[name][:1]).any() for name in ("ndf", "sigma"))
    if count > 1 or turns:
        raise FileError(
            f"the material is anisotropic (measured at {count} azimuths), "
            "and only isotropic ones can be used"
        )


def _check_values(tensors: dict[str, np.ndarray], measured: np.ndarray) -> None:
    named = {name: tensors[name] for name, (_, dtype) in TENSORS.items() if dtype == "f4"}
    named |= {RGB if SPECTRA not in tensors else SPECTRA: measured}
    if SPECTRA in tensors:
        named["wavelengths"] = tensors["wavelengths"]
    for name, tensor in named.items():
        if not np.isfinite(tensor).all():
            raise FileError(f"its tensor '{name}' has numbers that are not finite")
    for name in ("theta_i", "wavelengths"):
        if name in named and not (np.diff(named[name].astype(np.float64)) > 0).all():
            raise FileError(f"its tensor '{name}' does not increase")
    if SPECTRA in tensors:
        nm = tensors["wavelengths"]
        if ((nm >= VISIBLE[0]) & (nm <= VISIBLE[1])).sum() < 2:
            raise FileError(
                f"its wavelengths, {nm[0]:g} to {nm[-1]:g} nm, are outside of visible light"
            )
    if not (tensors["sigma"] > 0).all():
        raise FileError("its tensor 'sigma', a projected area, is not positive")
    if (tensors["ndf"] < 0).any():
        raise FileError("its tensor 'ndf', a density, is negative")
    if not (tensors["vndf"] > 0).any(axis=(2, 3)).all():
        raise FileError("its tensor 'vndf' has no density at all for some elevation")


def _elevation(w: np.ndarray) -> np.ndarray:
    """The angle from the normal [rad], exact near zero, of vectors (N, 3) of any length."""
    return np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2])


def _linear(values: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Values at equally spaced nodes over [0, 1], linear in between."""
    return np.interp(u, np.linspace(0, 1, len(values)), values)


#: CIE XYZ to linear sRGB (IEC 61966-2-1).
XYZ_TO_SRGB = np.array(
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)

#: The visible range, inside which a spectrum needs samples [nm].
VISIBLE = (380.0, 780.0)


def srgb_weights(wavelengths: np.ndarray) -> np.ndarray:
    """Return weights (W, 3) such that spectrum @ weights is linear sRGB.

    The spectrum of a reflectance or BRDF, piecewise linear between its samples and constant outside
    of them, is integrated against the CIE 1931 observer under illuminant D65, sRGB's white. A
    constant spectrum c gives exactly (c, c, c). Saturated spectra can give negative numbers.

    Args:
        wavelengths: (W,) strictly increasing [nm], W >= 2, some inside the visible range.
    """
    lines = (files("urushi.measured") / "cie.csv").read_text(encoding="ascii").splitlines()
    table = np.loadtxt(lines, delimiter=",")
    nm = np.arange(VISIBLE[0], VISIBLE[1] + 0.5)  # finer than any measured spectrum
    observer = np.stack([np.interp(nm, table[:, 0], column) for column in table.T[1:4]])
    light = np.interp(nm, table[:, 0], table[:, 4])
    curves = (XYZ_TO_SRGB @ (observer * light)).T  # (nm, 3)

    # The samples on either side of each nm share what it contributes.
    lower = np.clip(np.searchsorted(wavelengths, nm) - 1, 0, len(wavelengths) - 2)
    gap = wavelengths[lower + 1] - wavelengths[lower]
    share = np.clip((nm - wavelengths[lower]) / gap, 0, 1)[:, None]
    weights = np.zeros((len(wavelengths), 3))
    np.add.at(weights, lower, (1 - share) * curves)
    np.add.at(weights, lower + 1, share * curves)
    return weights / weights.sum(0)
