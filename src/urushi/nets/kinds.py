"""The kinds of architecture that a weights file may hold, each with the networks it makes."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from urushi.errors import ParameterError
from urushi.nets.architecture import Architecture, Params, parameter_shapes
from urushi.nets.networks import Networks, UrushiNetworks
from urushi.nets.paper.architecture import PaperArchitecture
from urushi.nets.paper.architecture import parameter_shapes as paper_shapes
from urushi.nets.paper.networks import PaperNetworks


@dataclass(frozen=True)
class Kind:
    """One kind of architecture.

    Attributes:
        architecture: its class, with `latent`, `to_json` and `from_json`.
        shapes: the parameters' shapes by name.
        bind: the networks of such parameters.
    """

    architecture: Any
    shapes: Callable[[Any], dict[str, tuple[int, ...]]]
    bind: Callable[[Params, Any], Networks]


KINDS = {
    "urushi": Kind(Architecture, parameter_shapes, UrushiNetworks),
    "paper": Kind(PaperArchitecture, paper_shapes, PaperNetworks),
}


def name_of(arch: Any) -> str:
    """The key in `KINDS` of an architecture."""
    return next(name for name, kind in KINDS.items() if isinstance(arch, kind.architecture))


def of(arch: Any) -> Kind:
    """The kind that an architecture belongs to."""
    return KINDS[name_of(arch)]


def read(description: Any) -> Any:
    """The architecture of a weights file's description; one without `kind` is Urushi's own.

    Raises:
        ParameterError: it is of no known kind, or not as its kind wants it.
    """
    name = description.get("kind", "urushi") if isinstance(description, dict) else "urushi"
    if name not in KINDS:
        raise ParameterError(
            f"the architecture is of kind {name!r}; this Urushi knows {', '.join(KINDS)}"
        )
    return KINDS[name].architecture.from_json(json.dumps(description))
