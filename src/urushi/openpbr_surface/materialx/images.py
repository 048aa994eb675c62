"""Images of a document: files and tiles of files, read by OpenImageIO, and look-ups.

MaterialX's node `hextiledimage` puts images on hexagonal tiles that are turned, scaled and moved at
random (Mikkelsen, Practical Real-Time Hex-Tiling, JCGT 11(2), 2022).
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from urushi.errors import FileError, UrushiError
from urushi.openpbr_surface.materialx.colour_spaces import to_linear_srgb

#: Largest number of pixels of all images of a document together.
MAX_PIXELS = 1 << 26

#: What stands for the tile (u, v) in the name of a file: 1001 + u + 10 v, or u + 1 and v + 1.
TOKENS = {"<UDIM>": r"1(\d\d\d)", "<UVTILE>": r"u(\d{1,3})_v(\d{1,3})"}

#: Size of the texture in tiles.
_TILES = 2 * np.sqrt(3.0)

#: From uv to the grid of triangles of tiles, as rows.
_SKEW = np.array([[1, -np.tan(np.pi / 6)], [0, 2 * np.tan(np.pi / 6)]])

#: Ways to continue an image outside of [0, 1], by MaterialX's names, then USD's.
ADDRESS_MODES = ("periodic", "clamp", "mirror", "constant", "repeat", "black")


@dataclass(frozen=True, eq=False)
class Image:
    """The stored values of a file, or of the tiles that a pattern of files names."""

    pixels: np.ndarray  # float32 (height, width, channels); integers of files are at most 1
    corner: tuple[int, int] = (0, 0)  # texture coordinates of the lower left corner
    tiles: tuple[int, int] = (1, 1)  # the number of tiles along u and v


@dataclass(frozen=True)
class ImageUse:
    """An image that a value depends on."""

    file: str
    space: str  # the colour space of its values, "" for none
    channels: int  # the number that is used
    modes: tuple[str, ...]  # of u and v, see `ADDRESS_MODES`
    blend: bool  # whether pixels are interpolated
    # Rows (2, 3) of the affine map from the surface's uv to the image's; None: it is not affine.
    matrix: tuple[tuple[float, ...], ...] | None


class Images:
    """Reads images once each."""

    def __init__(self, folder: Path):
        """folder: that names are relative to."""
        self._folder = folder
        self._read: dict[str, Image] = {}
        self._pixels = 0
        self._values: dict[tuple[str, str, int], np.ndarray] = {}  # see `values`

    def read(self, name: str, where: str) -> Image:
        """The image of a name; see `TOKENS`."""
        if name not in self._read:
            shown = f"{where}: the image '{name[:80]}'"
            try:
                self._read[name] = self._image(name, shown)
            except UrushiError:
                raise
            except (OSError, ValueError, RuntimeError) as error:
                reason = " ".join(str(error).split())[:160]
                raise FileError(f"{shown} cannot be read: {reason}") from error
        return self._read[name]

    def values(self, use: ImageUse, where: str) -> np.ndarray:
        """Values (height, width, channels) of an image.

        Colours are in linear sRGB. A grey image has equal channels; a missing alpha is 1.
        """
        key = use.file, use.space, use.channels
        if key not in self._values:
            pixels = self.read(use.file, where).pixels
            have = pixels.shape[-1]
            if have < 3 and use.channels >= 3:
                pixels = pixels[..., [0, 0, 0, *range(1, have)]]
            if pixels.shape[-1] < use.channels:
                pixels = np.pad(pixels, ((0, 0), (0, 0), (0, 1)), constant_values=1)
            values = pixels[..., : use.channels]
            if use.space:
                values = to_linear_srgb(values, use.space, where).astype(np.float32)
            self._values[key] = values
        return self._values[key]

    def _image(self, name: str, where: str) -> Image:
        path = (self._folder / name.replace("\\", "/")).resolve()
        files = _tiles(path, where)
        if not files:
            problem = "is not a file" if path.exists() else "does not exist"
            raise FileError(f"{where} {problem}; {path_cure(path)}")
        readers = {tile: _opened(file) for tile, file in files.items()}
        low, high = (tuple(map(f, zip(*readers, strict=True))) for f in (min, max))
        columns, rows = high[0] - low[0] + 1, high[1] - low[1] + 1
        height, width, channels = (
            max(getattr(reader.spec(), name) for reader in readers.values())
            for name in ("height", "width", "nchannels")
        )
        self._pixels += width * columns * height * rows
        if self._pixels > MAX_PIXELS:
            raise FileError(
                f"{where} has {width * columns} x {height * rows} pixels; all images of a document "
                f"may have {MAX_PIXELS >> 20} Mi in total; use smaller ones"
            )
        whole = np.zeros((rows, height, columns, width, channels), np.float32)
        for (u, v), reader in readers.items():
            pixels = _decoded(reader)
            if not np.isfinite(pixels).all():
                raise FileError(
                    f"{where} has pixels that are not finite; repair them, or export it again"
                )
            times = height // pixels.shape[0], width // pixels.shape[1]
            if pixels.shape[0] * times[0] != height or pixels.shape[1] * times[1] != width:
                raise FileError(f"{where} has tiles whose sizes are no multiples; make them equal")
            whole[high[1] - v, :, u - low[0]] = pixels.repeat(times[0], 0).repeat(times[1], 1)
        return Image(whole.reshape(rows * height, columns * width, -1), low, (columns, rows))


def _tiles(path: Path, where: str) -> dict[tuple[int, int], Path]:
    """The files of a name by their tiles; a name without a token is the tile (0, 0)."""
    token = re.search(r"<\w*>", path.name)
    if token is None:
        return {(0, 0): path} if path.is_file() else {}
    expression = TOKENS.get(token[0].upper())
    if expression is None:
        raise FileError(
            f"{where} depends on the geometry by {token[0]}, which is not known here; name one file"
        )
    before, after = (re.escape(x) for x in (path.name[: token.start()], path.name[token.end() :]))
    found = {}
    for file in sorted(path.parent.iterdir()) if path.parent.is_dir() else ():
        if match := re.fullmatch(before + expression + after, file.name):
            u, v = (int(x) - 1 for x in (match.groups() * 2)[:2])
            found[(u % 10, v // 10) if match.lastindex == 1 else (u, v)] = file
    return found


def _opened(path: Path) -> Any:
    """A reader of a file, which knows its size."""
    import OpenImageIO as oiio

    wanted = oiio.ImageSpec()
    wanted.attribute("oiio:UnassociatedAlpha", 1)  # keeps what is stored
    reader = oiio.ImageInput.open(str(path), wanted)
    if reader is None:
        raise OSError(oiio.geterror())
    return reader


def _decoded(reader: Any) -> np.ndarray:
    channels = reader.spec().nchannels
    if channels > 4:
        raise ValueError(f"it has {channels} channels; convert it to grey or RGB")
    pixels = reader.read_image("float")
    if pixels is None:
        raise OSError(reader.geterror())
    return pixels.reshape(*pixels.shape[:2], -1)


def path_cure(path: Path) -> str:
    """What to do about a path that is no file."""
    if path.exists():
        return "it is a folder or a device; name a file"
    other = _other_case(path)
    return "check its path" if other is None else f"'{other}' differs in case only"


def _other_case(path: Path) -> Path | None:
    """An existing path that differs from one in upper and lower case only, if any."""
    parent = path.parent if path.parent.is_dir() else _other_case(path.parent)
    if parent is None or not parent.is_dir():
        return None
    return next((p for p in parent.iterdir() if p.name.casefold() == path.name.casefold()), None)


def sample(
    pixels: np.ndarray,
    uv: np.ndarray,
    modes: tuple[str, ...] = ("periodic", "periodic"),
    blend: bool = True,
    default: np.ndarray | float = 0.0,
) -> np.ndarray:
    """Values (N, channels) of an image at uv (N, 2); the origin is its lower left corner.

    default: number or (channels,), taken outside of [0, 1] where the mode is "constant"; 0 if it
    is "black".
    """
    uv = np.clip(np.nan_to_num(uv), -1e6, 1e6)
    near = []  # the two nearest rows, then columns: indices (N,), and weights (N, 1)
    axes = zip(pixels.shape, modes[::-1], (1 - uv[:, 1], uv[:, 0]), strict=False)
    for size, mode, x in axes:
        x = x * size - 0.5 * blend
        first, f = np.floor(x), (x - np.floor(x))[:, None] * blend
        near.append([(_index(first + k, size, mode), w) for k, w in ((0, 1 - f), (1, f))])
    rows, columns = near
    upper, lower = (sum(pixels[j, i] * w for i, w in columns) * weight for j, weight in rows)
    value = upper + lower
    for axis, mode in enumerate(modes):
        if mode in ("constant", "black"):
            outside = (uv[:, axis] < 0) | (uv[:, axis] > 1)
            value = np.where(outside[:, None], default if mode == "constant" else 0, value)
    return value


def _index(cells: np.ndarray, size: int, mode: str) -> np.ndarray:
    cells = cells.astype(np.int64)
    if mode in ("periodic", "repeat"):
        return cells % size
    if mode == "mirror":
        cells = cells % (2 * size)
        return np.where(cells < size, cells, 2 * size - 1 - cells)
    return np.clip(cells, 0, size - 1)


def _random(cell: np.ndarray) -> np.ndarray:
    """Two random numbers in [0, 1) for each cell (N, 2); shadertoy.com/view/4djSRW."""
    p = (cell + 0.12345)[:, [0, 1, 0]] * (0.1031, 0.1030, 0.0973) % 1
    p = p + (p * (p[:, [1, 2, 0]] + 33.33)).sum(-1, keepdims=True)
    return (p[:, :1] + p[:, 1:]) * p[:, [2, 1]] % 1


def _gain(x: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Schlick, Fast Alternatives to Perlin's Bias and Gain Functions, Graphics Gems IV, 1994."""
    a = (1 / np.clip(r, 0.001, 0.999) - 2) * (1 - 2 * x)
    return np.where(x < 0.5, x / (a + 1), (a - x) / (a - 1))


def hextiles(pixels: np.ndarray, uv: np.ndarray, i: Callable[[str], np.ndarray]) -> np.ndarray:
    """Values (N, channels) of an image (height, width, channels) at uv (N, 2).

    i: the inputs of the node, which give the tiling and how much tiles differ.
    """
    uv = uv * i("tiling")
    skewed = _TILES * uv @ _SKEW.T
    cell, (x, y) = np.floor(skewed), (skewed % 1).T
    upper = x + y >= 1
    corners = np.where(
        upper[:, None, None], [[1, 1], [1, 0], [0, 1]], [[0, 0], [0, 1], [1, 0]]
    )  # of the triangle around each point, the first opposite to its longest side
    weights = np.where(upper, [x + y - 1, 1 - y, 1 - x], [1 - x - y, y, x])
    values = []
    for corner in cell + corners.swapaxes(0, 1):
        centre = corner / _TILES @ np.linalg.inv(_SKEW).T
        random = _random(corner)
        turn = _between(np.radians(i("rotationrange")), random[:, :1] * i("rotation"))
        scale = 1 + (_between(i("scalerange"), random[:, 1:]) - 1) * i("scale")
        shift = _between(i("offsetrange"), random * i("offset"))
        s, c = np.sin(turn), np.cos(turn)
        dx, dy = np.split(uv - centre, 2, axis=-1)
        there = np.concatenate([c * dx - s * dy, s * dx + c * dy], axis=-1) / scale
        values.append(sample(pixels, there + centre + shift))
    tiles = np.stack(values)
    luma = (tiles[..., :3] * i("lumacoeffs")).sum(-1)
    contrast, falloff = i("falloffcontrast")[..., 0], i("falloff")[..., 0]
    factors = np.stack([1 + (luma - 1) * contrast, np.ones_like(luma)])
    of_colour, plain = (_weights(x, weights, falloff)[..., None] for x in factors)
    return np.concatenate(
        [(of_colour * tiles[..., :3]).sum(0), (plain * tiles[..., 3:]).sum(0)], axis=-1
    )


def _between(ends: np.ndarray, t: np.ndarray) -> np.ndarray:
    return ends[..., :1] + (ends[..., 1:] - ends[..., :1]) * t


def _weights(factors: np.ndarray, weights: np.ndarray, falloff: np.ndarray) -> np.ndarray:
    """Weights (3, N) of the three tiles around each point, of sum 1."""
    w = factors * weights**7
    w = w / w.sum(0)
    w = np.where(falloff == 0.5, w, _gain(w, falloff))
    return w / w.sum(0)
