"""The files of a scene: meshes and textures that it refers to, written into one folder."""

from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from urushi.files import atomic_write, new_folder
from urushi.render.scenes.mesh import Mesh, write_ply


class Folder:
    """Writes what a scene needs and gives the nodes of its dictionary that refer to it."""

    def __init__(self, path: Path):
        """Write into the folder `path`; FileError where it cannot be made."""
        self.path = new_folder(path).resolve()

    def mesh(self, name: str, mesh: Mesh) -> dict[str, Any]:
        """A shape of the mesh, as a PLY file."""
        file = self.path / f"{name}.ply"
        write_ply(mesh, file)
        return {"type": "ply", "filename": str(file)}

    def texture(self, name: str, values: np.ndarray) -> dict[str, Any]:
        """A texture of (H, W) or (H, W, 3) values, taken as they are; row 0 is at v = 0."""
        return {"type": "bitmap", "filename": self._image(name, values), "raw": True}

    def environment(self, name: str, radiance: np.ndarray) -> dict[str, Any]:
        """A light from all around, (H, W, 3): z in row 0, columns from +y by +x back to +y."""
        turned = mi.ScalarTransform4d().rotate([1, 0, 0], 90)
        return {"type": "envmap", "filename": self._image(name, radiance), "to_world": turned}

    def _image(self, name: str, values: np.ndarray) -> str:
        """Write an EXR file of half floats; returns its path."""
        pixels = np.ascontiguousarray(values, dtype=np.float16)
        file = self.path / f"{name}.exr"
        with atomic_write(file) as temporary:
            mi.Bitmap(pixels if pixels.ndim == 3 else pixels[..., None]).write(str(temporary))
        return str(file)
