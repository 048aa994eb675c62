"""The bottoms of training stacks as the encoder sees them: one lobe, and the values of the rest."""

import numpy as np

from urushi.core.probe_pairs import probe_pairs
from urushi.nets import lobe as lobes
from urushi.nets.architecture import Architecture
from urushi.nets.lobe_fit import fit_lobes
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS


def bottom_lobes(kind: str, bottom: np.ndarray, arch: Architecture) -> np.ndarray:
    """Lobes (S, L) of bottoms with the parameters (S, K), in the order of their kind.

    Lobes that the family does not know are fitted to its values, as `encode` does.
    """
    columns = dict(zip(KINDS[kind].parameters, bottom.T, strict=True))
    fresnel = KINDS[kind].family.fresnel_numbers(columns)
    if fresnel is None:
        return fit_lobes(_values(kind, bottom, arch), arch.widths)
    result = np.tile(np.array(lobes.no_lobe(arch.widths), np.float32), (len(bottom), 1))
    if widths := [column for name, column in columns.items() if name.startswith("alpha")]:
        result[:, lobes.WIDTH_PLACES[arch.widths]] = np.stack(widths, axis=-1)
    for place, numbers in enumerate(fresnel, start=1):
        result[:, place] = numbers
    return result


def bottom_rest(kind: str, bottom: np.ndarray, own: np.ndarray, arch: Architecture) -> np.ndarray:
    """Values (S, probes) [1/sr] of bottoms in air at the probe pairs, minus their lobes."""
    if KINDS[kind].family.bare:
        return np.zeros((len(bottom), arch.probes), np.float32)
    top = lobes.f(own[:, None], *probe_pairs(arch.probes, arch.widths))
    return np.maximum(_values(kind, bottom, arch) - top, 0.0)


def _values(kind: str, bottom: np.ndarray, arch: Architecture) -> np.ndarray:
    """Values (S, probes) [1/sr] of bottoms in air at the probe pairs."""
    names = KINDS[kind].parameters
    count = len(bottom)
    wi, wo = (np.tile(w, (count, 1)) for w in probe_pairs(arch.probes, arch.widths))
    row = np.repeat(np.arange(count, dtype=np.uint32), arch.probes)
    columns = dict(zip(names, bottom.T, strict=True))
    return analytic.rows(kind, columns, row, wi, wo).reshape(count, arch.probes)
