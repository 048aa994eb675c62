"""Random bare bottoms as lobes and the rest of their values."""

import numpy as np

from urushi.core.probe_pairs import probe_pairs
from urushi.nets import lobe as lobes
from urushi.nets.lobe_fit import fit_lobes
from urushi.nets.transmittance import remainder
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS


def bottom_lobes(kind: str, bottom: np.ndarray, widths: int = 1) -> np.ndarray:
    """Lobes float32 (S, L) of bottoms with the parameters (S, K), in the order of their kind.

    Lobes that the family does not know are fitted to its values, as `encode` does.
    """
    columns = dict(zip(KINDS[kind].parameters, bottom.T, strict=True))
    fresnel = KINDS[kind].family.fresnel_numbers(columns)
    if fresnel is None:
        return fit_lobes(analytic.at_all(kind, columns, *probe_pairs(widths=widths)), widths)
    result = np.tile(lobes.no_lobe(widths), (len(bottom), 1))
    if own := [column for name, column in columns.items() if name.startswith("alpha")]:
        result[:, lobes.WIDTH_PLACES[widths]] = np.stack(own, axis=-1)
    for place, numbers in enumerate(fresnel, start=1):
        result[:, place] = numbers
    return result


def bottom_rest(
    kind: str, bottom: np.ndarray, own: np.ndarray, wi: np.ndarray, wo: np.ndarray
) -> np.ndarray:
    """g float32 (S, P) [1/sr] of bottoms in air with lobes (S, L) at pairs (P, 3), see
    `nets.transmittance`.

    bottom: (S, K) parameters in the order of their kind.
    """
    if KINDS[kind].family.bare:
        return np.zeros((len(bottom), len(wi)), np.float32)
    columns = dict(zip(KINDS[kind].parameters, bottom.T, strict=True))
    values = analytic.at_all(kind, columns, wi, wo)
    return remainder(values, own[:, None], wi, wo)
