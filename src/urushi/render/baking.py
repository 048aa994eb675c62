"""From a coat's parameters and the BSDF under it to latent codes, constant or a texture of them."""

import mitsuba as mi
import numpy as np

from urushi.errors import ParameterError
from urushi.material.energy import limit
from urushi.material.texture import encode_texels, encoded, layer_texels
from urushi.nets.weights import Model
from urushi.render import probing, spectrum
from urushi.render.latents import ConstantLatents, TexturedLatents
from urushi.render.parameters import CoatParameters, is_varying

#: Texels per side of the latent texture for textures that have no resolution of their own, and
#: the largest side that is chosen without being asked for.
PROCEDURAL, LARGEST = 256, 1024

#: Texels whose bottom is probed at once, and whose coat is layered at once: both bound memory.
PROBED, LAYERED = 1 << 13, 1 << 18


def bake(
    model: Model, coat: CoatParameters, bottom: "mi.BSDF", resolution: int
) -> ConstantLatents | TexturedLatents:
    """Encode the bottom and layer the coat on it; resolution: texels per side, 0 to choose.

    Raises:
        ParameterError: a parameter is out of range, or the bottom gives what no BRDF gives.
    """
    textures = [*coat.varying, *varying_textures(bottom)]
    shape = texture_shape(textures, bottom, resolution)
    encode = _encoder(model, coat.where, bottom, shape)
    if shape is None:
        return ConstantLatents(model, _layer(model, coat, encode, np.full((1, 2), 0.5))[0])
    width, height = shape
    uv = texel_centres(width, height)
    parts = [
        _layer(model, coat, encode, uv[start : start + LAYERED]).astype(np.float16)
        for start in range(0, len(uv), LAYERED)
    ]
    latents = np.concatenate(parts)
    return TexturedLatents(model, latents.reshape(height, width, *latents.shape[1:]))


def check(coat: CoatParameters) -> None:
    """Look at the coat's parameters everywhere.

    Raises:
        ParameterError: one is out of range.
    """
    if any(texture.class_name() == "MeshAttribute" for texture in coat.varying):
        return  # known on a mesh only; the walk clips what it finds there
    sizes = [_texture_size(texture) for texture in coat.varying]
    width, height = (min(max(side), LARGEST) for side in zip((1, 1), *sizes, strict=True))
    coat.table(texel_centres(width, height))


def texel_centres(width: int, height: int) -> np.ndarray:
    """Points uv (width * height, 2) in the unit square, row by row."""
    x, y = (np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)


def texture_shape(
    textures: list["mi.Texture"], bottom: "mi.BSDF", resolution: int
) -> tuple[int, int] | None:
    """Width and height of the latent texture that does the textures justice; None: constant."""
    sizes = [_texture_size(texture) for texture in textures]
    nested = getattr(bottom, "latents", None)
    if nested is not None and nested.resolution is not None:
        sizes.append(nested.resolution)
    if not sizes:
        return None
    if resolution:
        return resolution, resolution
    width, height = (min(max(side), LARGEST) for side in zip(*sizes, strict=True))
    return width, height


def varying_textures(root: "mi.Object") -> list["mi.Texture"]:
    """The textures that depend on the position, anywhere in a scene object."""
    found, seen, waiting = [], set(), [root]
    while waiting:
        node = waiting.pop()
        if id(node) in seen:
            continue
        seen.add(id(node))
        if isinstance(node, mi.Texture) and is_varying(node):
            found.append(node)
        waiting += _children(node)
    return found


def _children(node: "mi.Object") -> list["mi.Object"]:
    children = []

    class Collector(mi.TraversalCallback):
        def put(self, name, value, flags, cpptype=None):
            if isinstance(value, mi.Object):
                children.append(value)

        def put_value(self, name, value, flags, cpptype=None):
            pass

        def put_object(self, name, value, flags):
            if value is not None:
                children.append(value)

    node.traverse(Collector())
    return children


def _texture_size(texture: "mi.Texture") -> tuple[int, int]:
    """Texels over the unit square of uv, repetitions by the texture's transform included."""
    if texture.class_name() == "MeshAttribute":
        raise ParameterError(
            "neural_layered cannot bake mesh attributes, which are not given over uv; "
            "use a texture, or the plugin 'layered'"
        )
    width, height = texture.resolution()
    if width * height <= 1:
        return PROCEDURAL, PROCEDURAL
    parameters = mi.traverse(texture)
    if "to_uv" in parameters:
        scale = np.abs(np.asarray(parameters["to_uv"].matrix.numpy()).reshape(3, 3))
        return tuple(
            max(round(side * scale[i, :2].max()), 1) for i, side in enumerate((width, height))
        )
    return width, height


def _layer(model: Model, coat: CoatParameters, encode, uv: np.ndarray) -> np.ndarray:
    """Latent codes (M, C, 32) at points uv (M, 2)."""
    table, bottom = coat.table(uv), encode(uv)
    if len(bottom) > 1:
        return layer_texels(model, bottom, eta=coat.eta, **table)
    # Over one bottom, equal parameters give equal codes: patterns have few distinct texels.
    first, label = distinct(np.concatenate(list(table.values()), axis=1))
    rows = {name: values[first] for name, values in table.items()}
    return layer_texels(model, bottom, eta=coat.eta, **rows)[label]


def distinct(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices of rows (M, K) that stand for all, and of each row's among these (M,)."""
    order = np.lexsort(rows.T)
    change = (np.diff(rows[order], axis=0) != 0).any(axis=1)
    label = np.empty(len(rows), np.intp)
    label[order] = np.concatenate([[0], np.cumsum(change)])
    return order[np.concatenate([[True], change])], label


def _encoder(model: Model, where: str, bottom: "mi.BSDF", shape: tuple[int, int] | None):
    """A function from points uv (M, 2) to the bottom's latent codes (M or 1, C, 32)."""
    nested = getattr(bottom, "latents", None)
    textured = bool(varying_textures(bottom))
    if nested is not None and bottom.model.fingerprint == model.fingerprint:
        first = nested.at(np.full((1, 2), 0.5))
        if first.shape[1] == spectrum.channel_count():
            return nested.at if nested.resolution else lambda uv: first
    wi, wo = model.networks.pairs()
    if shape is None or not textured:
        once = encode_texels(model, probing.read(bottom, wi, wo, where).T)[None]
        return lambda uv: once
    repeats = probing.repeats(bottom, wi, wo, shape[0] * shape[1])

    def probed(uv: np.ndarray) -> np.ndarray:
        f = probing.symmetric(bottom, wi, wo, uv, 2, repeats)
        return encoded(model, np.moveaxis(probing.checked(f, where), -1, 1))

    def encode(uv: np.ndarray) -> np.ndarray:
        parts = [probed(uv[start : start + PROBED]) for start in range(0, len(uv), PROBED)]
        return limit(model, np.concatenate(parts))

    return encode
