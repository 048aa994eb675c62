"""Names of the package: each attribute has one meaning."""

from pathlib import Path

import urushi


def test_no_public_name_is_also_a_folder_or_file():
    """The name of a submodule would replace the public attribute once the submodule is imported."""
    inside = {path.stem for path in Path(urushi.__file__).parent.iterdir()}
    assert not inside & set(urushi.__all__)
