"""The estimators of layered BRDFs by their names."""

from collections.abc import Callable
from typing import Any

from urushi.errors import ParameterError
from urushi.walk import bidirectional, walk

#: estimate(layers, bottom, wi, wo, rng, color, active), see `walk.walk.estimate`.
Estimate = Callable[..., Any]

#: One walk's f, without the reflection of the topmost interface, by the estimator's name.
ESTIMATORS: dict[str, Estimate] = {
    "unidirectional": walk.estimate,
    "bidirectional": bidirectional.estimate,
}


def checked(name: Any, where: str = "") -> str:
    """Return the name of an estimator; `where` begins the error.

    Raises:
        ParameterError: there is none of that name.
    """
    if not isinstance(name, str) or name not in ESTIMATORS:
        names = " or ".join(f"'{known}'" for known in ESTIMATORS)
        raise ParameterError(f"{where}estimator is {name!r}; it is {names}")
    return name
