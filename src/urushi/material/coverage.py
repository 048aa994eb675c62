"""The indices of refraction that networks were trained on. The random walk takes all of them."""

from typing import Any

import numpy as np
import numpy.typing as npt

from urushi.errors import ParameterError
from urushi.nets.weights import Model
from urushi.reference.stack import Dielectric, Stack


def least_eta(model: Model) -> float:
    """The least index that networks cover: their attribute of that name, or 1 if they have none."""
    return getattr(model.networks, "least_eta", 1.0)


def check_eta(model: Model, eta: npt.ArrayLike, where: str) -> None:
    """Check that the networks cover relative indices of refraction (any shape).

    `where` begins the error.

    Raises:
        ParameterError: an index is lower than `least_eta`.
    """
    least, lowest = least_eta(model), np.min(eta)
    if lowest < least:
        raise ParameterError(
            f"{where} is {lowest:g}, and the weights {model.fingerprint} cover indices above "
            f"{least:g} only; use the random walk for it (`simulate`, plugin 'layered')"
        )


def check_source(model: Model, source: Any) -> None:
    """Check the surface of a source of `encode`, if it is a described dielectric or a Stack."""
    if isinstance(source, Dielectric):
        check_eta(model, source.eta, "the dielectric's eta")
    elif isinstance(source, Stack):
        check_eta(model, source.coats[0].eta, "the topmost coat's eta")
