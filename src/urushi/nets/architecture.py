"""Sizes of the networks as one value; names, shapes and initial values of their parameters."""

import itertools
import json
from dataclasses import asdict, dataclass, fields

import numpy as np

from urushi.errors import ParameterError
from urushi.nets.features import COAT_INPUTS, COAT_NUMBERS, DIRECTION_FEATURES
from urushi.nets.lobe import LOBE_FEATURES, LOBE_NUMBERS
from urushi.nets.mlp import POLYNOMIALS

#: The networks. Each is a multilayer perceptron; its name begins the names of its parameters.
PARTS = ("decoder", "encoder", "layerer", "sampler")

#: Parameter that turns a latent code into factors of the decoder's first layer, see
#: `decoder.first_layer`.
SCALE = "decoder.scale"


def code_names(layer: int) -> tuple[str, str]:
    """Names of the parameters by which a code scales and shifts a hidden layer of the decoder.

    layer: from 1; the first layer has `SCALE`, and its weight has rows of the code.
    """
    return f"decoder.{layer}.scale", f"decoder.{layer}.shift"


#: Parameters that are stored but not trained: statistics that normalise the encoder's input.
FIXED = ("encoder.input_mean", "encoder.input_scale")

ACTIVATIONS = (*POLYNOMIALS, "silu", "relu")


@dataclass(frozen=True)
class Architecture:
    """Sizes of the four networks.

    Attributes:
        latent: size of one channel's latent code; the first number after its lobe is a gain.
        decoder, encoder, layerer, sampler: widths of the hidden layers, at least one each.
        lobes: number of microfacet lobes in the proposal, which has a cosine lobe as well.
        activation: one of `ACTIVATIONS`, for all hidden layers (see `mlp.activate`).
        probes: number of probe pairs, at which the encoder needs the values of a BRDF.
        lobe: how many numbers of a code describe its analytic lobe, see `nets.lobe`: six, or none
            if the decoder represents the whole BRDF. With a lobe, the proposal has that lobe too.
    """

    latent: int = 32
    decoder: tuple[int, ...] = (64, 64, 64)
    encoder: tuple[int, ...] = (256, 256)
    layerer: tuple[int, ...] = (192, 192, 192)
    sampler: tuple[int, ...] = (32, 32)
    lobes: int = 2
    activation: str = "smoothstep"
    probes: int = 192
    lobe: int = 0

    def __post_init__(self) -> None:
        for name in ("latent", "lobes", "probes"):
            if not _positive(getattr(self, name)):
                raise ParameterError(
                    f"architecture's {name} is {getattr(self, name)!r}; "
                    "it must be a positive integer"
                )
        if self.lobe not in (0, len(LOBE_NUMBERS)) or self.latent < self.lobe + 2:
            raise ParameterError(
                f"architecture's lobe is {self.lobe!r} of {self.latent} numbers; "
                f"it must be 0 or {len(LOBE_NUMBERS)}, with at least two numbers more in a code"
            )
        for name in PARTS:
            widths = getattr(self, name)
            if (
                not isinstance(widths, tuple | list)
                or not widths
                or not all(map(_positive, widths))
            ):
                raise ParameterError(
                    f"architecture's {name} is {widths!r}; give the hidden layers' widths, "
                    "such as (64, 64)"
                )
            object.__setattr__(self, name, tuple(widths))
        if self.activation not in ACTIVATIONS:
            raise ParameterError(
                f"architecture's activation is {self.activation!r}; choose one of "
                + ", ".join(ACTIVATIONS)
            )

    def to_json(self) -> str:
        """Return the sizes as a JSON object."""
        entries = asdict(self)
        if not self.lobe:  # as older files have it
            del entries["lobe"]
        return json.dumps(entries)

    @classmethod
    def from_json(cls, text: str) -> "Architecture":
        """Read `to_json`'s text.

        Raises:
            ParameterError: the text is no JSON object of exactly these fields, or a value is
                invalid.
        """
        try:
            entries = json.loads(text)
        except ValueError as error:
            raise ParameterError(f"the architecture is no valid JSON: {error}") from error
        names = {field.name for field in fields(cls)}
        if not isinstance(entries, dict) or set(entries) | {"lobe"} != names:
            raise ParameterError(
                "the architecture must be a JSON object with exactly the fields "
                + ", ".join(sorted(names))
            )
        return cls(**entries)


def _positive(value: object) -> bool:
    """Whether a value is a positive integer that is small enough for a size."""
    return isinstance(value, int) and not isinstance(value, bool) and 0 < value <= 1 << 16


def layer_sizes(arch: Architecture, part: str) -> tuple[int, ...]:
    """Return the sizes of one network's input, hidden layers and output."""
    rest, lobe = arch.latent - arch.lobe, LOBE_FEATURES if arch.lobe else 0
    inputs = {
        "decoder": rest - 1 + DIRECTION_FEATURES,  # the gain bypasses it
        "encoder": arch.probes,
        "layerer": rest + lobe + (COAT_NUMBERS if lobe else COAT_INPUTS),
        "sampler": rest + lobe + 2,
    }
    outputs = {
        "decoder": 1,
        "encoder": rest,
        "layerer": rest,
        "sampler": 2 * arch.lobes + (2 if lobe else 1),
    }
    return (inputs[part], *getattr(arch, part), outputs[part])


def parameter_shapes(arch: Architecture) -> dict[str, tuple[int, ...]]:
    """Return every parameter's shape by name, the `FIXED` ones included."""
    shapes: dict[str, tuple[int, ...]] = {}
    for part in PARTS:
        sizes = layer_sizes(arch, part)
        for index, (rows, columns) in enumerate(itertools.pairwise(sizes)):
            shapes[f"{part}.{index}.weight"] = (rows, columns)
            shapes[f"{part}.{index}.bias"] = (columns,)
    shapes |= {name: (arch.latent - arch.lobe - 1, width) for name, width in _of_codes(arch)}
    return shapes | dict.fromkeys(FIXED, (arch.probes,))


def parameter_count(arch: Architecture, part: str) -> int:
    """Return the number of trained parameters of one network."""
    sizes = layer_sizes(arch, part)
    layers = sum((a + 1) * b for a, b in itertools.pairwise(sizes))
    widths = sum(width for _, width in _of_codes(arch)) if part == "decoder" else 0
    return layers + (arch.latent - arch.lobe - 1) * widths


def _of_codes(arch: Architecture) -> list[tuple[str, int]]:
    """Names and widths of the parameters by which codes change the decoder's hidden layers."""
    named = [(SCALE, arch.decoder[0])]
    if arch.lobe:
        for layer, width in enumerate(arch.decoder[1:], 1):
            named += [(name, width) for name in code_names(layer)]
    return named


def init(arch: Architecture, seed: int) -> dict[str, np.ndarray]:
    """Draw initial float32 parameters: He et al. (2015) for hidden layers, zero biases.

    Output layers start smaller, and codes neither scale the decoder's layers nor shift those after
    the first one. At first the layerer therefore hardly
    changes the bottom's latent code, the decoder gives about 1, and the sampler gives similar
    weights to all lobes. The encoder's input statistics are rough constants: set them from data
    with `encoder.input_statistics`.
    """
    rng = np.random.default_rng(seed)
    output_gain = {"decoder": 0.3, "encoder": 1.0, "layerer": 0.1, "sampler": 0.1}
    params: dict[str, np.ndarray] = {}
    for part in PARTS:
        sizes = layer_sizes(arch, part)
        for index, (rows, columns) in enumerate(itertools.pairwise(sizes)):
            last = index == len(sizes) - 2
            deviation = (output_gain[part] if last else np.sqrt(2.0)) / np.sqrt(rows)
            weight = rng.standard_normal((rows, columns)) * deviation
            params[f"{part}.{index}.weight"] = weight.astype(np.float32)
            params[f"{part}.{index}.bias"] = np.zeros(columns, np.float32)
    for name, width in _of_codes(arch):
        params[name] = np.zeros((arch.latent - arch.lobe - 1, width), np.float32)
    params["encoder.input_mean"] = np.full(arch.probes, -2.0, np.float32)
    params["encoder.input_scale"] = np.full(arch.probes, 2.0, np.float32)
    return params
