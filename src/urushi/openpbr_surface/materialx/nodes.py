"""MaterialX's elementary nodes on NumPy arrays: arithmetic, channels, logic and patterns.

Values are float64 arrays (..., channels); a constant has no leading axis. Formulas are those of the
MaterialX specification 1.39 and of its standard library. Nodes, or types of them, that are not here
are evaluated by the library's graphs.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from urushi.errors import FileError
from urushi.openpbr_surface.materialx import conversions, noise

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

#: Largest divisor that counts as zero in `burn` and `dodge`.
EPSILON = 1e-8

#: From the values of inputs to the value of a node.
Function = Callable[..., Any]


def _smoothstep(x: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    t = np.clip((x - low) / np.where(high == low, 1, high - low), 0, 1)
    return np.where(x >= high, 1.0, np.where(x <= low, 0.0, t * t * (3 - 2 * t)))


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a * b).sum(axis=-1, keepdims=True)


def _length(a: np.ndarray) -> np.ndarray:
    return np.sqrt(_dot(a, a))


def _blend(mode: Function, divisor: Function = np.ones_like) -> Function:
    """Mixes a function of foreground and background with the background; 0 at a divisor of 0."""

    def blended(fg: np.ndarray, bg: np.ndarray, mix: np.ndarray) -> np.ndarray:
        return np.where(np.abs(divisor(fg)) < EPSILON, 0.0, conversions.mix(bg, mode(fg, bg), mix))

    return blended


def _condition(compare: Function) -> Function:
    """A choice between two values; a node of type boolean has none."""
    return lambda a, b, *choices: np.where(compare(a, b), *(choices or (1.0, 0.0)))


def _ramp(low: np.ndarray, high: np.ndarray, t: np.ndarray) -> np.ndarray:
    return conversions.mix(low, high, np.clip(t, 0, 1))


def _stack(*parts: np.ndarray) -> np.ndarray:
    shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    return np.concatenate([np.broadcast_to(p, (*shape, p.shape[-1])) for p in parts], axis=-1)


def _keep_alpha(colour: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Three channels, and the fourth of `source` if it has one."""
    return _stack(np.broadcast_to(colour, (*colour.shape[:-1], 3)), source[..., 3:])


def _rgb_to_hsv(color: np.ndarray) -> np.ndarray:
    rgb = color[..., :3]
    r, g, b = (rgb[..., k] for k in range(3))
    value, delta = rgb.max(-1), rgb.max(-1) - rgb.min(-1)
    saturation = np.where(value > 0, delta / np.where(value > 0, value, 1), 0)
    step = np.where(delta > 0, delta, 1)
    sextant = np.where(
        r >= value, (g - b) / step, np.where(g >= value, 2 + (b - r) / step, 4 + (r - g) / step)
    )
    hue = np.where(saturation > 0, (sextant / 6) % 1, 0)
    return _keep_alpha(np.stack([hue, saturation, value], -1), color)


def _hsv_to_rgb(color: np.ndarray) -> np.ndarray:
    hue, saturation, value = (color[..., k] for k in range(3))
    saturation = np.where(saturation < 1e-4, 0, saturation)  # grey, as in Open Shading Language
    sextant = 6 * (hue - np.floor(hue))
    channels = []
    for start in (5, 3, 1):  # red, green, blue: the distance of the hue from the channel's range
        k = (start + sextant) % 6
        channels.append(value - value * saturation * np.clip(np.minimum(k, 4 - k), 0, 1))
    return _keep_alpha(np.stack(channels, -1), color)


def _rotate(vector: np.ndarray, amount: np.ndarray) -> np.ndarray:
    angle = np.radians(amount)
    x, y = vector[..., :1], vector[..., 1:]
    s, c = np.sin(angle), np.cos(angle)
    return _stack(c * x + s * y, c * y - s * x)


def _normal_map(
    code: np.ndarray,
    scale: np.ndarray,
    normal: np.ndarray,
    tangent: np.ndarray,
    bitangent: np.ndarray,
) -> np.ndarray:
    decoded = np.where((code == 0).all(-1, keepdims=True), np.array([0, 0, 1.0]), 2 * code - 1)
    x, y = np.split(decoded[..., :2] * scale, 2, axis=-1)
    direction = tangent * x + bitangent * y + normal * decoded[..., 2:]
    return direction / np.maximum(_length(direction), 1e-30)


def _of_numpy(names: str) -> dict[str, Function]:
    """Functions of NumPy by nodes: "NODE=FUNCTION", or one name of both."""
    pairs = (name.partition("=") for name in names.split())
    return {node: getattr(np, name or node) for node, _, name in pairs}


#: The nodes without a graph that are functions of their inputs alone, by category.
_FUNCTIONS: dict[str, Function] = {
    **_of_numpy("floor ceil sign sin cos tan sqrt exp absval=abs asin=arcsin acos=arccos ln=log"),
    **_of_numpy("add subtract multiply divide power atan2=arctan2 min=minimum max=maximum"),
    "modulo": lambda x, y: x - y * np.floor(x / y),
    "round": lambda x: np.floor(x + 0.5),
    "fract": lambda x: x - np.floor(x),
    "invert": lambda x, amount: amount - x,
    "clamp": lambda x, low, high: np.minimum(np.maximum(x, low), high),
    "smoothstep": _smoothstep,
    "remap": lambda x, low, high, out_low, out_high: (
        out_low + (x - low) * (out_high - out_low) / (high - low)
    ),
    "crossproduct": np.cross,
    "dotproduct": _dot,
    "magnitude": _length,
    "normalize": lambda x: x / np.maximum(_length(x), 1e-30),
    "normalmap": _normal_map,
    "rotate2d": _rotate,
    "constant": lambda x: x,
    "dot": lambda x: x,
    "convert": lambda x: x[..., :1],  # to float
    **dict.fromkeys(("combine2", "combine3", "combine4"), _stack),
    "luminance": lambda x, weights: _keep_alpha(_dot(x[..., :3], weights), x),
    "rgbtohsv": _rgb_to_hsv,
    "hsvtorgb": _hsv_to_rgb,
    "mix": lambda fg, bg, mix: conversions.mix(bg, fg, mix),
    "plus": _blend(lambda fg, bg: bg + fg),
    "minus": _blend(lambda fg, bg: bg - fg),
    "difference": _blend(lambda fg, bg: np.abs(bg - fg)),
    "screen": _blend(lambda fg, bg: 1 - (1 - fg) * (1 - bg)),
    "burn": _blend(lambda fg, bg: 1 - (1 - bg) / fg, lambda fg: fg),
    "dodge": _blend(lambda fg, bg: bg / (1 - fg), lambda fg: 1 - fg),
    "inside": lambda x, mask: x * mask,
    "outside": lambda x, mask: x * (1 - mask),
    "not": lambda x: np.where(x != 0, 0.0, 1.0),
    "and": lambda a, b: np.where((a != 0) & (b != 0), 1.0, 0.0),
    "or": lambda a, b: np.where((a != 0) | (b != 0), 1.0, 0.0),
    "ifgreater": _condition(np.greater),
    "ifgreatereq": _condition(np.greater_equal),
    "ifequal": _condition(np.equal),
    "ramplr": lambda left, right, uv: _ramp(left, right, uv[..., :1]),
    "ramptb": lambda top, bottom, uv: _ramp(bottom, top, uv[..., 1:]),
    "splitlr": lambda left, right, x, uv: np.where(uv[..., :1] >= x, right, left),
    "splittb": lambda top, bottom, y, uv: np.where(uv[..., 1:] >= y, top, bottom),
    **dict.fromkeys(("cellnoise2d", "cellnoise3d"), noise.cell),
}


def _number(node: Any, name: str, value: np.ndarray, most: int) -> int:
    """An input that must be the same number at all points, from 0 to `most`."""
    if value.ndim > 1 or not 0 <= value[0] <= most:
        raise FileError(f"{node.where}: {name} must be a constant from 0 to {most}")
    return int(value[0])


def _extract(node: Any, value: np.ndarray, index: np.ndarray) -> np.ndarray:
    channel = _number(node, "index", index, value.shape[-1] - 1)
    return value[..., channel : channel + 1]


def _noise(node: Any, amplitude: np.ndarray, pivot: np.ndarray, position: np.ndarray) -> np.ndarray:
    return noise.perlin(position, CHANNELS[node.type]) * amplitude + pivot


def _fractal(
    node: Any, amplitude: np.ndarray, octaves: np.ndarray, *growth_and_position: np.ndarray
) -> np.ndarray:
    *growth, position = growth_and_position
    count = _number(node, "octaves", octaves, MAX_OCTAVES)
    return noise.fractal(position, CHANNELS[node.type], count, *growth) * amplitude


def _worley(node: Any, position: np.ndarray, jitter: np.ndarray, style: np.ndarray) -> np.ndarray:
    return noise.worley(position, CHANNELS[node.type], jitter, _number(node, "style", style, 1))


def _of_inputs(function: Function) -> Function:
    return lambda node, *inputs: function(*inputs)


#: The nodes without a graph by category: functions of a `graph.Node` and of the values of its
#: inputs, in the order of its definition.
NODES: dict[str, Function] = {tag: _of_inputs(function) for tag, function in _FUNCTIONS.items()} | {
    "extract": _extract,
    **dict.fromkeys(("noise2d", "noise3d"), _noise),
    **dict.fromkeys(("fractal2d", "fractal3d"), _fractal),
    **dict.fromkeys(("worleynoise2d", "worleynoise3d"), _worley),
}
