"""Baked textures on disk, so that a scene that was loaded before is not baked again.

A texture is found by a digest of all that its codes depend on: the weights, the program, and the
values of its inputs at every texel. `textures.store` reads and writes the files. A damaged file is
ignored and written anew, and a folder that cannot be written is not used.
"""

import functools
import hashlib
import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from urushi import files
from urushi.nets.weights import Model
from urushi.textures.store import TexelGrid, TextureStore, read_texture, write_texture

#: Environment variable: the folder of the textures, or "off".
VARIABLE = "URUSHI_CACHE"

#: Largest size of all files [bytes]; the files read least recently are removed.
LIMIT = 4 << 30


def folder() -> Path | None:
    """The folder of the textures; None: they are not kept."""
    chosen = os.environ.get(VARIABLE, "")
    if chosen == "off":
        return None
    if chosen:
        return Path(chosen)
    try:
        caches = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:  # no home
        return None
    return caches / "urushi" / "textures"


def key(description: str, contents: Iterable[np.ndarray]) -> str:
    """The digest of a texture: a description of its settings, and the values of its inputs."""
    digest = hashlib.blake2b(f"{_program()} {description}".encode(), digest_size=16)
    for values in contents:
        digest.update(f"{values.dtype} {values.shape}".encode())
        digest.update(np.ascontiguousarray(values).data)
    return digest.hexdigest()


@functools.cache
def _program() -> str:
    """A digest of Urushi's source code: any change of it may change the codes."""
    digest = hashlib.blake2b(digest_size=16)
    for path in sorted(Path(__file__).parents[1].rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def read(name: str, model: Model) -> tuple[TextureStore, TexelGrid] | None:
    """The texture of a key that these weights have made; None: there is no intact file of it."""
    place = folder()
    if place is None:
        return None
    try:
        store, grid, _ = read_texture(_path(place, name), model)
        os.utime(_path(place, name))
    except OSError:  # a FileError too
        return None
    return store, grid


def write(name: str, store: TextureStore, grid: TexelGrid, model: Model) -> None:
    """Keep a texture under a key, if possible; remove those that were read longest ago."""
    place = folder()
    if place is None:
        return
    try:
        write_texture(_path(files.new_folder(place), name), store, grid, model.fingerprint)
        found, total = [(path.stat(), path) for path in place.glob("*.safetensors")], 0
        for status, path in sorted(found, key=lambda entry: entry[0].st_mtime, reverse=True):
            total += status.st_size
            if total > LIMIT:
                path.unlink(missing_ok=True)
    except OSError:  # a FileError too
        return


def _path(place: Path, name: str) -> Path:
    return place / f"{name}.safetensors"
