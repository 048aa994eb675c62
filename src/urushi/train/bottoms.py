"""The lobes of random bare bottoms."""

import numpy as np

from urushi.core.probe_pairs import probe_pairs
from urushi.nets import lobe as lobes
from urushi.nets.lobe_fit import fit_lobes
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS


def bottom_lobes(kind: str, columns: dict[str, np.ndarray], widths: int = 1) -> np.ndarray:
    """Lobes float32 (S, L) of bottoms with the parameters (S,) by name.

    Lobes that the family does not know are fitted to its values, as `encode` does.
    """
    fresnel = KINDS[kind].family.fresnel_numbers(columns)
    if fresnel is None:
        return fit_lobes(analytic.at_all(kind, columns, *probe_pairs(widths=widths)), widths)
    result = np.tile(lobes.no_lobe(widths), (len(next(iter(columns.values()))), 1))
    if own := [column for name, column in columns.items() if name.startswith("alpha")]:
        result[:, lobes.WIDTH_PLACES[widths]] = np.stack(own, axis=-1)
    for place, numbers in enumerate(fresnel, start=1):
        result[:, place] = numbers
    return result
