"""RGL materials: BRDFs measured by Dupuy and Jakob 2018, in RGB or spectral.

Source: "An adaptive parameterization for efficient material acquisition and rendering".

Let m be the half vector and u_m = (x, y) its position on the unit square, x = sqrt(2 theta_m / pi)
and y = (phi_m - phi_i + pi) / (2 pi). Then
    f cos theta_o = S(v(u_m)) D(u_m) / (4 sigma(theta_i)),
where D is the microfacet density, sigma the projected area of the microfacets, v the warp that
makes the density of visible normals (`vndf`) uniform, and S the measured values on the square of v.
The factor D / (4 sigma) is absent if the file's flag `jacobian` is 0. vndf and S are interpolated
linearly between elevations theta_i.

Anisotropic materials have more azimuths phi_i than two, between which vndf and S are interpolated
as well. Their y is (phi_m + pi) / (2 pi), D depends on it, and sigma on phi_i. The azimuths may
cover a half or a quarter of a turn: f is then the same after a turn of both directions by 180
degrees, or under mirroring at the xz and at the yz plane.
"""

from functools import cached_property, partial
from importlib.resources import files

import numpy as np

from urushi.errors import FileError, ParameterError
from urushi.measured.tabulated import MeasuredSurface, evaluate, tabulated
from urushi.measured.warp import Warp, bilinear, slices_at

#: Number of dimensions and type of each tensor that every file has.
TENSORS = {
    "description": (1, "u1"),
    "phi_i": (1, "f4"),
    "theta_i": (1, "f4"),
    "ndf": (2, "f4"),
    "sigma": (2, "f4"),
    "vndf": (4, "f4"),
    "jacobian": (1, "u1"),
}

#: Name of the measured tensor in RGB files and in spectral ones.
RGB, SPECTRA = "rgb", "spectra"

#: Least cos theta_o by which f cos theta_o is divided (89.4 degrees). The data do not vanish at the
#: horizon, so that f would be unbounded there.
MIN_COSINE = 0.01

#: Bins of the table for the random walk. Its error E against the reciprocal mean of `Rgl.f` is
#: about 1 %, most of it from the resolution of theta_h.
TABLE_SHAPE = (256, 64, 64)

#: Largest number of components of spectra, and their relative error (RMS) if fewer suffice.
MOST_COMPONENTS, COMPONENTS_ERROR = 16, 1e-3

#: CIE XYZ to linear sRGB (IEC 61966-2-1).
XYZ_TO_SRGB = np.array(
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)

#: Number of azimuths phi_i up to which a file is isotropic, as for Mitsuba.
RELATIVE_AZIMUTHS = 2

#: [nm] The visible range, in which a spectrum needs at least two samples.
VISIBLE = (380.0, 780.0)


class Rgl(MeasuredSurface):
    """A BRDF in the adaptive parameterization, nearly reciprocal.

    wi and wo enter the formula in different ways, so that f is reciprocal only up to errors of
    the measurement and of the interpolation over few theta_i. Spectra are converted under the
    illuminant D65, so that a constant spectrum is neutral. Negative channels, of colours outside of
    sRGB, are set to 0.

    Attributes:
        description: the description in the file.
        wavelengths: float64 (W,) [nm] of a spectral file; None for an RGB file.
        isotropic: whether f depends on the difference of the azimuths alone.
    """

    def __init__(self, tensors: dict[str, np.ndarray]) -> None:
        """Make a BRDF of a file's tensors by name.

        Args:
            tensors: the names of `TENSORS`, and "rgb", or "spectra" and "wavelengths".

        Raises:
            FileError: a tensor is missing, of another shape or type, not finite, or out of range.
        """
        measured = _checked(tensors)
        self.description = tensors["description"].tobytes().decode("utf-8", "replace")
        phi_i = tensors["phi_i"].astype(np.float64)
        self.isotropic = len(phi_i) <= RELATIVE_AZIMUTHS
        if self.isotropic:  # Mitsuba reads a second azimuth, which only repeats the first
            phi_i = phi_i[:1]
        self._symmetry = 1  # the azimuths cover a turn over it
        if not self.isotropic:
            turns = np.rint(2 * np.pi / (phi_i[-1] - phi_i[0]))
            self._symmetry = int(np.clip(turns, 1, 4))
        self._nodes = tensors["theta_i"].astype(np.float64), phi_i
        self._ndf, self._sigma = (
            tensors[name].astype(np.float64)[None, ..., None] for name in ("ndf", "sigma")
        )
        used = slice(len(phi_i))
        self._vndf = Warp(_joined(np.maximum(tensors["vndf"][used], 0)))
        self._measured = _joined(np.moveaxis(measured[used], 2, -1))
        self._jacobian = bool(tensors["jacobian"][0])
        spectral = SPECTRA in tensors
        self.wavelengths = tensors["wavelengths"].astype(np.float64) if spectral else None
        self._rgb = self._measured
        if self.wavelengths is not None:
            self._rgb = self._measured @ srgb_weights(self.wavelengths)

    def _lookup(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return self._interpolated(self._rgb, wi, wo)

    def table(self) -> np.ndarray:
        """The mean of f over the exchange of wi and wo, float32 (256, 64, 64, 3) [1/sr].

        Raises:
            ParameterError: the material is anisotropic, which such a table cannot hold.
        """
        self._check_isotropic()
        return tabulated(self.f, TABLE_SHAPE)

    @cached_property
    def components(self) -> tuple[np.ndarray, np.ndarray]:
        """f of a spectral file: a table float32 (256, 64, 64, K) times spectra (K, W) [1/sr].

        The spectra are principal components of the measured ones, each scaled to a mean of one. The
        table has the mean of f over the exchange of wi and wo.

        Raises:
            ParameterError: the material is anisotropic, which such a table cannot hold.
        """
        self._check_isotropic()
        rows = self._measured.reshape(-1, self._measured.shape[-1])
        mean = np.abs(rows).mean(axis=1, keepdims=True)
        rows = rows / np.where(mean > 0, mean, 1)
        power, vectors = np.linalg.eigh(rows.T @ rows)  # the weakest first
        needed = int((power.cumsum() > COMPONENTS_ERROR**2 * power.sum()).sum())
        spectra = vectors[:, -min(max(needed, 1), MOST_COMPONENTS) :].T
        lookup = partial(self._interpolated, self._measured @ spectra.T)
        return tabulated(partial(evaluate, lookup, len(spectra)), TABLE_SHAPE), spectra

    def _check_isotropic(self) -> None:
        if not self.isotropic:
            raise ParameterError(
                "the measured material is anisotropic, but the random walk supports isotropic "
                "ones only; in a scene, put Mitsuba's 'measured' under the coat"
            )

    def _interpolated(self, measured: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """The formula of this module for float64 (N, 3) directions above the horizon.

        measured: the values, such as those of the file.
        """
        wi, wo = _folded(wi, wo, self._symmetry)
        m = wi + wo
        theta_i, theta_m = _elevation(wi), _elevation(m)
        phi_i = np.arctan2(wi[:, 1], wi[:, 0])
        if self.isotropic:
            # phi_m - phi_i, by products: it depends on the difference of the azimuths alone. Zeros
            # are positive, so that it is 0 along the normal whatever the signs there.
            across = wi[:, 0] * m[:, 1] - wi[:, 1] * m[:, 0]
            along = wi[:, 0] * m[:, 0] + wi[:, 1] * m[:, 1]
            azimuth = np.arctan2(across + 0.0, along + 0.0)
        else:
            azimuth = np.arctan2(m[:, 1], m[:, 0])
        u_i, u_m = (
            np.stack([np.sqrt(theta / (np.pi / 2)), (phi + np.pi) / (2 * np.pi)], 1)
            for theta, phi in ((theta_i, phi_i), (theta_m, azimuth))
        )
        slices = slices_at(self._nodes, theta_i, phi_i)
        result = bilinear(measured, self._vndf.invert(u_m, slices), slices)
        scale = 1 / np.maximum(wo[:, 2:], MIN_COSINE)
        if self._jacobian:
            once = [(np.zeros(len(wi), np.intp), np.ones(len(wi)))]
            scale *= bilinear(self._ndf, u_m, once) / (4 * bilinear(self._sigma, u_i, once))
        return result * scale


def _checked(tensors: dict[str, np.ndarray]) -> np.ndarray:
    """The measured tensor, after checks of all names, types, shapes and numbers."""
    colour = RGB if RGB in tensors and SPECTRA not in tensors else SPECTRA
    expected = TENSORS | ({} if colour == RGB else {"wavelengths": (1, "f4")}) | {colour: (5, "f4")}
    for name, (dimensions, dtype) in expected.items():
        if name not in tensors:
            raise FileError(f"it has no tensor '{name}', so it is not an RGL material")
        tensor = tensors[name]
        if tensor.ndim != dimensions or tensor.dtype.str[1:] != dtype:
            raise FileError(
                f"its tensor '{name}' is {tensor.dtype.name} of shape {tensor.shape}, "
                f"not {np.dtype(dtype).name} with {dimensions} dimensions"
            )
    measured, nm = tensors[colour], tensors.get("wavelengths", np.empty(0))
    phi, theta = len(tensors["phi_i"]), len(tensors["theta_i"])
    channels = 3 if colour == RGB else len(nm)
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
        raise FileError(f"the shapes of its tensors do not match: {shapes}")
    for name, (_, dtype) in expected.items():
        if dtype == "f4" and not np.isfinite(tensors[name]).all():
            raise FileError(f"its tensor '{name}' has numbers that are not finite")
    relative, sigma = phi <= RELATIVE_AZIMUTHS, tensors["sigma"]
    for name in ("phi_i", "theta_i", "wavelengths")[relative:]:
        if name in expected and not (np.diff(tensors[name].astype(np.float64)) > 0).all():
            raise FileError(f"its tensor '{name}' does not increase")
    if colour == SPECTRA and ((nm >= VISIBLE[0]) & (nm <= VISIBLE[1])).sum() < 2:
        raise FileError(
            f"its wavelengths, {nm[0]:g} to {nm[-1]:g} nm, are outside the visible spectrum"
        )
    if not (sigma > 0).all():
        raise FileError("its tensor 'sigma', a projected area, is not positive")
    if relative and (sigma != sigma[:1]).any():
        raise FileError(
            f"its tensor 'sigma' depends on the azimuth, but it has {phi} azimuths; an anisotropic "
            "material has three or more"
        )
    if (tensors["ndf"] < 0).any():
        raise FileError("its tensor 'ndf', a density, is negative")
    if not (tensors["vndf"] > 0).any(axis=(2, 3)).all():
        raise FileError("its tensor 'vndf' has no density at all for some elevation")
    return measured


def _elevation(w: np.ndarray) -> np.ndarray:
    """The angle [rad] of vectors (N, 3) of any length from the normal, accurate near zero."""
    return np.arctan2(np.hypot(w[:, 0], w[:, 1]), w[:, 2])


def _joined(tensor: np.ndarray) -> np.ndarray:
    """A tensor (P, T, ...) of azimuths and elevations as slices (P T, ...)."""
    return tensor.reshape(-1, *tensor.shape[2:]).copy()


def _folded(wi: np.ndarray, wo: np.ndarray, symmetry: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions (N, 3) turned or mirrored together so that phi_i is in the measured range.

    That is [-pi, 0] for half a turn, and [-pi, -pi/2] for a quarter.
    """
    if symmetry == 1:
        return wi, wo
    along_y = -np.copysign(1.0, wi[:, 1])
    along_x = -np.copysign(1.0, wi[:, 0]) if symmetry == 4 else along_y
    signs = np.stack([along_x, along_y, np.ones(len(wi))], axis=1)
    return wi * signs, wo * signs


def srgb_weights(wavelengths: np.ndarray) -> np.ndarray:
    """Return weights (W, 3) such that spectrum @ weights is linear sRGB.

    The spectrum of a reflectance or BRDF is taken as linear between its samples and constant
    outside of them. It is integrated against the CIE 1931 observer under the illuminant D65, the
    white of sRGB. A constant spectrum c gives exactly (c, c, c). Saturated spectra can give
    negative numbers.

    Args:
        wavelengths: (W,) strictly increasing [nm], W >= 2, some inside the visible range.
    """
    lines = (files("urushi.measured") / "cie.csv").read_text(encoding="ascii").splitlines()
    table = np.loadtxt(lines, delimiter=",")
    nm = np.arange(VISIBLE[0], VISIBLE[1] + 0.5)  # finer than any measured spectrum
    observer = np.stack([np.interp(nm, table[:, 0], column) for column in table.T[1:4]])
    light = np.interp(nm, table[:, 0], table[:, 4])
    curves = (XYZ_TO_SRGB @ (observer * light)).T  # (nm, 3)

    # Each nm contributes to the samples on both sides in proportion to its distance from them.
    lower = np.clip(np.searchsorted(wavelengths, nm) - 1, 0, len(wavelengths) - 2)
    gap = wavelengths[lower + 1] - wavelengths[lower]
    share = np.clip((nm - wavelengths[lower]) / gap, 0, 1)[:, None]
    weights = np.zeros((len(wavelengths), 3))
    np.add.at(weights, lower, (1 - share) * curves)
    np.add.at(weights, lower + 1, share * curves)
    return weights / weights.sum(0)
