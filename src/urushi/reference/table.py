"""Many monochrome stacks of one shape as arrays."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from urushi.errors import ParameterError
from urushi.reference import bottoms, measured_like
from urushi.reference.stack import Conductor, Dielectric, Diffuse, Stack

#: Parameters of each kind of bottom, in the order of its factory's arguments.
BOTTOM_KINDS: dict[str, tuple[Any, tuple[str, ...]]] = {
    "conductor": (bottoms.schlick_conductor, ("alpha", "r0")),
    "conductor_complex": (bottoms.conductor, ("alpha", "eta", "k")),
    "dielectric": (bottoms.dielectric_reflector, ("alpha", "eta")),
    "diffuse": (bottoms.Lambertian, ("reflectance",)),
    "mixture": (
        bottoms.LobeMixture,
        (
            "diffuse",
            "ggx_weight",
            "ggx_alpha",
            "ggx_r0",
            "beckmann_weight",
            "beckmann_alpha",
            "beckmann_r0",
        ),
    ),
    "measured_like": (
        measured_like.MeasuredLike,
        (
            "diffuse",
            "roughness",
            "sheen",
            *(f"{name}_{k}" for k in (1, 2) for name in measured_like.LOBE_PARAMETERS),
        ),
    ),
}


@dataclass(frozen=True)
class StackTable:
    """S monochrome stacks of N coats each over bottoms of one kind.

    Attributes:
        alpha, eta, albedo, sigma_t, g: float32 (S, N), coats from top to bottom.
        kind: a key of `BOTTOM_KINDS`, or "custom" with the walk's `custom` object.
        bottom: the bottom's parameters by name, float32 (S,).
        custom: an object with f_pdf and sample; its colours are indexed by row.
    """

    alpha: np.ndarray
    eta: np.ndarray
    albedo: np.ndarray
    sigma_t: np.ndarray
    g: np.ndarray
    kind: str
    bottom: dict[str, np.ndarray] = field(default_factory=dict)
    custom: Any = None

    def __post_init__(self) -> None:
        names = BOTTOM_KINDS[self.kind][1] if self.kind in BOTTOM_KINDS else ()
        if self.kind != "custom" and tuple(self.bottom) != names:
            raise ParameterError(
                f"a table of '{self.kind}' bottoms needs the parameters {', '.join(names)}"
            )
        for name in ("alpha", "eta", "albedo", "sigma_t", "g"):
            array = np.ascontiguousarray(getattr(self, name), np.float32)
            if array.ndim != 2 or array.shape != np.shape(self.alpha):
                raise ParameterError(f"the table's {name} must have shape (stacks, coats)")
            object.__setattr__(self, name, array)
        columns = {k: np.ascontiguousarray(v, np.float32) for k, v in self.bottom.items()}
        if any(v.shape != (len(self),) for v in columns.values()):
            raise ParameterError("the table's bottom parameters must have one number per stack")
        object.__setattr__(self, "bottom", columns)

    def __len__(self) -> int:
        return len(self.alpha)

    @property
    def coats(self) -> int:
        """Number of coats of every stack."""
        return int(self.alpha.shape[1])


def channel_count(description: object) -> int:
    """3 if any parameter of a description or Stack differs per channel, else 1."""
    parts = (
        (*description.coats, description.bottom)
        if isinstance(description, Stack)
        else (description,)
    )
    known = (Conductor, Dielectric, Diffuse)
    for part in parts:
        if part is parts[-1] and not isinstance(part, known):
            return 3
        if any(isinstance(value, tuple) for value in vars(part).values()):
            return 3
    return 1


def bottom_columns(
    description: Conductor | Dielectric | Diffuse, channels: int
) -> tuple[str, dict[str, np.ndarray]]:
    """The kind of a described bottom and its parameters as float32 (channels,)."""
    if isinstance(description, Conductor):
        kind = "conductor" if description.r0 is not None else "conductor_complex"
    else:
        kind = "dielectric" if isinstance(description, Dielectric) else "diffuse"
    names = BOTTOM_KINDS[kind][1]
    columns = {
        name: np.broadcast_to(np.float32(getattr(description, name)), (channels,)) for name in names
    }
    return kind, columns


def from_stack(stack: Stack) -> StackTable:
    """The table of a Stack's channels: three rows, or one if all channels are equal."""
    channels = channel_count(stack)
    coats: dict[str, Any] = {
        name: np.stack(
            [np.broadcast_to(getattr(coat, name), (channels,)) for coat in stack.coats], axis=1
        )
        for name in ("alpha", "eta", "albedo", "sigma_t", "g")
    }
    if not isinstance(stack.bottom, Conductor | Dielectric | Diffuse):
        return StackTable(**coats, kind="custom", custom=stack.bottom)
    kind, columns = bottom_columns(stack.bottom, channels)
    return StackTable(**coats, kind=kind, bottom=columns)
