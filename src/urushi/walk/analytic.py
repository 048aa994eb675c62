"""BRDFs of described surfaces without coats, in closed form."""

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.core.backend import backend, shared
from urushi.walk.bottoms import Description
from urushi.walk.monte_carlo import per_channel
from urushi.walk.table import bottom_of_columns


def f(description: Description, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
    """The BRDF [1/sr] of a surface in air, float32 (N, 3), for unit vectors (N, 3).

    Without cosine; zero below the horizon; of a dielectric, its reflection alone.
    """
    (values,) = per_channel(
        description,
        checks.directions(wi, wo),
        lambda table, row, *w: (rows(table.kind, table.bottom, row, *w),),
    )
    return values


def at_all(kind: str, columns: dict[str, np.ndarray], wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Evaluate all S surfaces of `rows` at all of the same pairs (P, 3); returns (S, P)."""
    count = len(next(iter(columns.values())))
    row = np.repeat(np.arange(count, dtype=np.uint32), len(wi))
    values = rows(kind, columns, row, np.tile(wi, (count, 1)), np.tile(wo, (count, 1)))
    return values.reshape(count, len(wi))


def rows(
    kind: str, columns: dict[str, np.ndarray], row: np.ndarray, wi: np.ndarray, wo: np.ndarray
) -> np.ndarray:
    """Evaluate surface row[i] of `kind` at (wi[i], wo[i]); returns float32 (M,) [1/sr].

    `columns` has the parameters of the kind (see `urushi.walk.bottoms.KINDS`) by name,
    (S,) each.
    """
    if not len(row):
        return np.zeros(0, np.float32)
    device = backend()
    index = shared(device.UInt32, row.astype(np.uint32))
    wi, wo = (device.Array3f(np.ascontiguousarray(w.T, np.float32)) for w in (wi, wo))
    value, _ = bottom_of_columns(device, kind, columns, index).f_pdf(wi, wo)
    return np.array(value.numpy(), np.float32)
