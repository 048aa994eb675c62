"""Sizes of the networks as one value; names, shapes and initial values of their parameters."""

import itertools
import json
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from urushi.errors import ParameterError
from urushi.nets.features import COAT_FEATURES, DIRECTION_FEATURES
from urushi.nets.lobe import LOBE_FEATURES, NUMBERS
from urushi.nets.mlp import POLYNOMIALS

#: Features of wi that the sampler sees, for networks of one GGX width or two.
ANGLE_FEATURES = {1: 2, 2: 4}

#: The networks. Each is a multilayer perceptron; its name begins the names of its parameters.
PARTS = ("decoder", "encoder", "layerer", "sampler")

#: Parameter that turns a latent code into factors of the decoder's first layer, see
#: `decoder.first_layer`.
SCALE = "decoder.scale"

#: Parameters that are stored but not trained: statistics that normalise the encoder's input.
FIXED = ("encoder.input_mean", "encoder.input_scale")

ACTIVATIONS = (*POLYNOMIALS, "relu")


@dataclass(frozen=True)
class Architecture:
    """Sizes of the four networks.

    Attributes:
        latent: size of one channel's latent code; the first number after its lobe is a gain.
        decoder, encoder, layerer, sampler: widths of the hidden layers, at least one each.
        lobes: number of microfacet lobes in the proposal beside the code's own; it has a cosine
            lobe as well.
        activation: one of `ACTIVATIONS`, for all hidden layers (see `mlp.activate`).
        probes: number of probe pairs, at which the encoder needs the values of a BRDF.
        widths: GGX widths of a surface: 1 for isotropic BRDFs; 2 for those that are symmetric about
            the xz and the yz plane.
    """

    latent: int = 32
    decoder: tuple[int, ...] = (64, 64, 64)
    encoder: tuple[int, ...] = (256, 256)
    layerer: tuple[int, ...] = (192, 192, 192)
    sampler: tuple[int, ...] = (32, 32)
    lobes: int = 2
    activation: str = "smoothstep"
    probes: int = 192
    widths: int = 1

    @property
    def lobe(self) -> int:
        """Number of numbers of a code that describe its analytic lobe, see `nets.lobe`."""
        return len(NUMBERS[self.widths])

    def __post_init__(self) -> None:
        if self.widths not in NUMBERS:
            raise ParameterError(
                f"architecture's widths is {self.widths!r}; it must be 1 (isotropic) or 2"
            )
        for name in ("latent", "lobes", "probes"):
            value = getattr(self, name)
            if not _positive(value):
                raise ParameterError(
                    f"architecture's {name} is {value!r}; it must be a positive integer"
                )
        if self.latent < self.lobe + 2:
            raise ParameterError(
                f"architecture's latent is {self.latent!r}; a code has {self.lobe} numbers for its "
                "lobe and at least two more"
            )
        for name in PARTS:
            widths = getattr(self, name)
            if not (isinstance(widths, tuple | list) and widths and all(map(_positive, widths))):
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
        """Return the sizes as a JSON object; `widths` is left out if it is 1."""
        entries: dict[str, Any] = asdict(self)
        if self.widths == 1:
            del entries["widths"]
        return json.dumps(entries | {"lobe": self.lobe})

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
            raise ParameterError(f"the architecture is not valid JSON: {error}") from error
        names = {entry.name for entry in fields(cls)} | {"lobe"}
        if not isinstance(entries, dict) or set(entries) | {"widths"} != names:
            raise ParameterError(
                "the architecture must be a JSON object with exactly the fields "
                + ", ".join(sorted(names))
            )
        lobe = entries.pop("lobe")
        architecture = cls(**entries)
        if lobe != architecture.lobe:
            raise ParameterError(
                f"architecture's lobe is {lobe!r}; this version of Urushi has {architecture.lobe} "
                "numbers"
            )
        return architecture


def _positive(value: object) -> bool:
    """Whether a value is a positive integer that is small enough for a size."""
    return isinstance(value, int) and not isinstance(value, bool) and 0 < value <= 1 << 16


def layer_sizes(arch: Architecture, part: str) -> tuple[int, ...]:
    """Return the sizes of one network's input, hidden layers and output."""
    rest, widths = arch.latent - arch.lobe, arch.widths
    inputs = {
        "decoder": rest - 1 + DIRECTION_FEATURES[widths],  # the gain bypasses it
        "encoder": arch.probes,
        "layerer": rest + LOBE_FEATURES[widths] + COAT_FEATURES[widths],
        "sampler": rest + LOBE_FEATURES[widths] + ANGLE_FEATURES[widths],
    }
    outputs = {
        "decoder": 1,
        "encoder": rest,
        "layerer": rest,
        "sampler": (1 + widths) * arch.lobes + 2,
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
    shapes[SCALE] = (arch.latent - arch.lobe - 1, arch.decoder[0])
    return shapes | dict.fromkeys(FIXED, (arch.probes,))


def init(arch: Architecture, seed: int) -> dict[str, np.ndarray]:
    """Draw initial float32 parameters: He et al. (2015) for hidden layers, zero biases.

    Output layers start smaller, and codes do not scale the decoder's first layer. At first the
    layerer therefore hardly changes the bottom's latent code, the decoder gives about 1, and the
    sampler gives similar weights to all lobes. The encoder's input statistics are rough constants:
    set them from data with `encoder.input_statistics`.
    """
    rng = np.random.default_rng(seed)
    output_gain = {"decoder": 0.3, "encoder": 1.0, "layerer": 0.1, "sampler": 0.1}
    params = {k: np.zeros(shape, np.float32) for k, shape in parameter_shapes(arch).items()}
    for part, gain in output_gain.items():
        last = len(getattr(arch, part))
        for index in range(last + 1):
            weight = params[f"{part}.{index}.weight"]
            deviation = (gain if index == last else np.sqrt(2.0)) / np.sqrt(len(weight))
            weight[:] = rng.standard_normal(weight.shape) * deviation
    params["encoder.input_mean"] -= 2
    params["encoder.input_scale"] += 2
    return params
