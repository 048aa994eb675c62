"""Texture files of other versions are refused by a sentence that says what to do."""

import numpy as np
import pytest

from urushi import files
from urushi.errors import FileError
from urushi.textures.store import KIND, read_texture


def written(path, version, fingerprint) -> None:
    """A file of the earlier form: one texel of codes, without shared or constant numbers."""
    description = {"version": version, "weights": fingerprint, "width": 1, "height": 1}
    arrays = {"texels": np.zeros((1, 64), np.uint8), "lowest": np.zeros(18, np.float32)}
    files.write_tensors(path, KIND, description, arrays)


@pytest.mark.parametrize("version", [1, 2, 3, 5])
def test_other_versions_are_refused(version, model, tmp_path):
    path = tmp_path / "former.safetensors"
    written(path, version, model.fingerprint)
    with pytest.raises(FileError, match=f"version {version} of the texture format"):
        read_texture(path, model)
