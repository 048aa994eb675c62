"""From spectra to linear sRGB."""

from importlib.resources import files

import numpy as np

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
