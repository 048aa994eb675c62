"""Texture files of former networks and versions are refused by a sentence that says what to do."""

import numpy as np
import pytest

from urushi import files
from urushi.errors import FileError
from urushi.textures import file


def written(path, version, fingerprint) -> None:
    """A file of the earlier form: one texel of codes, without shared or constant numbers."""
    description = {"version": version, "weights": fingerprint, "width": 1, "height": 1}
    arrays = {"texels": np.zeros((1, 64), np.uint8), "lowest": np.zeros(18, np.float32)}
    files.write_tensors(path, file.KIND, description, arrays)


@pytest.mark.parametrize(
    ("fingerprint", "name"), [("18db0cb6471c", "base"), ("670684d2b9d0", "small")]
)
@pytest.mark.parametrize("version", [1, 2, 3])
def test_former_weights_name_the_version_that_reads_the_file(
    fingerprint, name, version, model, tmp_path
):
    path = tmp_path / "former.safetensors"
    written(path, version, fingerprint)
    with pytest.raises(FileError, match=f"former weights '{name}'; Urushi .* 3078021") as caught:
        file.read(path, model)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("version", [1, 2, 4])
def test_other_versions_are_refused(version, model, tmp_path):
    path = tmp_path / "former.safetensors"
    written(path, version, model.fingerprint)
    with pytest.raises(FileError, match=f"version {version} of the texture format"):
        file.read(path, model)
