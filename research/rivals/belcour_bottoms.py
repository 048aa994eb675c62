"""The bottoms of stacks for the statistical operators: their widths and mean reflectances."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import drjit as dr

from research.rivals import belcour_tables as tables
from urushi.core import fresnel
from urushi.errors import ParameterError
from urushi.walk.monte_carlo import backend
from urushi.walk.table import StackTable

#: What a table's kind of bottom ends in where it has two widths.
SUFFIX = "_anisotropic"
#: Fresnel's term of each kind of one width, of the facet's cosine and of the bottom's parameters.
FRESNEL: dict[str, Callable[[Any, dict[str, Any]], Any]] = {
    "conductor": lambda cos, column: fresnel.schlick(cos, column["r0"]),
    "conductor_complex": lambda cos, column: fresnel.exact(cos, column["eta"], column["k"]),
    "dielectric": lambda cos, column: fresnel.dielectric(cos, column["eta"])[0],
}


class Bottom(NamedTuple):
    """The opaque surface under the lowest medium.

    Attributes:
        alpha: its GGX width, or a Dr.Jit vector of two; None: the surface is Lambertian.
        reflectance: function of the incident cosine and of the width of the light's lobe on it, 0
            on a Lambertian surface, that gives the mean of Fresnel's term.
    """

    alpha: Any
    reflectance: Callable[[Any, Any], Any]


def table_bottom(table: StackTable, row: Any, float_type: type) -> Bottom:
    """The bottoms of rows row[i] of a table; those of two widths have a Dr.Jit vector.

    Raises:
        ParameterError: the operators do not describe the table's kind of bottom.
    """
    if "alpha_u" in table.bottom:
        columns = dict(table.bottom)
        u, v = columns.pop("alpha_u"), columns.pop("alpha_v")
        kind = table.kind.removesuffix(SUFFIX)
        one_width = replace(table, kind=kind, bottom={"alpha": u, **columns})
        across = dr.gather(float_type, float_type(v), row)
        bottom = table_bottom(one_width, row, float_type)
        return bottom._replace(alpha=backend().Array2f(bottom.alpha, across))
    column = {name: dr.gather(float_type, float_type(v), row) for name, v in table.bottom.items()}
    if table.kind == "diffuse":
        return Bottom(None, lambda cos_i, alpha: column["reflectance"])

    if table.kind not in FRESNEL:
        raise ParameterError(
            f"the statistical operators do not support a '{table.kind}' bottom; use a conductor, "
            "dielectric or diffuse"
        )

    def reflected(wo: Any, cos_m: Any) -> Any:
        return FRESNEL[table.kind](dr.clip(cos_m, 0, 1), column)

    def reflectance(cos_i: Any, alpha: Any) -> Any:
        return tables.mean_over_facets(reflected, cos_i, alpha)

    return Bottom(column["alpha"], reflectance)
