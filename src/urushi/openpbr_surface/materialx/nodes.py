"""MaterialX's elementary nodes on NumPy arrays: arithmetic, channels, logic and patterns.

Values are float64 arrays (..., channels); a constant has no leading axis. Formulas are those of the
MaterialX specification 1.39 and of its standard library. Nodes that are not here are evaluated by
the library's graphs, if it has one for them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from urushi.errors import FileError
from urushi.openpbr_surface.materialx import noise

#: Number of channels of each type of value.
CHANNELS = {
    "float": 1,
    "integer": 1,
    "boolean": 1,
    "vector2": 2,
    "color3": 3,
    "vector3": 3,
    "color4": 4,
    "vector4": 4,
}

#: The cure for nodes that cannot be evaluated; `baketextures` comes with the package `materialx`.
BAKE = "bake it into an image, for instance by MaterialX's command baketextures"

#: Largest number of octaves of fractal noise.
MAX_OCTAVES = 16

#: What `burn` and `dodge` take for zero.
EPSILON = 1e-8


@dataclass(frozen=True)
class Call:
    """A node that is evaluated: its category and type, and the function that reads an input."""

    tag: str
    type: str
    where: str
    read: Callable[[str], np.ndarray]

    def __getitem__(self, name: str) -> np.ndarray:
        """The value of an input, or its default."""
        return self.read(name)


Node = Callable[[Call], np.ndarray]

#: The elementary nodes by category.
NODES: dict[str, Node] = {}


def _node(*categories: str) -> Callable[[Node], Node]:
    def register(function: Node) -> Node:
        for category in categories:
            NODES[category] = function
        return function

    return register


def _arithmetic(category: str, function: Callable[..., np.ndarray], *inputs: str) -> None:
    NODES[category] = lambda call: function(*(call[name] for name in inputs))


def _smoothstep(x: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    t = np.clip((x - low) / np.where(high == low, 1, high - low), 0, 1)
    return np.where(x >= high, 1.0, np.where(x <= low, 0.0, t * t * (3 - 2 * t)))


def _blend(mode: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Node:
    """A node that mixes a function of foreground and background with the background."""

    def function(call: Call) -> np.ndarray:
        fg, bg, mix = call["fg"], call["bg"], call["mix"]
        return mix * mode(fg, bg) + (1 - mix) * bg

    return function


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a * b).sum(axis=-1, keepdims=True)


def _length(a: np.ndarray) -> np.ndarray:
    return np.sqrt(_dot(a, a))


for _name in ("add", "subtract", "multiply", "divide"):
    _arithmetic(_name, getattr(np, _name), "in1", "in2")
_UNARY: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "absval": np.abs,
    "floor": np.floor,
    "ceil": np.ceil,
    "round": lambda x: np.floor(x + 0.5),
    "fract": lambda x: x - np.floor(x),
    "sign": np.sign,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "sqrt": np.sqrt,
    "ln": np.log,
    "exp": np.exp,
    "magnitude": _length,
    "normalize": lambda x: x / np.maximum(_length(x), 1e-30),
    "not": lambda x: np.where(x != 0, 0.0, 1.0),
    "dot": lambda x: x,
}
for _name, _function in _UNARY.items():
    _arithmetic(_name, _function, "in")
_arithmetic("modulo", lambda x, y: x - y * np.floor(x / y), "in1", "in2")
_arithmetic("power", np.power, "in1", "in2")
_arithmetic("min", np.minimum, "in1", "in2")
_arithmetic("max", np.maximum, "in1", "in2")
_arithmetic("invert", lambda x, amount: amount - x, "in", "amount")
_arithmetic("atan2", np.arctan2, "iny", "inx")
_arithmetic("clamp", lambda x, low, high: np.minimum(np.maximum(x, low), high), "in", "low", "high")
_arithmetic("smoothstep", _smoothstep, "in", "low", "high")
_arithmetic(
    "remap",
    lambda x, low, high, out_low, out_high: (
        out_low + (x - low) * (out_high - out_low) / (high - low)
    ),
    *("in", "inlow", "inhigh", "outlow", "outhigh"),
)
_arithmetic("dotproduct", _dot, "in1", "in2")
_arithmetic("crossproduct", np.cross, "in1", "in2")
_arithmetic(
    "luminance", lambda x, weights: _keep_alpha(_dot(x[..., :3], weights), x), "in", "lumacoeffs"
)
_arithmetic("mix", lambda fg, bg, mix: bg * (1 - mix) + fg * mix, "fg", "bg", "mix")
_arithmetic("inside", lambda x, mask: x * mask, "in", "mask")
_arithmetic("outside", lambda x, mask: x * (1 - mask), "in", "mask")
_arithmetic("and", lambda a, b: np.where((a != 0) & (b != 0), 1.0, 0.0), "in1", "in2")
_arithmetic("or", lambda a, b: np.where((a != 0) | (b != 0), 1.0, 0.0), "in1", "in2")
_arithmetic("constant", lambda x: x, "value")
NODES["plus"] = _blend(lambda fg, bg: bg + fg)
NODES["minus"] = _blend(lambda fg, bg: bg - fg)
NODES["difference"] = _blend(lambda fg, bg: np.abs(bg - fg))
NODES["screen"] = _blend(lambda fg, bg: 1 - (1 - fg) * (1 - bg))


@_node("burn")
def _burn(call: Call) -> np.ndarray:
    mixed = _blend(lambda fg, bg: 1 - (1 - bg) / fg)(call)
    return np.where(np.abs(call["fg"]) < EPSILON, 0.0, mixed)


@_node("dodge")
def _dodge(call: Call) -> np.ndarray:
    mixed = _blend(lambda fg, bg: bg / (1 - fg))(call)
    return np.where(np.abs(1 - call["fg"]) < EPSILON, 0.0, mixed)


def _condition(compare: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Node:
    return lambda call: np.where(compare(call["value1"], call["value2"]), call["in1"], call["in2"])


NODES["ifgreater"] = _condition(np.greater)
NODES["ifgreatereq"] = _condition(np.greater_equal)
NODES["ifequal"] = _condition(np.equal)


def _keep_alpha(colour: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Three channels, and the fourth of `source` if it has one."""
    colour = np.broadcast_to(colour, (*colour.shape[:-1], 3))
    return np.concatenate([colour, source[..., 3:]], axis=-1)


def _stack(parts: list[np.ndarray]) -> np.ndarray:
    shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    return np.concatenate([np.broadcast_to(p, (*shape, p.shape[-1])) for p in parts], axis=-1)


@_node("combine2", "combine3", "combine4")
def _combine(call: Call) -> np.ndarray:
    parts: list[np.ndarray] = []
    while sum(part.shape[-1] for part in parts) < CHANNELS[call.type]:
        parts.append(call[f"in{len(parts) + 1}"])
    return _stack(parts)


@_node("extract")
def _extract(call: Call) -> np.ndarray:
    source, index = call["in"], call["index"]
    if index.ndim > 1 or not 0 <= index[0] < source.shape[-1]:
        raise FileError(f"{call.where}: its index must be a constant, a channel of its input")
    channel = int(index[0])
    return source[..., channel : channel + 1]


@_node("convert")
def _convert(call: Call) -> np.ndarray:
    """Fewer channels are the first; a missing alpha is 1, other missing channels are 0."""
    source, channels = call["in"], CHANNELS[call.type]
    have = source.shape[-1]
    if call.type == "boolean":
        return np.where(source[..., :1] != 0, 1.0, 0.0)
    if have == 1 or have >= channels:
        return source if have == 1 else source[..., :channels]
    fill = 1.0 if call.type in ("color4", "vector4") and have == 3 else 0.0
    return _stack([source, *[np.full(1, fill)] * (channels - have)])


@_node("rgbtohsv")
def _rgb_to_hsv(call: Call) -> np.ndarray:
    rgb = call["in"][..., :3]
    r, g, b = (rgb[..., k] for k in range(3))
    value, delta = rgb.max(-1), rgb.max(-1) - rgb.min(-1)
    saturation = np.where(value > 0, delta / np.where(value > 0, value, 1), 0)
    step = np.where(delta > 0, delta, 1)
    sextant = np.where(
        r >= value, (g - b) / step, np.where(g >= value, 2 + (b - r) / step, 4 + (r - g) / step)
    )
    hue = np.where(saturation > 0, (sextant / 6) % 1, 0)
    return _keep_alpha(np.stack([hue, saturation, value], -1), call["in"])


@_node("hsvtorgb")
def _hsv_to_rgb(call: Call) -> np.ndarray:
    hue, saturation, value = (call["in"][..., k] for k in range(3))
    sextant = 6 * (hue - np.floor(hue))
    channels = []
    for start in (5, 3, 1):  # red, green, blue: the distance of the hue from the channel's range
        k = (start + sextant) % 6
        channels.append(value - value * saturation * np.clip(np.minimum(k, 4 - k), 0, 1))
    return _keep_alpha(np.stack(channels, -1), call["in"])


@_node("rotate2d")
def _rotate(call: Call) -> np.ndarray:
    angle = np.radians(call["amount"])
    x, y = call["in"][..., :1], call["in"][..., 1:]
    s, c = np.sin(angle), np.cos(angle)
    return _stack([c * x + s * y, c * y - s * x])


@_node("normalmap")
def _normal_map(call: Call) -> np.ndarray:
    """The normal in the tangent frame, which is the frame of all vectors here."""
    code, scale = call["in"], call["scale"]
    if scale.shape[-1] == 1:
        scale = _stack([scale, scale])
    decoded = np.where((code == 0).all(-1, keepdims=True), np.array([0, 0, 1.0]), 2 * code - 1)
    normal = _stack([decoded[..., :2] * scale, decoded[..., 2:]])
    return normal / np.maximum(_length(normal), 1e-30)


def _along(call: Call) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The coordinate of a ramp or a split, and its values at the lower and at the upper end."""
    if call.tag.endswith("lr"):
        return call["texcoord"][..., :1], call["valuel"], call["valuer"]
    return call["texcoord"][..., 1:], call["valueb"], call["valuet"]


@_node("ramplr", "ramptb")
def _ramp(call: Call) -> np.ndarray:
    at, low, high = _along(call)
    t = np.clip(at, 0, 1)
    return low * (1 - t) + high * t


@_node("splitlr", "splittb")
def _split(call: Call) -> np.ndarray:
    at, low, high = _along(call)
    return np.where(at >= call["center"], high, low)


def _place(call: Call) -> np.ndarray:
    """The position (..., 2 or 3) that a noise is evaluated at."""
    return call["texcoord" if call.tag.endswith("2d") else "position"]


@_node("noise2d", "noise3d")
def _noise(call: Call) -> np.ndarray:
    value = noise.perlin(_place(call), CHANNELS[call.type])
    return value * call["amplitude"] + call["pivot"]


@_node("fractal2d", "fractal3d")
def _fractal(call: Call) -> np.ndarray:
    octaves = call["octaves"]
    if octaves.ndim > 1 or not 0 <= octaves[0] <= MAX_OCTAVES:
        raise FileError(f"{call.where}: octaves must be a constant from 0 to {MAX_OCTAVES}")
    value = noise.fractal(
        _place(call), CHANNELS[call.type], int(octaves[0]), call["lacunarity"], call["diminish"]
    )
    return value * call["amplitude"]


@_node("cellnoise2d", "cellnoise3d")
def _cell_noise(call: Call) -> np.ndarray:
    return noise.cell(_place(call))


@_node("worleynoise2d", "worleynoise3d")
def _worley_noise(call: Call) -> np.ndarray:
    style = call["style"]
    if style.ndim > 1 or style[0] not in (0, 1):
        raise FileError(f"{call.where}: style must be the constant 0 or 1")
    return noise.worley(_place(call), CHANNELS[call.type], call["jitter"], int(style[0]))
