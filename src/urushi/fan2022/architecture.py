"""The paper's networks as chains of blocks, of fixed sizes (Fan et al. 2022, figures 2 and 3)."""

import json
import math
from dataclasses import asdict, dataclass
from typing import ClassVar

import numpy as np

from urushi.errors import ParameterError
from urushi.fan2022 import blocks
from urushi.fan2022.blocks import Block, Linear, Skip, fc, rb

LATENT = 32

#: Initial value of every entry of a latent code.
FIRST_LATENT = 1.0

#: Number of direction inputs of the evaluation network, which precede the latent code.
DIRECTIONS = 6


@dataclass(frozen=True)
class AdamProjection:
    """Options of the projection by Adam (`urushi.fan2022.adam`); the authors' by default.

    Attributes:
        steps: number of steps, up to a million.
        pairs: direction pairs of a step, up to 2^20.
    """

    steps: int = 1000
    pairs: int = 4096

    def __post_init__(self) -> None:
        for name, most in (("steps", 1_000_000), ("pairs", 1 << 20)):
            value = getattr(self, name)
            if type(value) is not int or not 1 <= value <= most:
                raise ParameterError(
                    f"the projection by Adam has {name} = {value!r}; give a whole number from 1 to "
                    f"{most}"
                )


@dataclass(frozen=True)
class PaperArchitecture:
    """The architecture of the paper's networks; their sizes are fixed.

    Attributes:
        adam: how a BRDF is projected to a code. None: by Levenberg-Marquardt, see
            `urushi.fan2022.projection`. A layering network expects codes of the projection that it
            was trained with.
    """

    adam: AdamProjection | None = None
    latent: ClassVar[int] = LATENT

    def to_json(self) -> str:
        """Return kind and projection as the text of a JSON object."""
        options = {} if self.adam is None else {"adam": asdict(self.adam)}
        return json.dumps({"kind": "paper", **options})

    @classmethod
    def from_json(cls, text: str) -> "PaperArchitecture":
        """Read the text that `to_json` returns.

        Raises:
            ParameterError: the text has other entries.
        """
        description = json.loads(text)
        adam = description.pop("adam", None)
        wrong = adam is not None and (not isinstance(adam, dict) or set(adam) != _ADAM_OPTIONS)
        if wrong or description != {"kind": "paper"}:
            raise ParameterError(
                "the paper's architecture takes no options but the projection; it must be "
                '{"kind": "paper"} or {"kind": "paper", "adam": {"steps": ..., "pairs": ...}}'
            )
        return cls(None if adam is None else AdamProjection(**adam))


_ADAM_OPTIONS = {"steps", "pairs"}


def _residual(name: str, n: int) -> Skip:
    """R{RB, FC, RB}."""
    return Skip((*rb(f"{name}.0", n), *fc(f"{name}.1", n, n), *rb(f"{name}.2", n)))


def _evaluation() -> tuple[Block, ...]:
    name, n = "evaluation", 256

    def half(name: str) -> Skip:
        parts = _residual(f"{name}.0", n), *fc(f"{name}.1", n, n), _residual(f"{name}.2", n)
        return Skip(parts)

    middle = half(f"{name}.1.0"), *fc(f"{name}.1.1", n, n), half(f"{name}.1.2")
    return (
        *fc(f"{name}.0", DIRECTIONS + LATENT, n),
        Skip(middle),
        *fc(f"{name}.2", n, n),
        Linear(f"{name}.3", n, 1),
    )


def _layering() -> tuple[Block, ...]:
    name, n = "layering", 512
    middle = (
        *rb(f"{name}.1.0", n),
        *fc(f"{name}.1.1", n, n),
        _residual(f"{name}.1.2", n),
        *fc(f"{name}.1.3", n, n),
        *rb(f"{name}.1.4", n),
    )
    return (
        *fc(f"{name}.0", 2 * LATENT + 2, n),
        Skip(middle),
        *fc(f"{name}.2", n, 128),
        Linear(f"{name}.3", 128, LATENT),
    )


def _proxy() -> tuple[Linear, ...]:
    sizes = (LATENT, 128, 512, 128, 32, 2)
    return tuple(Linear(f"proxy.{i}", sizes[i], sizes[i + 1]) for i in range(len(sizes) - 1))


#: The evaluation network: 1,074,689 parameters.
EVALUATION = _evaluation()

#: The layering network: 1,954,208 parameters.
LAYERING = _layering()

#: The sampling proxy, an MLP with plain ReLUs between its layers (evaluated by `nets.mlp`).
PROXY = _proxy()

PARTS = {"evaluation": EVALUATION, "layering": LAYERING, "proxy": PROXY}


def parameter_shapes(arch: PaperArchitecture) -> dict[str, tuple[int, ...]]:
    """Return every parameter's shape by name."""
    return {name: shape for part in PARTS.values() for name, shape in blocks.shapes(part).items()}


def parameter_count(part: str) -> int:
    """Return the number of parameters of one network, named as in `PARTS`."""
    return sum(math.prod(shape) for shape in blocks.shapes(PARTS[part]).values())


def init(seed: int) -> dict[str, np.ndarray]:
    """Draw initial parameters of all three networks."""
    rng = np.random.default_rng(seed)
    return {name: v for part in PARTS.values() for name, v in blocks.init(part, rng).items()}
