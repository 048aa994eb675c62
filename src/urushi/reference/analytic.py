"""Analytic BRDFs of described surfaces without coats: no walk, no noise."""

import drjit as dr
import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.reference.launch import types
from urushi.reference.stack import Conductor, Dielectric, Diffuse
from urushi.reference.table import BOTTOM_KINDS, bottom_columns, channel_count


def f(
    description: Conductor | Dielectric | Diffuse, wi: npt.ArrayLike, wo: npt.ArrayLike
) -> np.ndarray:
    """Evaluate a described surface in air.

    Args:
        description: a conductor, dielectric (its reflection) or diffuse description.
        wi, wo: (N, 3) unit vectors.

    Returns:
        float32 (N, 3): the BRDF [1/sr], without cosine; zero below the horizon.

    Raises:
        ParameterError: wrong shapes, or directions that are not unit vectors.
    """
    wi, wo = checks.directions(wi, wo)
    channels = channel_count(description)
    kind, columns = bottom_columns(description, channels)
    row = np.tile(np.arange(channels, dtype=np.uint32), len(wi))
    values = rows(kind, columns, row, np.repeat(wi, channels, 0), np.repeat(wo, channels, 0))
    return np.broadcast_to(values.reshape(-1, channels), (len(wi), 3)).copy()


def rows(
    kind: str, columns: dict[str, np.ndarray], row: np.ndarray, wi: np.ndarray, wo: np.ndarray
) -> np.ndarray:
    """Evaluate surface row[i] of `kind` at (wi[i], wo[i]); returns float32 (M,) [1/sr].

    `columns` holds the kind's parameters (see `urushi.reference.table.BOTTOM_KINDS`) by name, each
    of shape (S,).
    """
    if not len(row):
        return np.zeros(0, np.float32)
    device = types()
    index = device.UInt32(np.ascontiguousarray(row, np.uint32))
    factory, names = BOTTOM_KINDS[kind]
    parameters = (
        dr.gather(device.Float, device.Float(np.ascontiguousarray(columns[n], np.float32)), index)
        for n in names
    )
    wi, wo = (device.Array3f(np.ascontiguousarray(w.T, np.float32)) for w in (wi, wo))
    value, _ = factory(*parameters).f_pdf(wi, wo)
    return np.array(value.numpy(), np.float32)
